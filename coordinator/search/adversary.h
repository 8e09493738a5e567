// The adversary: looks for the worst designs of a box. Each attack is a design given by levels of
// the box (common/sampling/moves.h) and a constraint that it tries to violate. A step samples every
// attack and its neighbours; what is worse becomes an attack itself, and the least dangerous
// attacks are forgotten.
//
//     attack --flips that make it worse, all at once--> attack --...--> none makes it worse: at
//     rest
//            \-the one worst neighbour----------------> attack
//
// An attack keeps its levels while the box changes, so the worst corners of one box are where the
// look at the next one begins. Some attacks are scouts: they start anew at random designs of all
// kinds when they come to rest, so that no region of the box is left out for good.
#ifndef SOBOX_COORDINATOR_SEARCH_ADVERSARY_H
#define SOBOX_COORDINATOR_SEARCH_ADVERSARY_H

#include "common/numeric/curve_map.h"
#include "common/numeric/verdict.h"
#include "common/sampling/moves.h"
#include "coordinator/search/frame.h"

#include <stdbool.h>
#include <stdint.h>

enum { ADVERSARY_SCOUT_SHARE = 6 }; // one attack of so many is a scout while a box is sought

struct attack {
    uint8_t *levels; // (free variables) 0 .. MOVES_LEVEL_MAX
    uint64_t name;   // hash of levels and target: equal attacks have equal names
    double margin;   // of the target, of the attack itself: measured, or expected where it is new
    uint8_t target;  // constraint
    bool scout;
    bool resting; // no neighbour was worse when it was sampled last
};

struct adversary {
    const struct frame *frame;      // borrowed
    const struct curve_map *curves; // borrowed; of all variables
    uint32_t constraints;           // of the scenario
    uint64_t seed;                  // of where scouts start
    uint32_t most;                  // attacks, scouts among them
    uint32_t scouts;                //
    uint32_t started;               // scouts so far
    uint32_t count;                 //
    struct attack *attacks;         // (most + children) the first `count` are sampled
    uint32_t room;                  // of `attacks`
    struct moves moves;             // the attacks as they travel
};

// What a sampled attack says of boxes near the one it was sampled in: the margin of its target, and
// the slope of that margin over each free variable.
struct attack_view {
    const struct attack *attack;
    const double *slopes; // (free variables) margin a level
    uint64_t former;      // name under which it was sampled: idle variables may have changed it
    bool limits;          // whether nearby boxes are limited by it: it is at a corner, or at rest
};

// How many attacks a step has that is about as long as several other steps of `samples`.
uint32_t adversary_attacks(uint32_t samples, uint32_t per_attack);

// Makes an adversary without attacks. `curves` and `frame` are borrowed. The caller releases it
// with adversary_fini().
void adversary_init(struct adversary *adversary, const struct frame *frame,
                    const struct curve_map *curves, uint32_t constraints, uint32_t samples,
                    uint64_t seed);

// Releases an adversary. A zeroed struct is fine.
void adversary_fini(struct adversary *adversary);

// Takes up an attack on `target` with these levels (free variables), unless it is there already.
void adversary_add(struct adversary *adversary, const uint8_t *levels, uint8_t target,
                   double margin);

// The attacks to begin with: whole groups of curves at their bounds, and scouts.
void adversary_begin(struct adversary *adversary);

// The attacks as a step samples them; borrowed until adversary_complete().
const struct moves *adversary_moves(struct adversary *adversary);

// What adversary_complete() found.
struct adversary_report {
    double margin;     // the least of all samples: below 0 a design of the box is bad
    uint32_t worst;    // the sample that has it
    uint32_t bad;      // samples
    uint32_t climbing; // attacks that have a worse neighbour
};

// Takes the verdicts of a step that sampled adversary_moves() in `box` (all variables), with
// margins. `view` is called with each attack that was sampled.
void adversary_complete(struct adversary *adversary, const struct sampling *sampling,
                        const struct box *box, const struct verdict *verdicts,
                        void (*view)(void *context, const struct attack_view *view), void *context,
                        struct adversary_report *report);

#endif
