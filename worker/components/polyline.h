// A curve with two ordinates, thinned to the points that a polyline needs: from its two ends on,
// the piece that misses the curve most is split where it misses most, until enough is kept or
// nothing is missed by more than the tolerance.
//
//          o                 o  kept          each step costs one look at the two new pieces, so n
//        /   \ . .           .  left out      points are thinned to m in O(n m)
//      .       \   .
//    o           \ . o
#ifndef SOBOX_WORKER_COMPONENTS_POLYLINE_H
#define SOBOX_WORKER_COMPONENTS_POLYLINE_H

#include <stdbool.h>
#include <stdint.h>

enum { POLYLINE_ORDINATE_COUNT = 2 };

struct polyline {
    const double *x;                          // strictly ascending (count)
    const double *y[POLYLINE_ORDINATE_COUNT]; // (count) each
    uint32_t count;                           // at least 1
};

struct polyline_rule {
    double scale[POLYLINE_ORDINATE_COUNT]; // > 0; a miss is |difference| / scale; INFINITY: no care
    double tolerance;                      // >= 0, the greatest miss that is left
    uint32_t point_max;                    // at least 2
};

// Marks in `kept` (count) the points to keep, beside those that it marks already; the ends are kept
// always. Returns how many are kept, which is above `point_max` only when that many were marked.
uint32_t polyline_thin(const struct polyline *line, const struct polyline_rule *rule, bool *kept);

// The greatest miss of the polyline through the kept points, among which are the ends.
double polyline_miss(const struct polyline *line, const struct polyline_rule *rule,
                     const bool *kept);

// The area between the curve and the polyline through the kept points as share of the curve's own:
// for a force over a deformation the part of the energy that lies at another place. 0 for a curve
// without area.
double polyline_misplaced(const struct polyline *line, int ordinate, const bool *kept);

#endif
