// The part of a search that keeps the promise "every" (promise in common/protocol/protocol.h): a
// box without a bad design, attacked before it is certified. Inside this folder only.
//
//     seek -> robust (explore, then consolidate) -> attack -> certify each kind -> done
//                            ^                        | bad        | bad
//                            +------- mend -----------+------------+
#ifndef SOBOX_COORDINATOR_SEARCH_SEARCH_EVERY_H
#define SOBOX_COORDINATOR_SEARCH_SEARCH_EVERY_H

#include "coordinator/search/relax.h"
#include "coordinator/search/robust.h"

struct search;

enum search_every_stage {
    EVERY_NONE, // not begun, or another promise
    EVERY_GROW,
    EVERY_ATTACK,
    EVERY_CERTIFY,
    EVERY_MEND,
    EVERY_RELAX, // towards a box that keeps the promise "curves": attacked, then
    EVERY_SHARE, // looked at by each kind
    EVERY_LOOK,  // at a box that another promise was kept for: nothing follows from it
};

struct search_every {
    enum search_every_stage stage;
    struct robust robust;
    enum search_status status; // EVERY_LOOK: what the search ends with
    struct box box;            // free variables: the best one so far
    uint32_t stage_steps;      // finished in this stage
    uint32_t mends;            // so far
    struct relax relax;        // of the promise "curves"
    double bad_share;          // the greatest of the kinds that EVERY_SHARE has looked at
    double margin;             // least margin found in the box by the attack that came last
    struct box worst;          // all variables: the design that has it, lower equal to upper
    uint8_t *holders; // (2 x all variables) constraint that holds each bound, once it is over
    double *gains;    // (constraints) log-volume for 1 % of each
    uint64_t attacks; // samples of adversarial steps
};

// Begins with these starts (free variables).
void search_every_start(struct search *search, const struct cloud *starts, uint32_t steps);

// Attacks and certifies the whole space of the search: a box in which nothing may move, and which
// is not mended.
void search_every_take(struct search *search);

// Attacks a box (free variables) that is final, to tell the worst design in it.
void search_every_look(struct search *search, const struct box *box, enum search_status status);

// Whether the promise is being worked on; then what to sample next, and the verdicts, are its.
bool search_every_active(const struct search *search);

// Asks for the next step.
void search_every_ask(struct search *search);

// What of the finished step is reported and the next stage.
void search_every_complete(struct search *search, const struct verdict *verdicts);

// Releases. A zeroed struct is fine.
void search_every_fini(struct search_every *every);

#endif
