// How far into its springs' curves the designs of a box come, and so which points of a corridor
// mean nothing: a car that stops after 0.6 m never asks for the force at 1.2 m, and whatever the
// search left as the corridor there is no demand on anybody.
//
//     force |   upper ___________.  .  .  .
//           |        /           |            The spring is pressed to s at most. The force there
//           |       /            |  .         is interpolated between the points on both sides of
//           |   lower __________/. .  .  .    s, so the point behind s matters still, and the next
//           +---|-------|------s-|-----|--    ones do not.
//               0       1        2     3
//
// A point is *reached* when some design passes the point before it (the first point: comes to it).
// Designs are many and simulations are few, so that is known of designs that were simulated: a
// point that is not reached is one that none of REACH_DESIGNS designs of the box reaches, and no
// more is claimed. They are of several kinds, because independent forces average out over a curve
// and cars whose curves are all weak go deepest:
//
//     points   every force uniform in its interval, independently
//     curves   every curve (a spring's direction) at a level of its own between its bounds
//     levels   all axial curves at one level, all lateral ones at another
//     bounds   all axial curves at one bound, all lateral ones at one: the four corners
//
// The same designs tell how many turn beyond 90 degrees, where no spring's line meets the barrier's
// face any more: what such a car did afterwards, it did without a barrier.
//
// Which designs those are follows from scenario, box and seed, and so does the answer: it is found
// again from any run folder, also from one that was written before there was this.
#ifndef SOBOX_COORDINATOR_REPORT_REACH_H
#define SOBOX_COORDINATOR_REPORT_REACH_H

#include "common/numeric/box.h"
#include "common/scenario/scenario.h"

#include <stdbool.h>
#include <stdint.h>

// Designs of each kind. Of the shipped cars with one pair of springs the deepest design stands in a
// corner as a rule: eight times as many designs go no deeper in ten of twelve results, 8 and 23 mm
// in the others. With five pairs they go up to 60 mm deeper.
enum {
    REACH_POINTS = 1024,
    REACH_CURVES = 512,
    REACH_LEVELS = 508,
    REACH_BOUNDS = 4,
    REACH_DESIGNS = REACH_POINTS + REACH_CURVES + REACH_LEVELS + REACH_BOUNDS,
};

// A zeroed struct is one of which nothing is known: everything counts as reached.
struct reach {
    uint32_t spring_count;                       // 0: the model has no springs, or nobody looked
    double deformation_max[SCENARIO_SPRING_MAX]; // [m] in contact, over all designs and cases; 0
                                                 // where the barrier never met the spring
    uint32_t turned;                             // designs that turn beyond 90 degrees, in any case
};

// Simulates designs of the box of a scenario. Of a model without springs nothing is known after it.
void reach_find(struct reach *reach, const struct scenario *scenario, const struct box *box,
                uint64_t seed);

// How many points of a spring are reached, from the first one on: the others are not.
uint32_t reach_points(const struct reach *reach, const struct scenario *scenario, uint32_t spring);

// The point at which the part of a corridor begins that no design comes to: the last one that is
// reached, as no design passes it, or the first one of all; its number of points where there is no
// such part.
uint32_t reach_beyond(const struct reach *reach, const struct scenario *scenario, uint32_t spring);

// Whether a variable is reached; one that is no spring's force always is.
bool reach_variable(const struct reach *reach, const struct scenario *scenario, uint32_t variable);

// Whether all points of all springs are.
bool reach_everything(const struct reach *reach, const struct scenario *scenario);

#endif
