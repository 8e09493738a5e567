// What the user gave a search to begin with: a reference, which must stay inside every box, and a
// start or a start box. Each is looked at first, alone, before anything is sought.
//
//     reference, if any --good--> start or start box, if any --> the whole design space
//         | bad: no box can contain it
//         v
//     refused
#ifndef SOBOX_COORDINATOR_SEARCH_GIVEN_H
#define SOBOX_COORDINATOR_SEARCH_GIVEN_H

#include "common/scenario/scenario.h"
#include "coordinator/search/frame.h"

#include <stdbool.h>

enum given_stage {
    GIVEN_REFERENCE, // is it good?
    GIVEN_START,     // is the start, or anything in the start box, good?
    GIVEN_NONE,      // nothing is left to look at
    GIVEN_REFUSED,   // the reference is bad
};

struct given {
    const struct scenario_search *settings; // borrowed
    const struct frame *frame;              // borrowed
    enum given_stage stage;
    struct box begin; // free variables: what was given last with a good design in it; count 0: none
};

// Begins with the first thing that was given. Both pointers are borrowed. The caller releases it
// with given_fini().
void given_init(struct given *given, const struct scenario_search *settings,
                const struct frame *frame);

// Releases it. A zeroed struct is fine.
void given_fini(struct given *given);

// The box to look at now (free variables): with nothing left the whole design space.
void given_box(const struct given *given, struct box *box);

// Takes whether any design of given_box() is good and goes on with the next thing.
void given_complete(struct given *given, bool any_good);

#endif
