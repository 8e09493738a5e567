// Groups of measured small overlap crashes (tests/data/README.md), each the median of many cars,
// and the curves of one pair of springs that would have moved a car of the group as its median
// moved.
//
// The cars' forces were not measured. Curves come from differentiating the velocities, and the
// model integrates them again, so a group compared with its own curves shows the way through
// curves, not the model (consistency_test.c). Only a group that gave no curve can contradict the
// model (prediction_test.c).
#ifndef SOBOX_TESTS_PHYSICS_MEASURED_H
#define SOBOX_TESTS_PHYSICS_MEASURED_H

#include <stdint.h>

enum { MEASURED_TIMES = 8 };

// One group of tests, to 150 ms.
struct measured {
    double time[MEASURED_TIMES];     // [s]
    double delta_vx[MEASURED_TIMES]; // [m/s] negative: slower
    double delta_vy[MEASURED_TIMES]; // [m/s] away from the barrier
    double travel_x[MEASURED_TIMES]; // [m] forwards
    double travel_y[MEASURED_TIMES]; // [m] away from the barrier
    double spread_x[MEASURED_TIMES]; // [m] mean distance of the group's cars from travel_x, or 0
    double spread_y[MEASURED_TIMES]; // [m]
    double mass;                     // [kg] median, or that of the sedan where none was measured
};

// What a simulated car of a group did, held against the group's motion.
struct measured_outcome {
    double error_x; // [m] mean absolute
    double error_y; // [m]
    double travel;  // [m] of the A-pillar aside
    double length;  // [m] least of the spring, s_L_min
    double yaw;     // [rad] at the end; nothing measured stands beside it
};

// Changes to the simulated car that a test makes to see itself fail.
struct measured_change {
    double mass;        // factor, 1 for none
    double yaw_inertia; // factor, 1 for none
};

// Reads a group of a table under tests/data. Fails the test when it is not there.
void measured_read(const char *table, const char *group, struct measured *measured);

// Makes curves of `source` and lets them move a car of `target`. With `path`, a file's name, the
// simulated and the measured motion are written there, an empty line between them; else NULL.
void measured_simulate(const struct measured *source, const struct measured *target,
                       struct measured_change change, const char *path,
                       struct measured_outcome *outcome);

// Mean over the times of |a - b|, both MEASURED_TIMES values.
double measured_distance(const double *a, const double *b);

#endif
