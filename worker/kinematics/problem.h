// A prepared problem, as the kernels see it: everything that is the same for all designs, worked
// out once. Inside this folder only.
#ifndef SOBOX_WORKER_KINEMATICS_PROBLEM_H
#define SOBOX_WORKER_KINEMATICS_PROBLEM_H

#include "worker/kinematics/kinematics.h"

// One branch of a spring. A piecewise-linear curve through (s_0, F_0) .. (s_n-1, F_n-1) is
//
//     F(s) = c_0 + c_1 m + sum over inner points i of c_i+1 max(m, s_i),    m = min(s, s_n-1)
//
// for s >= s_0: c_1 is the slope of the first segment, c_i+1 how much the slope changes at point i,
// and c_0 makes F(s_0) = F_0. It costs one maximum and one fused multiply-add a point, has no
// branch, and takes as many coefficients as there are forces. Its rounding error is that of the
// slopes: about 1e-16 x deformation / width of the narrowest segment x force.
struct problem_curve {
    uint32_t point_count; // 0 where there is no such branch
    uint32_t point;       // index of s_0 in problem->deformation
    uint32_t value;       // index of its first force, and of its first coefficient
    double acts_above;    // [m] the greatest number below max(s_0, the least s > 0)
    double last;          // [m] s_n-1
};

struct problem_spring {
    double position_x; // [m] P1 from the COG in vehicle axes
    double position_y; // [m]
    double length;     // [m] undeformed
    double reach;      // [m] length - position_x: deformation = reach + place of P2 in vehicle axes
    struct problem_curve load;
    struct problem_curve unload;
};

// What a kernel need not look at: most problems have none of these.
struct problem_features {
    bool rounded;    // the barrier has a rounded edge
    bool unload;     // some spring has an unload branch
    bool late_start; // some curve starts above deformation 0
    bool crushed;    // reloading is KINEMATICS_RELOADING_CRUSHED
    bool events;     // integrator is KINEMATICS_EVENT_VERLET
    bool work;       // the springs' work is wanted
    bool deepest;    // their greatest deformations are wanted
};

struct kinematics_problem {
    double mass;        // [kg]
    double yaw_inertia; // [kg m2]
    double speed;       // [m/s]
    double start_x;     // [m] COG from the face at time 0
    double start_y;     // [m]
    double face_x;      // [m]
    double edge_y;      // [m]
    double far_y;       // [m] edge_y - width
    double edge_radius; // [m]
    double time_step;   // [s]
    double rest;        // [m] growth of a deformation in a step that is taken for none
    uint32_t step_count;
    enum kinematics_integrator integrator;
    struct problem_features features;
    struct problem_spring springs[KINEMATICS_SPRING_MAX];
    uint32_t spring_count;
    double lowest_y;       // [m] the least position_y
    double highest_y;      // [m] the greatest
    double *deformation;   // [m] points of all curves (point_count)
    double *inverse_width; // [1/m] 1 / (deformation[i + 1] - deformation[i]) within a curve
    uint32_t point_count;
    uint32_t value_count;
};

#endif
