// Looks for good designs from which boxes can grow.
//
//     whole space --good ones--> found
//        | none in SEEK_WHOLE_ROUNDS
//        v
//     around the least violated --a good one--> found
//        | none in SEEK_NEAR_ROUNDS
//        v
//     failed: no good design anywhere
//
// First Latin hypercubes over the whole design space. If none of their designs is good, the least
// violated ones are improved: the next samples come from a box around them, which narrows in each
// variable as they draw together (the cross-entropy method of Rubinstein, 1999, with a uniform
// distribution).
#ifndef SOBOX_COORDINATOR_SEARCH_SEEK_H
#define SOBOX_COORDINATOR_SEARCH_SEEK_H

#include "coordinator/search/cloud.h"

#include <stdbool.h>

enum {
    SEEK_WHOLE_ROUNDS = 4,
    SEEK_NEAR_ROUNDS = 60,
    SEEK_ELITE_MAX = 40, // least violated designs that are followed
};

enum seek_state { SEEK_LOOKING, SEEK_FOUND, SEEK_FAILED };

struct seek {
    const struct box *space; // borrowed
    enum seek_state state;
    uint32_t wanted;    // good designs at which it is enough
    uint32_t round;     // rounds finished
    struct box box;     // what to sample in the next round
    struct cloud good;  // good designs found so far
    struct cloud elite; // least violated bad ones, the least first
};

// Starts in the whole of `space`. The caller releases it with seek_fini().
void seek_init(struct seek *seek, const struct box *space, uint32_t wanted);
void seek_fini(struct seek *seek);

// Takes samples that were drawn outside the rounds: of what was given to begin with.
void seek_note(struct seek *seek, const struct cloud *good, const struct cloud *bad,
               uint32_t samples);

// Takes the samples of a round and moves on; `samples` is their number.
void seek_complete(struct seek *seek, const struct cloud *good, const struct cloud *bad,
                   uint32_t samples);

// Adds up to `count` points to `starts` from which boxes may grow: the middle of the good designs,
// where a connected region is widest (it need not be good itself), the good design nearest to it,
// one half-way out, and then those farthest from all chosen ones. Fewer when there are not so many
// good ones; at least one of two or more is good.
void seek_starts(const struct seek *seek, uint32_t count, struct cloud *starts);

#endif
