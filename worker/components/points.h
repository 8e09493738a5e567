// Which discretization points a spring needs to follow a reference curve (thesis 10.3): the places
// at which components begin or end, the ends of the curve, and then one after the other the place
// that a polyline through those so far misses most. Enough there are when nothing is missed by more
// than the tolerance and no more of the energy than that lies at another deformation.
#ifndef SOBOX_WORKER_COMPONENTS_POINTS_H
#define SOBOX_WORKER_COMPONENTS_POINTS_H

#include "worker/components/reference.h"

struct points_rule {
    double tolerance;   // > 0, share of a direction's greatest force, and of its energy
    uint32_t point_max; // 2..SCENARIO_POINT_MAX
};

struct points_choice {
    uint32_t count;                             // 2..SCENARIO_POINT_MAX
    double deformation[SCENARIO_POINT_MAX];     // [m] ascending; but for ends in tenths of mm
    uint32_t of;                                // points that the curve has
    double miss;                                // greatest, share of the greatest force
    double misplaced[SCENARIO_DIRECTION_COUNT]; // share of the energy
};

// Chooses points. `ends` (end_count) are deformations [m], ascending and apart, that are points in
// any case. A direction with less than a tenth of the other one's force is measured by that tenth,
// lest its noise decide. Errors: STATUS_INVALID (the ends alone are more than point_max).
enum status points_choose(struct points_choice *choice, const struct reference *curve,
                          const double *ends, uint32_t end_count, const struct points_rule *rule,
                          struct error *error) MUST_USE;

#endif
