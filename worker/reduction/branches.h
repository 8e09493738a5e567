// The two branches of a spring's curve from what it did over time.
#ifndef SOBOX_WORKER_REDUCTION_BRANCHES_H
#define SOBOX_WORKER_REDUCTION_BRANCHES_H

#include "worker/models/design.h"

// A spring at one time at which its line met the barrier and it was deformed or just touching.
struct branches_sample {
    double deformation;                     // [m] >= 0
    double force[SCENARIO_DIRECTION_COUNT]; // [N] in vehicle axes
};

// Adds the branches of one spring to a design, which has none of it yet. A branch longer than
// `point_max` (>= 2) keeps its ends and the points that a polyline misses most. A spring without
// samples gets a load branch without force. Returns the sum of |force| of the samples that no
// branch holds because the spring passed their deformation before.
double branches_make(const struct branches_sample *samples, uint32_t count, uint32_t point_max,
                     struct design_spring *spring);

#endif
