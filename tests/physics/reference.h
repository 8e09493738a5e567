// The crash by a second road, to hold every integrator of worker/kinematics against: the thesis's
// equations (chapter 6) in the plane's own geometry (points, normals, a line that meets a segment
// or a circle) and in continuous time. Runge-Kutta of fourth order with a small step goes from
// event to event: where a spring touches, slips off, begins or ceases to load, the step is cut at
// that moment by halving. Nothing of the kernel's code, formulas or tolerances is used, so an idea
// that is wrong there cannot be wrong here in the same way.
//
// Loading is a switch on the sign of a rate, so the equations have a discontinuous right side.
// Where neither side of a switch leads away from it, the motion stays on it (Filippov): a spring is
// HELD, with the share of its force that keeps its deformation where it is. A car that has come to
// rest is such a case; so is a spring that another one presses against the barrier.
#ifndef SOBOX_TESTS_PHYSICS_REFERENCE_H
#define SOBOX_TESTS_PHYSICS_REFERENCE_H

#include <stdbool.h>
#include <stdint.h>

enum { REFERENCE_SPRING_MAX = 16, REFERENCE_POINT_MAX = 32 };

struct reference_spring {
    double place[2]; // [m] from the COG in vehicle axes
    double length;   // [m] undeformed
    uint32_t point_count;
    double deformation[REFERENCE_POINT_MAX]; // [m]
    double force[2][REFERENCE_POINT_MAX];    // [N] in vehicle axes
};

struct reference_crash {
    double mass, yaw_inertia, speed; // [kg], [kg m2], [m/s]
    double cog[2];                   // [m] at time 0
    double face_x, edge_y, width;    // [m]
    double radius;                   // [m] of the edge; 0: it is sharp
    bool crushed;                    // a spring loads beyond its greatest deformation only
    double duration;                 // [s]
    double step;                     // [s] the longest
    struct reference_spring springs[REFERENCE_SPRING_MAX]; // the first one sits at the A-pillar
    uint32_t spring_count;
};

struct reference_outcome {
    double length_last, length_min; // [m] of the first spring, its undeformed length if it never
                                    // touched
    double pillar_travel, projection_travel; // [m] y of P1 and of P2, end minus start
    double yaw, yaw_max;                     // [rad] at the end, greatest size
    double travel[2];                        // [m] of the COG
    double velocity[2];                      // [m/s] at the end
    double contact_time;                     // [s] with any spring in contact
    uint32_t events;                         // at which a step was cut
};

struct reference_outcome reference_evaluate(const struct reference_crash *crash);

#endif
