// A box being carved out of a grown one among bad points: the moves that trimming is made of. For
// every bad point it is known how many of the box's sides keep it out and, when there is only one,
// which; and every variable has its points in order. So moving a side costs a visit to the points
// that it moves over and no others, and the point that stops a side from moving out is known
// without a search.
#ifndef SOBOX_COORDINATOR_SEARCH_CARVE_H
#define SOBOX_COORDINATOR_SEARCH_CARVE_H

#include "coordinator/search/cloud.h"
#include "coordinator/search/volume.h"

#include <stdbool.h>

// Side 2v is the lower bound of variable v, side 2v + 1 its upper bound.
enum {
    CARVE_SIDE_NONE = UINT32_MAX,
    CARVE_VARIABLE_MAX = INT16_MAX, // so that two sides of each fit in half of `out`
};

// The bad points, and their order along each variable.
struct carve_points {
    const struct cloud *cloud; // borrowed: all points lie in the grown box
    uint32_t *order;           // (variables x count) points by coordinate, equal ones by number
};

void carve_points_init(struct carve_points *points, const struct cloud *cloud,
                       const struct box *grown, int threads);
void carve_points_fini(struct carve_points *points);

struct carve {
    const struct box *grown;           // borrowed: no side goes beyond it
    const struct carve_points *points; // borrowed
    const double *anchor;              // borrowed (variables): stays inside; NULL until set
    struct box box;                    // as carved so far
    uint32_t *out;     // (points) low half: how many sides keep the point out, 0: it is inside;
                       // high half: the sum of the numbers of those sides, what overflows is lost
    uint32_t *place;   // (sides) in its variable's order: lower sides keep out all before, upper
                       // ones that point and all behind
    bool limited;      // whether limits are kept up, from the first expansion on
    double *limit;     // (sides) how far the side could move out
    uint32_t *support; // (sides) the bad point that stops it there, or CARVE_SIDE_NONE
    uint32_t *loose;   // (sides) those whose support is none any more: what limit is not known of
    uint32_t loose_count;
    bool *is_loose; // (sides)
    double *row;    // (variables) scratch
    double *shares; // (variables) scratch
};

// Starts with the whole of `grown`. The caller releases it with carve_fini().
void carve_init(struct carve *carve, const struct box *grown, const struct carve_points *points);
void carve_fini(struct carve *carve);

// Whether no side keeps the point out.
static inline bool carve_holds(const struct carve *carve, uint32_t point)
{
    return carve->out[point] == 0;
}

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
