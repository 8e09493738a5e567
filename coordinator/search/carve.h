// A box being carved out of a grown one among bad points: the moves that trimming is made of. For
// every bad point it is known how many of the box's sides keep it out and, when there is only one,
// which; so moving a side costs one walk down one column, and the point that stops a side from
// moving out is known without a search.
#ifndef SOBOX_COORDINATOR_SEARCH_CARVE_H
#define SOBOX_COORDINATOR_SEARCH_CARVE_H

#include "coordinator/search/cloud.h"
#include "coordinator/search/volume.h"

// Side 2v is the lower bound of variable v, side 2v + 1 its upper bound.
enum { CARVE_SIDE_NONE = UINT32_MAX };

struct carve {
    const struct box *grown; // borrowed: no side goes beyond it
    const struct cloud *bad; // borrowed: all points lie in grown
    const double *anchor;    // borrowed (variables): stays inside; NULL until set
    struct box box;          // as carved so far
    uint16_t *outside;       // (bad count) sides that keep the point out; 0: it is inside
    uint32_t *sides;         // (bad count) sum of the numbers of those sides
    double *limit;           // (sides) how far the side could move out; valid after expanding
    uint32_t *support;       // (sides) the bad point that stops it there, or CARVE_SIDE_NONE
};

// Starts with the whole of `grown`. The caller releases it with carve_fini().
void carve_init(struct carve *carve, const struct box *grown, const struct cloud *bad);
void carve_fini(struct carve *carve);

// Takes over everything but memory from a carve of the same box and points.
void carve_assign(struct carve *carve, const struct carve *from);

// Moves a side in to `bound`.
void carve_cut(struct carve *carve, uint32_t side, double bound);

// Cuts off bad point `point`, which is inside, at the side that keeps the largest share of its
// width and the anchor, and is not `forbidden`. Returns false when no side can.
bool carve_off(struct carve *carve, uint32_t point, uint32_t forbidden);

// Pushes sides out, the one that gains most first, until each rests on a bad point or on `grown`.
// No bad point is inside, before and after.
void carve_expand(struct carve *carve);

// Gives up the supports of all sides in turn and keeps what enlarges the box. Returns whether
// anything did. Needs a `scratch` carve of the same box and points.
bool carve_improve(struct carve *carve, struct carve *scratch);

#endif
