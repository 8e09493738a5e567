// The largest box whose bad share, by all known bad samples, is what may be: where a trim cuts off
// every bad sample, a fit leaves those inside that cost the least to leave.
//
//     volume    bad samples inside               A path of boxes, from small to large. Each is
//       ^                   o  some, cheap ones  fitted to all samples, and once more to either
//       |               o                        half of them: what the other half says of that
//       |           o  none                      box shows by how much fitting flatters itself.
//       |        o  none, and sides drawn in
//       +------------------------> true bad share
//
// Sides move one at a time to where volume - price x bad volume is largest, past as many bad
// samples as are worth it, until none moves; a lower price gives a larger box. A box fitted to
// samples looks purer by them than it is. Fitted to half of the samples it does so about twice as
// much, and there the other half tells (cross-validation; Stone, 1974). So the estimate is good
// enough to choose from the path, and to say whether a fit is better than a box in balance: in few
// dimensions, where bad samples mark the boundary, it is; in many it finds the gaps between them.
#ifndef SOBOX_COORDINATOR_SEARCH_FIT_H
#define SOBOX_COORDINATOR_SEARCH_FIT_H

#include "coordinator/search/survey.h"

#include <stdbool.h>

struct fit_options {
    const struct cloud *good; // some good samples, to anchor on
    const double *keep;       // (variables) a point that stays inside, or NULL
    double bad_share;         // that the fitted box may have
    int threads;
};

// Fits a box inside `region`. `start`, which lies in the region and contains `keep`, is one to
// begin from. Returns whether a box was found whose estimated bad share is small enough; without
// one `fitted` is as small as the path begins, or `start` where nothing good is known.
bool fit(const struct survey *survey, const struct box *region, const struct box *start,
         const struct fit_options *options, struct box *fitted);

#endif
