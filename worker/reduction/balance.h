// Whether forces and motion of one vehicle belong to each other: a reduction is given the mass, the
// forces and the motion, so they can contradict each other, and must not do so in silence.
//
//     impulse of the forces             motion's mean velocity
//       |<- tenth ->|   ...   |<- tenth ->|
//        mean of J1             mean of J2        mean of J2 - mean of J1 = m (mean v2 - mean v1)
//
// The means over the first and the last tenth of the time obey Newton's law as exactly as the
// values do, but a motion in whole millimetres gives a mean velocity over 15 ms to 0.1 m/s and no
// usable slope between two rows. The same is done for y and, with the moment about the COG, for the
// yaw.
#ifndef SOBOX_WORKER_REDUCTION_BALANCE_H
#define SOBOX_WORKER_REDUCTION_BALANCE_H

#include "common/scenario/scenario.h"
#include "worker/models/motion.h"

#include <stdbool.h>

// All nodes' forces at one time, as the table states them (on either side of the contact).
struct balance_sample {
    double time;                         // [s]
    double force[MOTION_QUANTITY_COUNT]; // [N, N, N m] x and y of the road, moment about the COG
};

// One direction: x, y or yaw.
struct balance_line {
    double impulse; // [N s, N s, N m s] of the forces between the two tenths
    double change;  // [N s, N s, N m s] of the motion's momentum between them
    double ratio;   // impulse / change; NAN where the motion does not change
    double error;   // [m, m, rad] mean absolute error of the motion that the forces alone give
    double moved;   // [m, m, rad] mean distance by which they move the vehicle from free motion
};

struct balance {
    bool known; // the motion has at least three times within those of the forces
    struct balance_line lines[MOTION_QUANTITY_COUNT];
    double speed;                         // [m/s] of the motion's first tenth, towards the barrier
    double span;                          // [s] from the first to the last time of the forces
    double time_first;                    // [s] of the motion
    double place[MOTION_QUANTITY_COUNT];  // [m, m, rad] of the motion at that time
    double travel[MOTION_QUANTITY_COUNT]; // [m, m, rad] greatest distance from there
    double late;       // [s] by how much later forces would explain the error in x
    double force_max;  // [N] greatest |x| of all nodes together
    double force_last; // [N] |x| at the last time
};

// Compares the forces, of `count` >= 2 times in ascending order, with a motion that has all three
// quantities. `sign` is 1 for forces on the vehicle, -1 for forces on the barrier.
void balance_make(struct balance *balance, const struct balance_sample *samples, uint32_t count,
                  double sign, const struct motion *motion, const struct scenario *scenario);

#endif
