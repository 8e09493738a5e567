// What of a design is searched: the free variables. A variable whose bounds are equal, or are both
// held to one value, has a place in every box but nothing to be found.
//
//     all variables    0   1   2   3   4         the design space, in the order of the scenario
//     free variables   0       1       2         variables[] = {0, 2, 4}
//
// The search works with boxes of the free variables; what leaves it has all of them.
#ifndef SOBOX_COORDINATOR_SEARCH_FRAME_H
#define SOBOX_COORDINATOR_SEARCH_FRAME_H

#include "common/numeric/box.h"
#include "common/scenario/scenario.h"

struct frame {
    uint32_t *variables; // (space.count) index of each free variable among all
    struct box space;    // free variables: the design space, narrowed to the bounds that are held
    struct box all;      // all variables: the design space; one held to a value has no width
};

// Finds the free variables of a scenario. The caller releases the frame with frame_fini().
void frame_init(struct frame *frame, const struct scenario *scenario);

// Releases a frame. A zeroed struct is fine.
void frame_fini(struct frame *frame);

// Puts a box of the free variables into one of all variables.
void frame_widen(const struct frame *frame, const struct box *box, struct box *all);

#endif
