// What the kernel knows of a bundle of designs while it takes them through the steps, and the
// geometry of one spring: where its line meets the barrier, and the force of its curves there.
// kernel.h says what the equations are.
#ifndef SOBOX_WORKER_KINEMATICS_KERNEL_STATE_H
#define SOBOX_WORKER_KINEMATICS_KERNEL_STATE_H

#include "worker/kinematics/lanes.h"
#include "worker/kinematics/problem.h"
#include "worker/kinematics/trigonometry.h"

#include <math.h>

enum {
    // Forces of a design that fit the scratch, which is 0.5 MB of coefficients on every path: the
    // widest serves 4096 forces, larger problems take a narrower one.
    KERNEL_COEFFICIENTS = 65536,
    KERNEL_VALUES = KERNEL_COEFFICIENTS / LANES,
    FLIGHT_LOOK = 4, // steps from one look whether all fly freely to the next
};

// What event Verlet keeps of one spring, to find what happened within the step. Step n stands at n
// modulo 2, so that the time before is there without being moved. Of flat barriers deformations and
// edges follow from the poses (kernel_past), and are worked out again where they are asked for.
struct kernel_event {
    uint32_t contact[2]; // bits of the designs that touched
    uint32_t loads[2];   // where the load branch acted
    uint32_t unloads[2]; // the same of the unload branch
    uint32_t loading;    // where it loads now, beyond the curve's first point or not
    uint32_t arc;        // where it touches the arc of a rounded edge
    // Of rounded barriers; the last two in all schemes.
    double deformation[2][LANES]; // [m]
    double edge[2][LANES];        // [m] kernel_place.edge
    double slip[2][LANES];        // [m] kernel_place.slip
    double force_x[LANES]; // [N] without what was made good of the step; kept while recording
    double force_y[LANES]; // [N]
};

// What a bundle keeps of one spring. The parts stand side by side: as arrays of their own they
// would lie whole pages apart, where the machine mistakes a store for a load's.
struct kernel_spring {
    // [m] deformation beyond which the spring loads. The two of event Verlet are of step n modulo 2
    // and lie problem.rest higher; the others have one.
    double reference[2][LANES];
    double force_x[LANES]; // [N] in vehicle axes
    double force_y[LANES]; // [N]
    double place[LANES];   // [m] e
    double work[LANES];    // [J] done on the vehicle so far; the leapfrog schemes keep it twice
    double deepest[LANES]; // [m] greatest deformation in contact; kept only where it is wanted
    double contact[LANES]; // 0 or 1; kept only while recording
    struct kernel_event event;
} __attribute__((aligned(64))); // so that no vector lies across two lines of the cache

// The poses of event Verlet's last two times, step n at n modulo 2, as springs need them.
struct kernel_past {
    double inverse[2][LANES];
    double tangent[2][LANES];
    double axial[2][LANES];
    double crossing[2][LANES];
};

// What one spring may do within a step with its switch: its force has a share of what loading adds
// to it, 1 while its deformation grows, 0 while it does not, or what holds it at rest. The time
// that a step's forces act is 1.
struct kernel_switch {
    double growth[LANES]; // [m] of the deformation in a step, now; -INFINITY: it stays off
    double gain[LANES];   // [m] of the growth, all springs' shares as they were at first
    double share[LANES];
    double mean[LANES];      // of the share
    double force[2][LANES];  // [N] that loading adds, in vehicle axes
    double backwards[LANES]; // [m] of the way of a step that this force adds in x
    double turn[LANES];      // [rad] of its turn
    double lever[LANES];     // growth that a turn adds, less `inverse` times the way in x
    double own[LANES];       // [m] of the growth that this force adds
};

// What a bundle needs beside registers.
struct kernel_scratch {
    double coefficients[KERNEL_COEFFICIENTS] __attribute__((aligned(64)));
    struct kernel_spring springs[KINEMATICS_SPRING_MAX];
    double lateral_work[LANES]; // [J] of all springs' y forces; the leapfrog schemes keep it twice
    // Event Verlet: what was found in the last step, of all springs, and where spring 0 left the
    // face.
    double made_good[3][LANES]; // [N, N, Nm]
    struct lanes_mask left;
    double left_at[LANES]; // [m] deformation
    struct kernel_past past;
    struct kernel_switch switches[KINEMATICS_SPRING_MAX];
};

// Place and change of place. The leapfrog schemes keep the way of one step in `rate`, Runge-Kutta
// the velocity.
struct kernel_motion {
    struct lanes x, y, yaw; // [m] from the face, [m], [rad]
};

// What all springs share at one time.
struct kernel_pose {
    struct lanes magnitude;    // |yaw|
    struct lanes sine, cosine; // of yaw
    struct lanes inverse;      // 1 / cos
    struct lanes tangent;
    struct lanes axial;         // [m] X / cos
    struct lanes crossing;      // [m] y_COG - X tan: where the vehicle's axis meets the face
    struct lanes_mask forwards; // cos > 0
};

// What the springs' switches say together, a bit a design.
struct kernel_bits {
    uint32_t contact; // some spring touches
    uint32_t loading; // some spring loads
    uint32_t idle;    // some spring touches and does not load
};

// Sums over the springs, and what spring 0 did.
struct kernel_load {
    struct lanes x, y;   // [N] in road axes
    struct lanes felt;   // [N] x as an accelerometer has it: without what event Verlet makes good
    struct lanes moment; // [Nm]
    struct lanes_mask contact;
    struct lanes_mask first_contact;
    struct lanes first_deformation; // [m]
    struct lanes first_projection;  // [m] y_P2
    struct kernel_bits switches;    // of event Verlet
};

// Where one spring is.
struct kernel_place {
    struct lanes place;          // [m] e
    struct lanes projection;     // [m] y_P2
    struct lanes edge;           // [m] how far P2 lies inside the nearer end of the face, below 0
                                 // outside; set for rounded barriers only
    struct lanes slip;           // [m] e where it slips off that end; set for rounded barriers only
    struct lanes_mask arc;       // P2 lies on the arc; set for rounded barriers only
    struct lanes normal_x;       // of the barrier at P2; set for rounded barriers only
    struct lanes normal_y;       //
    struct lanes_mask projected; // P2 lies on the barrier
};

// What is gathered on the way.
struct kernel_observed {
    struct lanes yaw_max;
    struct lanes force_max;
    struct lanes force_sum;
    struct lanes contact_steps;
    struct lanes deformation_last;
    struct lanes deformation_max;
};

// One row of a value's matrix for this bundle; missing designs are the first one again, so that
// they are done when the others are.
LANES_INLINE struct lanes kernel_values(const double *values, uint32_t count)
{
    if (count >= LANES) {
        return lanes_load(values);
    }
    double padded[LANES];
    for (uint32_t i = 0; i < LANES; i++) {
        padded[i] = values[i < count ? i : 0];
    }
    return lanes_load(padded);
}

// The coefficients of one branch in one direction (problem.h) from its forces. The two directions
// of a point stand side by side.
LANES_INLINE void kernel_curve_coefficients(const struct kinematics_problem *problem,
                                            const struct problem_curve *curve, uint32_t direction,
                                            uint32_t count, const double *values, size_t stride,
                                            double *coefficients)
{
    const double *deformation = problem->deformation + curve->point;
    const double *inverse_width = problem->inverse_width + curve->point;
    values += (size_t)(curve->value + direction * curve->point_count) * stride;
    coefficients += (size_t)(curve->value + direction) * LANES;
    struct lanes force = kernel_values(values, count);
    struct lanes constant = force;
    struct lanes slope_before = lanes_set(0.0);
    for (uint32_t i = 0; i + 1 < curve->point_count; i++) {
        const struct lanes force_next = kernel_values(values + (i + 1) * stride, count);
        const struct lanes slope =
            lanes_mul(lanes_sub(force_next, force), lanes_set(inverse_width[i]));
        const struct lanes change = lanes_sub(slope, slope_before);
        constant = lanes_fnma(change, lanes_set(deformation[i]), constant);
        lanes_store(coefficients + 2 * (i + 1) * LANES, change);
        slope_before = slope;
        force = force_next;
    }
    lanes_store(coefficients, constant);
}

LANES_INLINE void kernel_coefficients(const struct kinematics_problem *problem, uint32_t count,
                                      const double *values, size_t stride, double *coefficients)
{
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        for (uint32_t direction = 0; direction < 2; direction++) {
            kernel_curve_coefficients(problem, &problem->springs[i].load, direction, count, values,
                                      stride, coefficients);
            if (problem->springs[i].unload.point_count > 0) {
                kernel_curve_coefficients(problem, &problem->springs[i].unload, direction, count,
                                          values, stride, coefficients);
            }
        }
    }
}

// Both forces of a branch at deformation s, where `acts` is set, which has s >= the first point's;
// else 0. The last term is the one that looks at `acts`: there it costs nothing.
LANES_INLINE void kernel_curve(const struct kinematics_problem *problem,
                               const struct problem_curve *curve, const double *coefficients,
                               struct lanes s, struct lanes_mask acts, struct lanes *force_x,
                               struct lanes *force_y)
{
    const double *deformation = problem->deformation + curve->point;
    const double *c = coefficients + (size_t)curve->value * LANES;
    struct lanes ramp = lanes_min(s, lanes_set(curve->last));
    const struct lanes within = ramp;
    struct lanes x = lanes_load(c);
    struct lanes y = lanes_load(c + LANES);
    for (uint32_t i = 1; i + 1 < curve->point_count; i++) {
        c += 2 * LANES;
        x = lanes_fma(ramp, lanes_load(c), x);
        y = lanes_fma(ramp, lanes_load(c + LANES), y);
        ramp = lanes_max(within, lanes_set(deformation[i]));
    }
    c += 2 * LANES;
    *force_x = lanes_keep_fma(acts, ramp, lanes_load(c), x);
    *force_y = lanes_keep_fma(acts, ramp, lanes_load(c + LANES), y);
}

LANES_INLINE struct kernel_pose kernel_pose(const struct kernel_motion *at)
{
    struct kernel_pose pose;
    pose.magnitude = lanes_abs(at->yaw);
    trigonometry_sine_cosine(at->yaw, pose.magnitude, &pose.sine, &pose.cosine);
    pose.inverse = lanes_div(lanes_set(1.0), pose.cosine);
    pose.tangent = lanes_mul(pose.sine, pose.inverse);
    pose.axial = lanes_mul(at->x, pose.inverse);
    pose.crossing = lanes_fnma(at->x, pose.tangent, at->y);
    pose.forwards = lanes_less(lanes_set(0.0), pose.cosine);
    return pose;
}

// Moves P2 from the plane of the face onto the quarter circle where the spring's line crosses the
// plane above it. With the line's distance h from the circle's centre, P2 lies sqrt(r^2 - h^2)
// before the centre's foot on the line. A line that misses the quarter circle has no projection.
//
// The line slips off where it is tangent to the circle: a radius above the centre, with P2 at the
// centre's foot. Turned counter-clockwise it leaves the quarter before, at the end where the
// barrier's side begins: r cos(yaw) above the centre, with P2 r sin(yaw) before the foot. Both are
// smooth functions of the pose, which P2 itself is not (its rate grows beyond all bounds towards
// the tangent), so the moment and the length of slipping off are found from them. A line that
// misses keeps the length at which it would slip off, so that no length jumps.
LANES_INLINE void kernel_round_edge(const struct kinematics_problem *problem,
                                    const struct problem_spring *spring,
                                    const struct kernel_motion *at, const struct kernel_pose *pose,
                                    struct kernel_place *place)
{
    const double radius = problem->edge_radius;
    const struct lanes zero = lanes_set(0.0);
    const struct lanes one = lanes_set(1.0);
    const struct lanes face = place->projection;
    const struct lanes x = lanes_add(at->x, lanes_set(radius)); // COG from the circle's centre
    const struct lanes y = lanes_sub(at->y, lanes_set(problem->edge_y - radius));
    const struct lanes along = lanes_fma(x, pose->cosine, lanes_mul(y, pose->sine));
    const struct lanes across = lanes_fms(x, pose->sine, lanes_mul(y, pose->cosine));
    const struct lanes height = lanes_sub(across, lanes_set(spring->position_y));
    const struct lanes square = lanes_fnma(height, height, lanes_set(radius * radius));
    const struct lanes half_chord = lanes_sqrt(lanes_max(square, zero));
    const struct lanes on_arc = lanes_sub(half_chord, along); // e on the circle
    // P2 from the centre, in vehicle axes (half_chord, -height), turned into road axes.
    const struct lanes arm_x = lanes_fma(half_chord, pose->cosine, lanes_mul(height, pose->sine));
    const struct lanes arm_y = lanes_fms(half_chord, pose->sine, lanes_mul(height, pose->cosine));

    const struct lanes_mask above = lanes_less(lanes_set(problem->edge_y - radius), face);
    const struct lanes_mask meets =
        lanes_and_not_above(lanes_and_not_above(above, zero, square), zero, arm_x);
    const struct lanes_mask turned = lanes_less(zero, pose->sine);
    const struct lanes highest = lanes_select(turned, pose->cosine, one);
    const struct lanes inner = lanes_fma(lanes_set(radius), highest, height);
    const struct lanes outer = lanes_sub(face, lanes_set(problem->far_y));
    const struct lanes slip = lanes_fms(lanes_set(radius), lanes_max(pose->sine, zero), along);
    place->arc = meets;
    place->edge = lanes_min(inner, outer);
    place->slip = lanes_select(lanes_less(outer, inner), place->place, slip);
    place->place = lanes_select(meets, on_arc, lanes_select(above, slip, place->place));
    place->projection =
        lanes_select(meets, lanes_add(arm_y, lanes_set(problem->edge_y - radius)), face);
    place->normal_x = lanes_select(meets, arm_x, one);
    place->normal_y = lanes_select(meets, arm_y, zero);
    place->projected = lanes_or(meets, lanes_and_not(place->projected, above));
}

LANES_INLINE struct kernel_place kernel_place(const struct kinematics_problem *problem,
                                              struct problem_features features,
                                              const struct problem_spring *spring,
                                              const struct kernel_motion *at,
                                              const struct kernel_pose *pose)
{
    const struct lanes position_y = lanes_set(spring->position_y);
    struct kernel_place place;
    place.place = lanes_fms(position_y, pose->tangent, pose->axial);
    place.projection = lanes_fma(position_y, pose->inverse, pose->crossing);
    place.projected = lanes_and_not_above(
        lanes_and_not_above(pose->forwards, place.projection, lanes_set(problem->edge_y)),
        lanes_set(problem->far_y), place.projection);
    place.normal_x = lanes_set(1.0);
    place.normal_y = lanes_set(0.0);
    if (features.rounded) {
        kernel_round_edge(problem, spring, at, pose, &place);
        place.projected = lanes_and(place.projected, pose->forwards);
    }
    return place;
}

// Whether the deformation grows, from the velocity: the barrier's surface comes towards P2 as a
// point of the vehicle. The limit of eq. 6.45 for a vanishing time step.
LANES_INLINE struct lanes_mask kernel_grows(const struct problem_spring *spring,
                                            const struct kernel_place *place,
                                            const struct kernel_pose *pose,
                                            const struct kernel_motion *velocity)
{
    const struct lanes position_y = lanes_set(spring->position_y);
    const struct lanes arm_x =
        lanes_fms(place->place, pose->cosine, lanes_mul(position_y, pose->sine));
    const struct lanes arm_y =
        lanes_fma(place->place, pose->sine, lanes_mul(position_y, pose->cosine));
    const struct lanes velocity_x = lanes_fnma(velocity->yaw, arm_y, velocity->x);
    const struct lanes velocity_y = lanes_fma(velocity->yaw, arm_x, velocity->y);
    const struct lanes away =
        lanes_fma(velocity_x, place->normal_x, lanes_mul(velocity_y, place->normal_y));
    return lanes_less(away, lanes_set(0.0));
}

#endif
