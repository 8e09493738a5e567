// Cuts the bad samples off a box: the largest box that can be found inside a grown one with no
// known bad sample in it.
//
//     +-------------------+ grown        x bad, o good
//     |   x    |   x      |
//     |--------+----------|             every cut side rests on a bad sample, its support:
//     | o    o |  o   x   |             it cannot move out again without taking that sample in
//     |  o  o  |     x    |
//     +--------+----------+
//
// From an anchor, a good point that must stay inside, bad samples are taken in some order and each
// that is still inside is cut off at the side that costs the least width. Afterwards every side is
// pushed out again until a bad sample stops it, which takes back cuts that later cuts made
// unnecessary. Several anchors and orders are tried, the previous box is one more starting point,
// and the largest result is improved by giving up its supports one at a time: the bad sample is cut
// off somewhere else and all sides pushed out again; what does not enlarge the box is undone.
//
// Widths only, no counts of good samples: bad samples of many steps are known by the time it
// matters, and a width is exact where a count of a few hundred samples is noise.
//
// Deterministic: candidates are independent, the winner is the largest, ties go to the first, and
// all arithmetic that decides anything is exactly rounded. The result does not depend on the number
// of threads, nor on the order of the points.
#ifndef SOBOX_COORDINATOR_SEARCH_TRIM_H
#define SOBOX_COORDINATOR_SEARCH_TRIM_H

#include "coordinator/search/cloud.h"

#include <stdbool.h>

struct trim_options {
    uint32_t anchors;   // good points tried, at most TRIM_ANCHOR_MAX
    uint32_t rounds;    // of improvement over all sides; it stops early when a round gains nothing
    const double *keep; // (variables) a point that stays inside, the only anchor; or NULL. `grown`
                        // and `previous` contain it
    double edge; // 0: a cut lies just inside the bad sample; 1: on the last good one before it
    int threads;
};

enum { TRIM_ANCHOR_MAX = 8 };

// Fills in defaults: 2 anchors, 1 round, edge 0, 1 thread.
struct trim_options trim_options_default(void);

// Trims `grown` into `trimmed` (may be the same box). Points outside `grown` do not matter, and
// neither do variables without width. `previous` is a box to start from too, or NULL. The result
// lies inside `grown`, contains a point of `good` and no point of `bad` (unless one sits exactly on
// the anchor). Without a good point inside `grown`, trimmed is grown. Returns whether there was
// one.
bool trim(const struct box *grown, const struct box *previous, const struct cloud *good,
          const struct cloud *bad, const struct trim_options *options, struct box *trimmed);

#endif
