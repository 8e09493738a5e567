// The kernel: a bundle of designs from the first contact to the end. Written once, compiled once
// per instruction set (kernel_plain.c, kernel_avx2.c, kernel_avx512.c); lanes.h says how.
//
// Seen from the vehicle a spring is simple: it lies along the x axis at height p_y, so P2 = (e,
// p_y) with one unknown, its place e. With X = x_COG - x_B, eq. 6.10 to 6.12 and 6.40 become
//
//     e        = p_y tan(yaw) - X / cos(yaw)                 the same two numbers for all springs
//     s        = (length - p_x) + e                          deformation
//     y_P2     = (y_COG - X tan(yaw)) + p_y / cos(yaw)
//     M_z      = e F_y - p_y F_x                             forces in vehicle axes
//     power    = F_x (v_x - p_y omega) + F_y (v_y + e omega) velocities in vehicle axes
//
// so that a spring costs some twenty operations a step and forces are turned into road axes once.
#ifndef SOBOX_WORKER_KINEMATICS_KERNEL_H
#define SOBOX_WORKER_KINEMATICS_KERNEL_H

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
// modulo the number of places, so that the times before are there without being moved.
struct kernel_event {
    double deformation[3][LANES]; // [m]
    double edge[2][LANES];        // [m] kernel_place.edge
    double slip[2][LANES];        // [m] kernel_place.slip; of rounded barriers, in all schemes
    struct lanes_mask loads[2];   // where the load branch acted
    struct lanes_mask unloads[2]; // the same of the unload branch
    struct lanes_mask contact[2]; // where it touched
    double reference[LANES];      // [m] kernel_spring.reference before this time; with `crushed`
    double force_x[LANES]; // [N] without what was made good of the step; kept while recording
    double force_y[LANES]; // [N]
};

// What a bundle keeps of one spring. The parts stand side by side: as arrays of their own they
// would lie whole pages apart, where the machine mistakes a store for a load's.
struct kernel_spring {
    double reference[LANES]; // [m] deformation beyond which the spring loads
    double force_x[LANES];   // [N] in vehicle axes
    double force_y[LANES];   // [N]
    double place[LANES];     // [m] e
    double work[LANES];      // [J] done on the vehicle so far; the leapfrog schemes keep it twice
    double deepest[LANES];   // [m] greatest deformation in contact; kept only where it is wanted
    double contact[LANES];   // 0 or 1; kept only while recording
    struct kernel_event event;
} __attribute__((aligned(64))); // so that no vector lies across two lines of the cache

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

// Sums over the springs, and what spring 0 did.
struct kernel_load {
    struct lanes x, y;   // [N] in road axes
    struct lanes felt;   // [N] x as an accelerometer has it: without what event Verlet makes good
    struct lanes moment; // [Nm]
    struct lanes_mask contact;
    struct lanes_mask first_contact;
    struct lanes first_deformation; // [m]
    struct lanes first_projection;  // [m] y_P2
};

// Where one spring is.
struct kernel_place {
    struct lanes place;          // [m] e
    struct lanes projection;     // [m] y_P2
    struct lanes edge;           // [m] y_P2; for rounded barriers the margin to the nearer end
    struct lanes slip;           // [m] e where it slips off that end; set for rounded barriers only
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

// How far P2 lies inside the nearer end of the face [m]; below 0 outside.
LANES_INLINE struct lanes kernel_margin(const struct kinematics_problem *problem,
                                        struct lanes projection)
{
    return lanes_min(lanes_sub(lanes_set(problem->edge_y), projection),
                     lanes_sub(projection, lanes_set(problem->far_y)));
}

// The same of kernel_place.edge.
LANES_INLINE struct lanes kernel_edge_margin(const struct kinematics_problem *problem,
                                             struct problem_features features, struct lanes edge)
{
    return features.rounded ? edge : kernel_margin(problem, edge);
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
    place.edge = place.projection;
    place.slip = place.place;
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

// ---- Event Verlet ----
//
// The other schemes look at a spring at whole steps only: one that lets go within a step has acted
// for half a step after the last time it was seen to act, whenever it really let go. On average
// that is right, for one crash it is an error of first order. Here the moment is found, by the
// straight line between the two times of whatever began or ended the force, and what the spring did
// up to then, or from then on, is made good at the time after: too late by part of a step, which is
// an error of second order.
//
// Not so the moment at which a spring begins to load again. Of a car that stands still, rounding
// decides whether it does; then nothing may be made good, or the car would be thrown by it.

// What one spring's branches have to know of the step that ends now.
struct kernel_step {
    struct lanes deformation; // [m] now
    struct lanes before;      // [m] at the time before
    struct lanes slip;        // share of the step at which it met or left the face
    struct lanes_mask outside_before, outside;
    struct lanes turn; // at which it ceased to load; may lie half a step before the time before
    struct lanes_mask loads, turned, again; // loads now, loaded before and ceased to, began to
};

// a / (a - b): where the line from a to b is 0.
LANES_INLINE struct lanes kernel_crossing(struct lanes a, struct lanes b)
{
    return lanes_div(a, lanes_sub(a, b));
}

// Adds to x and y what a branch that began or ceased to act within the step did there, beside the
// half steps that count anyway. Where `was` and `is` are equal nothing is added.
LANES_INLINE void kernel_make_good(const struct kinematics_problem *problem,
                                   const struct problem_curve *curve, const double *coefficients,
                                   const struct kernel_step *step, bool loading,
                                   struct lanes_mask was, struct lanes_mask is, struct lanes weight,
                                   struct lanes *x, struct lanes *y)
{
    const struct lanes_mask began = lanes_and_not(is, was);
    const struct lanes_mask ended = lanes_and_not(was, is);
    const struct lanes_mask changed = lanes_and_not(lanes_or(began, ended), step->again);
    if (!lanes_any(changed)) {
        return;
    }
    const struct lanes one = lanes_set(1.0);
    const struct lanes half = lanes_set(0.5);
    const struct lanes start = lanes_set(curve->acts_above);
    const struct lanes_mask all = lanes_less(lanes_set(0.0), one);
    const struct lanes_mask short_before = lanes_and_not_above(all, step->before, start);
    const struct lanes_mask short_now = lanes_and_not_above(all, step->deformation, start);
    const struct lanes reach =
        kernel_crossing(lanes_sub(step->before, start), lanes_sub(step->deformation, start));
    // It ends with the first thing that forbids it and begins once nothing does any more.
    struct lanes end = one;
    end = lanes_select(step->outside, lanes_min(step->slip, end), end);
    end = lanes_select(short_now, lanes_min(reach, end), end);
    if (loading) {
        end = lanes_select(step->loads, end, lanes_min(step->turn, end));
    }
    struct lanes begin = lanes_set(-0.5);
    begin = lanes_select(step->outside_before, lanes_max(step->slip, begin), begin);
    begin = lanes_select(short_before, lanes_max(reach, begin), begin);
    if (!loading) {
        begin = lanes_select(step->turned, lanes_max(step->turn, begin), begin);
    }

    const struct lanes moment = lanes_select(ended, end, begin);
    const struct lanes share = lanes_select(ended, moment, lanes_sub(one, moment));
    const struct lanes near = lanes_select(ended, step->before, step->deformation);
    const struct lanes there =
        lanes_fma(moment, lanes_sub(step->deformation, step->before), step->before);
    struct lanes near_x, near_y, there_x, there_y;
    kernel_curve(problem, curve, coefficients, near, changed, &near_x, &near_y);
    kernel_curve(problem, curve, coefficients, there, changed, &there_x, &there_y);
    // The mean force over its share of the step, less the half step that counts anyway.
    const struct lanes scale = lanes_mul(half, weight);
    const struct lanes more_x =
        lanes_mul(scale, lanes_fms(share, lanes_add(near_x, there_x), near_x));
    const struct lanes more_y =
        lanes_mul(scale, lanes_fms(share, lanes_add(near_y, there_y), near_y));
    *x = lanes_add(*x, lanes_keep(changed, more_x));
    *y = lanes_add(*y, lanes_keep(changed, more_y));
}

// The step of one spring, from what was kept of it.
LANES_INLINE struct kernel_step kernel_step_of(const struct kinematics_problem *problem,
                                               struct problem_features features, uint32_t number,
                                               const struct kernel_event *event)
{
    const uint32_t now = number % 3;
    const uint32_t before = (number + 2) % 3;
    const uint32_t earlier = (number + 1) % 3;
    const struct lanes zero = lanes_set(0.0);
    struct kernel_step step;
    step.deformation = lanes_load(event->deformation[now]);
    step.before = lanes_load(event->deformation[before]);
    const struct lanes growth = lanes_sub(step.deformation, step.before);
    const struct lanes growth_before =
        lanes_sub(step.before, lanes_load(event->deformation[earlier]));
    const struct lanes margin =
        kernel_edge_margin(problem, features, lanes_load(event->edge[number % 2]));
    const struct lanes margin_before =
        kernel_edge_margin(problem, features, lanes_load(event->edge[(number + 1) % 2]));
    step.slip = kernel_crossing(margin_before, margin);
    step.outside_before = lanes_less(margin_before, zero);
    step.outside = lanes_less(margin, zero);
    step.turn = lanes_sub(kernel_crossing(growth_before, growth), lanes_set(0.5));
    step.loads = lanes_less(step.before, step.deformation);
    struct lanes_mask loaded = lanes_less(zero, growth_before);
    if (features.crushed) {
        const struct lanes reference = lanes_load(event->reference);
        step.loads = lanes_less(reference, step.deformation);
        loaded = lanes_and_not(loaded, lanes_less(step.before, reference));
    }
    step.turned = lanes_and_not(loaded, step.loads);
    step.again = lanes_and_not(step.loads, loaded);
    return step;
}

// The deformation at which a spring left the face at that share of the step: what lies between the
// two times, or for a rounded edge what the line's own place says.
LANES_INLINE struct lanes kernel_left_at(struct problem_features features,
                                         const struct problem_spring *spring, uint32_t number,
                                         const struct kernel_event *event,
                                         const struct kernel_step *step)
{
    struct lanes before = step->before;
    struct lanes now = step->deformation;
    if (features.rounded) {
        const struct lanes reach = lanes_set(spring->reach);
        before = lanes_add(reach, lanes_load(event->slip[(number + 1) % 2]));
        now = lanes_add(reach, lanes_load(event->slip[number % 2]));
    }
    return lanes_fma(step->slip, lanes_sub(now, before), before);
}

// Notes a deformation of a spring where it is in contact.
LANES_INLINE void kernel_deepen(struct kernel_spring *kept, struct lanes_mask contact,
                                struct lanes deformation)
{
    const struct lanes deepest = lanes_load(kept->deepest);
    lanes_store(kept->deepest, lanes_select(contact, lanes_max(deformation, deepest), deepest));
}

// Where a spring slipped off the rounded edge within the step that ends now, at which deformation;
// remembers what the next step is held against. This is for the schemes that look at whole steps
// only, which would lose up to a step's way and, close to the tangent, the root of it.
LANES_INLINE struct lanes_mask kernel_slipped(const struct problem_spring *spring, uint32_t number,
                                              const struct kernel_place *place,
                                              struct lanes_mask contact, struct kernel_event *event,
                                              struct lanes *left_at)
{
    const uint32_t now = number % 2;
    const uint32_t before = 1 - now;
    const struct lanes edge_before = lanes_load(event->edge[before]);
    const struct lanes slip_before = lanes_load(event->slip[before]);
    const struct lanes share = kernel_crossing(edge_before, place->edge);
    const struct lanes slip = lanes_fma(share, lanes_sub(place->slip, slip_before), slip_before);
    const struct lanes_mask left =
        lanes_and_not(lanes_and_less(event->contact[before], place->edge, lanes_set(0.0)), contact);
    *left_at = lanes_add(lanes_set(spring->reach), slip);
    lanes_store(event->edge[now], place->edge);
    lanes_store(event->slip[now], place->slip);
    event->contact[now] = contact;
    return left;
}

// Finds what began and ended within the step that ends now and makes it good in the springs'
// forces. Where spring 0 left the face, `left` is set and `left_at` is the deformation at which it
// did. Most bundles see nothing of that in most steps, so this is called when one does, and stands
// by itself: the machine's registers belong to the loop over springs.
static __attribute__((noinline)) void kernel_find_events(const struct kinematics_problem *problem,
                                                         struct problem_features features,
                                                         uint32_t number, double weight,
                                                         struct kernel_scratch *scratch)
{
    const uint32_t now = number % 2;
    const uint32_t before = 1 - now;
    const struct lanes zero = lanes_set(0.0);
    const struct lanes inverse = lanes_set(1.0 / weight);
    struct lanes sum_x = zero;
    struct lanes sum_y = zero;
    struct lanes moment = zero;
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        const struct problem_spring *spring = &problem->springs[i];
        struct kernel_spring *kept = &scratch->springs[i];
        const struct kernel_event *event = &scratch->springs[i].event;
        const bool unload = features.unload && spring->unload.point_count > 0;
        const bool other = lanes_any(lanes_differ(event->loads[before], event->loads[now])) ||
                           (unload && lanes_any(lanes_differ(event->unloads[before], //
                                                             event->unloads[now])));
        const bool parted = (i == 0 || features.deepest) &&
                            lanes_any(lanes_and_not(event->contact[before], event->contact[now]));
        if (!other && !parted) {
            continue;
        }
        const struct kernel_step step = kernel_step_of(problem, features, number, event);
        struct lanes x = zero;
        struct lanes y = zero;
        kernel_make_good(problem, &spring->load, scratch->coefficients, &step, true,
                         event->loads[before], event->loads[now], inverse, &x, &y);
        if (unload) {
            kernel_make_good(problem, &spring->unload, scratch->coefficients, &step, false,
                             event->unloads[before], event->unloads[now], inverse, &x, &y);
        }
        if (features.work) {
            lanes_store(kept->force_x, lanes_add(lanes_load(kept->force_x), x));
            lanes_store(kept->force_y, lanes_add(lanes_load(kept->force_y), y));
        }
        sum_x = lanes_add(sum_x, x);
        sum_y = lanes_add(sum_y, y);
        moment = lanes_fma(lanes_load(kept->place), y, moment);
        moment = lanes_fnma(lanes_set(spring->position_y), x, moment);
        if (parted) {
            const struct lanes_mask left =
                lanes_and_not(lanes_and(event->contact[before], step.outside), event->contact[now]);
            const struct lanes left_at = kernel_left_at(features, spring, number, event, &step);
            if (i == 0) {
                scratch->left = left;
                lanes_store(scratch->left_at, left_at);
            }
            if (features.deepest) {
                kernel_deepen(kept, left, left_at);
            }
        }
    }
    lanes_store(scratch->made_good[0], sum_x);
    lanes_store(scratch->made_good[1], sum_y);
    lanes_store(scratch->made_good[2], moment);
}

// Remembers of one spring what the next step is held against. Returns where it began or ceased to
// act within the step that ends now, and for spring 0, or all whose greatest deformation is wanted,
// where it began or ceased to touch.
LANES_INLINE struct lanes_mask kernel_keep_event(struct problem_features features, uint32_t index,
                                                 uint32_t number, const struct kernel_place *place,
                                                 struct lanes reference, struct lanes_mask contact,
                                                 struct lanes_mask loads, struct lanes_mask unloads,
                                                 struct kernel_event *event)
{
    const uint32_t now = number % 2;
    const uint32_t before = 1 - now;
    lanes_store(event->edge[now], place->edge);
    if (features.rounded) {
        lanes_store(event->slip[now], place->slip);
    }
    struct lanes_mask other = lanes_differ(event->loads[before], loads);
    event->loads[now] = loads;
    if (features.unload) {
        other = lanes_or(other, lanes_differ(event->unloads[before], unloads));
        event->unloads[now] = unloads;
    }
    if (features.crushed) {
        lanes_store(event->reference, reference);
    }
    if (index == 0 || features.deepest) {
        other = lanes_or(other, lanes_differ(event->contact[before], contact));
        event->contact[now] = contact;
    }
    return other;
}

// Makes the first step of a bundle one in which nothing happened: the car came towards the barrier.
LANES_INLINE void kernel_start_events(const struct kinematics_problem *problem,
                                      struct kernel_scratch *scratch)
{
    const struct lanes way = lanes_set(problem->speed * problem->time_step);
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        struct kernel_event *event = &scratch->springs[i].event;
        lanes_store(event->deformation[2], lanes_sub(lanes_load(event->deformation[0]), way));
    }
}

// Forces of all springs at one time. `velocity` is NULL for the leapfrog schemes, which tell
// loading from the deformation of the step before. `settled` says that this is a time of the
// trajectory, not a Runge-Kutta stage on the way: only then is the deformation remembered.
// `number` is the step that ends now and `weight` the part of a step over which the forces act, for
// event Verlet 0 at time 0.
LANES_INLINE struct kernel_load
kernel_forces(const struct kinematics_problem *problem, struct problem_features features,
              const struct kernel_motion *at, const struct kernel_pose *pose,
              const struct kernel_motion *velocity, bool settled, uint32_t number, double weight,
              bool recording, struct kernel_scratch *scratch)
{
    const struct lanes zero = lanes_set(0.0);
    struct lanes sum_x = zero;
    struct lanes sum_y = zero;
    struct lanes moment_x = zero;
    struct lanes moment_y = zero;
    struct kernel_load load;
    load.contact = lanes_none();
    struct lanes_mask other = lanes_none();
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        const struct problem_spring *spring = &problem->springs[i];
        struct kernel_spring *kept = &scratch->springs[i];
        const struct kernel_place place = kernel_place(problem, features, spring, at, pose);
        const struct lanes s = lanes_add(lanes_set(spring->reach), place.place);
        const struct lanes_mask contact = lanes_and_less(place.projected, zero, s);
        const bool ring = features.events && !features.crushed;
        const struct lanes reference = lanes_load(
            ring ? scratch->springs[i].event.deformation[(number + 2) % 3] : kept->reference);
        struct lanes_mask loading;
        if (velocity == NULL || features.crushed) {
            loading = lanes_and_less(contact, reference, s);
        } else {
            loading = lanes_and(contact, kernel_grows(spring, &place, pose, velocity));
        }
        if (settled) {
            const struct lanes crushed = lanes_select(contact, lanes_max(reference, s), reference);
            if (!ring) {
                lanes_store(kept->reference, features.crushed ? crushed : s);
            }
            if (features.events) {
                lanes_store(scratch->springs[i].event.deformation[number % 3], s);
            }
            if (features.deepest) {
                kernel_deepen(kept, contact, s);
            }
        }

        struct lanes_mask acts = loading;
        if (features.late_start) {
            acts = lanes_and_less(loading, lanes_set(spring->load.acts_above), s);
        }
        struct lanes x;
        struct lanes y;
        kernel_curve(problem, &spring->load, scratch->coefficients, s, acts, &x, &y);
        struct lanes_mask gives = lanes_none();
        if (features.unload && spring->unload.point_count > 0) {
            gives = lanes_and_less(lanes_and_not(contact, loading),
                                   lanes_set(spring->unload.acts_above), s);
            struct lanes unload_x;
            struct lanes unload_y;
            kernel_curve(problem, &spring->unload, scratch->coefficients, s, gives, &unload_x,
                         &unload_y);
            x = lanes_select(gives, unload_x, x);
            y = lanes_select(gives, unload_y, y);
        }

        sum_x = lanes_add(sum_x, x);
        sum_y = lanes_add(sum_y, y);
        moment_x = lanes_fma(lanes_set(spring->position_y), x, moment_x);
        moment_y = lanes_fma(place.place, y, moment_y);
        if (features.work || recording) {
            lanes_store(kept->force_x, x);
            lanes_store(kept->force_y, y);
        }
        if (features.work || features.events || recording) {
            lanes_store(kept->place, place.place);
        }
        if (recording) {
            lanes_store(kept->contact, lanes_keep(contact, lanes_set(1.0)));
        }
        load.contact = lanes_or(load.contact, contact);
        if (features.events) {
            other =
                lanes_or(other, kernel_keep_event(features, i, number, &place, reference, contact,
                                                  acts, gives, &scratch->springs[i].event));
            if (recording) {
                lanes_store(scratch->springs[i].event.force_x, x);
                lanes_store(scratch->springs[i].event.force_y, y);
            }
        }
        if (i == 0) {
            load.first_contact = contact;
            load.first_deformation = s;
            load.first_projection = place.projection;
        }
        if (features.rounded && !features.events && settled) {
            struct lanes left_at;
            const struct lanes_mask left =
                kernel_slipped(spring, number, &place, contact, &kept->event, &left_at);
            if (features.deepest) {
                kernel_deepen(kept, left, left_at);
            }
            if (i == 0) {
                load.first_contact = lanes_or(contact, left);
                load.first_deformation = lanes_select(left, left_at, s);
            }
        }
    }
    load.moment = lanes_sub(moment_y, moment_x);
    load.x = lanes_fms(pose->cosine, sum_x, lanes_mul(pose->sine, sum_y));
    load.felt = load.x;
    if (features.events && weight > 0.0 && __builtin_expect(lanes_any(other), false)) {
        scratch->left = lanes_none();
        kernel_find_events(problem, features, number, weight, scratch);
        load.first_deformation =
            lanes_select(scratch->left, lanes_load(scratch->left_at), load.first_deformation);
        load.first_contact = lanes_or(load.first_contact, scratch->left);
        sum_x = lanes_add(sum_x, lanes_load(scratch->made_good[0]));
        sum_y = lanes_add(sum_y, lanes_load(scratch->made_good[1]));
        load.moment = lanes_add(load.moment, lanes_load(scratch->made_good[2]));
        load.x = lanes_fms(pose->cosine, sum_x, lanes_mul(pose->sine, sum_y));
    }
    load.y = lanes_fma(pose->sine, sum_x, lanes_mul(pose->cosine, sum_y));
    return load;
}

// Adds the work of each spring along the way (x, y, yaw), forces held.
LANES_INLINE void kernel_work(const struct kinematics_problem *problem,
                              const struct kernel_pose *pose, const struct kernel_motion *way,
                              struct kernel_scratch *scratch)
{
    const struct lanes along =
        lanes_fma(pose->cosine, way->x, lanes_mul(pose->sine, way->y)); // in vehicle axes
    const struct lanes across = lanes_fms(pose->cosine, way->y, lanes_mul(pose->sine, way->x));
    struct lanes lateral = lanes_load(scratch->lateral_work);
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        struct kernel_spring *kept = &scratch->springs[i];
        const struct lanes way_x =
            lanes_fnma(lanes_set(problem->springs[i].position_y), way->yaw, along);
        const struct lanes way_y = lanes_fma(lanes_load(kept->place), way->yaw, across);
        struct lanes work = lanes_load(kept->work);
        work = lanes_fma(lanes_load(kept->force_x), way_x, work);
        work = lanes_fma(lanes_load(kept->force_y), way_y, work);
        lateral = lanes_fma(lanes_load(kept->force_y), way_y, lateral);
        lanes_store(kept->work, work);
    }
    lanes_store(scratch->lateral_work, lateral);
}

LANES_INLINE void kernel_observe(const struct kernel_pose *pose, const struct kernel_load *load,
                                 struct kernel_observed *observed)
{
    observed->yaw_max = lanes_max(pose->magnitude, observed->yaw_max);
    observed->force_max = lanes_max(lanes_abs(load->felt), observed->force_max);
    observed->force_sum = lanes_add(observed->force_sum, load->felt);
    observed->contact_steps =
        lanes_add(observed->contact_steps, lanes_keep(load->contact, lanes_set(1.0)));
    observed->deformation_last =
        lanes_select(load->first_contact, load->first_deformation, observed->deformation_last);
    observed->deformation_max = lanes_max(observed->deformation_last, observed->deformation_max);
}

// Writes the row of one time. Only the plain path records, with one design in a bundle. `acting` is
// 0 where forces do not act yet.
LANES_INLINE void kernel_record(const struct kinematics_problem *problem,
                                struct problem_features features, uint32_t step,
                                const struct kernel_motion *at,
                                const struct kernel_motion *velocity, double acting,
                                const struct kernel_scratch *scratch, double *rows)
{
    double *row = rows + (size_t)step * kinematics_column_count(problem);
    row[KINEMATICS_COLUMN_TIME] = step * problem->time_step;
    lanes_store(row + KINEMATICS_COLUMN_X, lanes_add(at->x, lanes_set(problem->face_x)));
    lanes_store(row + KINEMATICS_COLUMN_Y, at->y);
    lanes_store(row + KINEMATICS_COLUMN_YAW, at->yaw);
    lanes_store(row + KINEMATICS_COLUMN_VX, velocity->x);
    lanes_store(row + KINEMATICS_COLUMN_VY, velocity->y);
    lanes_store(row + KINEMATICS_COLUMN_VYAW, velocity->yaw);
    double *column = row + KINEMATICS_COLUMN_SPRING;
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        const struct problem_spring *spring = &problem->springs[i];
        const struct kernel_spring *kept = &scratch->springs[i];
        const double deformation = spring->reach + kept->place[0];
        column[KINEMATICS_SPRING_LENGTH] = spring->length - deformation;
        column[KINEMATICS_SPRING_DEFORMATION] = deformation;
        const struct kernel_event *event = &scratch->springs[i].event;
        const double force_x = features.events ? event->force_x[0] : kept->force_x[0];
        const double force_y = features.events ? event->force_y[0] : kept->force_y[0];
        column[KINEMATICS_SPRING_FORCE_X] = acting > 0.0 ? force_x : 0.0;
        column[KINEMATICS_SPRING_FORCE_Y] = acting > 0.0 ? force_y : 0.0;
        column[KINEMATICS_SPRING_CONTACT] = kept->contact[0];
        column += KINEMATICS_SPRING_COLUMN_COUNT;
    }
}

// Whether, in all lanes, every spring stays off the inner end of the face for the steps that are
// left when nothing pushes: then nothing will. Seen from the end of the face the COG is at (X, Y)
// and moves by `way` a step, and spring i's line passes the end at the height
//
//     W + p_y,i,   W = Y cos(yaw) - X sin(yaw),   W'' = -omega^2 W - 2 omega (v_x cos + v_y sin)
//
// above it no contact. With W'' >= -bound, W lies above a parabola that opens downwards, so above
// the lesser of its values now and at the end. Any answer leads to the same bits; true must be
// right, so there is a margin well above rounding.
LANES_INLINE bool kernel_flies_free(const struct kinematics_problem *problem,
                                    const struct kernel_motion *at, const struct kernel_motion *way,
                                    const struct kernel_pose *pose, uint32_t steps)
{
    const double margin = 1e-6;   // [m]
    const double yaw_limit = 1.5; // [rad] where the cosine is still above 0
    const struct lanes left = lanes_set(steps);
    const struct lanes two = lanes_set(2.0);
    const struct lanes x = at->x;
    const struct lanes y = lanes_sub(at->y, lanes_set(problem->edge_y));
    const struct lanes turn = lanes_abs(way->yaw);
    const struct lanes height = lanes_fms(y, pose->cosine, lanes_mul(x, pose->sine));
    const struct lanes lever = lanes_fma(y, pose->sine, lanes_mul(x, pose->cosine));
    const struct lanes along = lanes_fma(way->x, pose->cosine, lanes_mul(way->y, pose->sine));
    const struct lanes across = lanes_fms(way->y, pose->cosine, lanes_mul(way->x, pose->sine));
    const struct lanes rate = lanes_fnma(way->yaw, lever, across);
    const struct lanes distance = lanes_mul(left, lanes_add(lanes_abs(way->x), lanes_abs(way->y)));
    const struct lanes reach =
        lanes_fma(two, distance, lanes_add(lanes_add(lanes_abs(x), lanes_abs(y)), distance));
    const struct lanes sideways = lanes_mul(lanes_mul(two, way->yaw), along);
    const struct lanes bound =
        lanes_max(lanes_fma(lanes_mul(turn, turn), reach, sideways), lanes_set(0.0));
    const struct lanes straight = lanes_fma(left, rate, height);
    const struct lanes at_end =
        lanes_fnma(lanes_mul(lanes_mul(lanes_set(0.5), left), left), bound, straight);
    const struct lanes needed = lanes_set(margin - problem->lowest_y);
    const struct lanes yaw_end = lanes_fma(left, turn, pose->magnitude);
    struct lanes_mask free = lanes_less(yaw_end, lanes_set(yaw_limit));
    free = lanes_and_less(lanes_and_less(free, needed, height), needed, at_end);
    const struct lanes_mask all = lanes_less(lanes_set(0.0), lanes_set(1.0));
    return !lanes_any(lanes_and_not(all, free));
}

// Takes the bundle through steps in which nothing touches: the same additions, and nothing else.
// Their number is even, so that event Verlet finds this step's notes where it looks for them.
LANES_INLINE uint32_t kernel_fly(struct kernel_motion *at, const struct kernel_motion *way,
                                 uint32_t steps)
{
    const uint32_t even = steps & ~UINT32_C(1);
    for (uint32_t i = 0; i < even; i++) {
        at->x = lanes_add(at->x, way->x);
        at->y = lanes_add(at->y, way->y);
        at->yaw = lanes_add(at->yaw, way->yaw);
    }
    return even;
}

// Central difference, velocity Verlet and event Verlet are one scheme: with the way of a step d,
// eq. 6.41 reads d += a dt^2, q += d. `weight` is the part of a step over which the forces of one
// time act: half a step at the end, which gives the velocity there, and at the start half a step
// for both Verlets and none for central difference. The work F (d_before + d_after) / 2 then adds
// up exactly to the change of kinetic energy; twice the work is kept, which saves the halving.
LANES_INLINE struct kernel_load
kernel_leapfrog(const struct kinematics_problem *problem, struct problem_features features,
                struct kernel_motion *at, struct kernel_motion *velocity, struct kernel_pose *pose,
                struct kernel_observed *observed, double *rows, struct kernel_scratch *scratch)
{
    const double dt = problem->time_step;
    const double kick = dt * dt / problem->mass;
    const double kick_yaw = dt * dt / problem->yaw_inertia;
    const double start_weight = problem->integrator == KINEMATICS_CENTRAL_DIFFERENCE ? 0.0 : 0.5;
    struct kernel_motion way = {lanes_set(-problem->speed * dt), lanes_set(0.0), lanes_set(0.0)};
    struct kernel_load load;
    for (uint32_t step = 0;; step++) {
        const bool last = step == problem->step_count;
        const double weight = step == 0 ? start_weight : last ? 0.5 : 1.0;
        *pose = kernel_pose(at);
        load = kernel_forces(problem, features, at, pose, NULL, true, step,
                             step == 0 ? 0.0 : weight, rows != NULL, scratch);
        if (features.events && step == 0) {
            kernel_start_events(problem, scratch);
        }
        if (weight > 0.0) {
            kernel_observe(pose, &load, observed);
        }
        const struct kernel_motion before = way;
        way.x = lanes_fma(load.x, lanes_set(weight * kick), way.x);
        way.y = lanes_fma(load.y, lanes_set(weight * kick), way.y);
        way.yaw = lanes_fma(load.moment, lanes_set(weight * kick_yaw), way.yaw);
        if (features.work) {
            struct kernel_motion twice = {lanes_add(before.x, way.x), lanes_add(before.y, way.y),
                                          lanes_add(before.yaw, way.yaw)};
            if (weight < 1.0) {
                const struct lanes part = lanes_set(weight);
                twice.x = lanes_mul(part, twice.x);
                twice.y = lanes_mul(part, twice.y);
                twice.yaw = lanes_mul(part, twice.yaw);
            }
            kernel_work(problem, pose, &twice, scratch);
        }
        if (rows != NULL || last) {
            // At the ends the way after or before the kick is the velocity there; in between the
            // mean of the two.
            const struct kernel_motion *from = step == 0 ? &before : &way;
            const struct kernel_motion *to = last ? &way : &before;
            const struct lanes rate = lanes_set(0.5 / dt);
            velocity->x = lanes_mul(rate, lanes_add(from->x, to->x));
            velocity->y = lanes_mul(rate, lanes_add(from->y, to->y));
            velocity->yaw = lanes_mul(rate, lanes_add(from->yaw, to->yaw));
        }
        if (rows != NULL) {
            kernel_record(problem, features, step, at, velocity, weight, scratch, rows);
        }
        if (last) {
            return load;
        }
        const uint32_t left = problem->step_count - step;
        if (!features.rounded && rows == NULL && step % FLIGHT_LOOK == 0 &&
            !lanes_any(load.contact) && kernel_flies_free(problem, at, &way, pose, left)) {
            step += kernel_fly(at, &way, left - 1);
        }
        at->x = lanes_add(at->x, way.x);
        at->y = lanes_add(at->y, way.y);
        at->yaw = lanes_add(at->yaw, way.yaw);
    }
}

// a + factor b.
LANES_INLINE struct kernel_motion kernel_advance(const struct kernel_motion *a, double factor,
                                                 const struct kernel_motion *b)
{
    const struct lanes f = lanes_set(factor);
    return (struct kernel_motion){lanes_fma(f, b->x, a->x), lanes_fma(f, b->y, a->y),
                                  lanes_fma(f, b->yaw, a->yaw)};
}

LANES_INLINE struct kernel_motion kernel_acceleration(const struct kinematics_problem *problem,
                                                      const struct kernel_load *load)
{
    const struct lanes by_mass = lanes_set(1.0 / problem->mass);
    return (struct kernel_motion){lanes_mul(load->x, by_mass), lanes_mul(load->y, by_mass),
                                  lanes_mul(load->moment, lanes_set(1.0 / problem->yaw_inertia))};
}

// The classical fourth-order scheme on (place, velocity) and on the springs' work. Stages 2 to 4
// stand in a loop so that the springs' code is there twice, not four times.
LANES_INLINE struct kernel_load
kernel_runge_kutta(const struct kinematics_problem *problem, struct problem_features features,
                   struct kernel_motion *at, struct kernel_motion *velocity,
                   struct kernel_pose *pose, struct kernel_observed *observed, double *rows,
                   struct kernel_scratch *scratch)
{
    static const double reach[4] = {0.0, 0.5, 0.5, 1.0};                 // of the step, to stage i
    static const double share[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}; // of stage i in the step
    const struct lanes zero = lanes_set(0.0);
    const double dt = problem->time_step;
    for (uint32_t step = 0;; step++) {
        *pose = kernel_pose(at);
        const struct kernel_load load = kernel_forces(problem, features, at, pose, velocity, true,
                                                      step, 1.0, rows != NULL, scratch);
        kernel_observe(pose, &load, observed);
        if (rows != NULL) {
            kernel_record(problem, features, step, at, velocity, 1.0, scratch, rows);
        }
        if (step == problem->step_count) {
            return load;
        }
        const struct kernel_motion none = {zero, zero, zero};
        struct kernel_motion rate = *velocity;
        struct kernel_motion acceleration = kernel_acceleration(problem, &load);
        struct kernel_motion way = kernel_advance(&none, share[0] * dt, &rate);
        struct kernel_motion gain = kernel_advance(&none, share[0] * dt, &acceleration);
        if (features.work) {
            kernel_work(problem, pose, &way, scratch);
        }
        for (int stage = 1; stage < 4; stage++) {
            const struct kernel_motion there = kernel_advance(at, reach[stage] * dt, &rate);
            rate = kernel_advance(velocity, reach[stage] * dt, &acceleration);
            const struct kernel_pose stage_pose = kernel_pose(&there);
            const struct kernel_load stage_load = kernel_forces(
                problem, features, &there, &stage_pose, &rate, false, 0, 1.0, false, scratch);
            const struct kernel_motion stage_way = kernel_advance(&none, share[stage] * dt, &rate);
            if (features.work) {
                kernel_work(problem, &stage_pose, &stage_way, scratch);
            }
            acceleration = kernel_acceleration(problem, &stage_load);
            way = kernel_advance(&way, share[stage] * dt, &rate);
            gain = kernel_advance(&gain, share[stage] * dt, &acceleration);
        }
        *at = kernel_advance(at, 1.0, &way);
        *velocity = kernel_advance(velocity, 1.0, &gain);
    }
}

// Stores a result row for the designs there are. `poison` is 0, or NaN for a design whose motion is
// not finite; every NaN is stored as the same one.
LANES_INLINE void kernel_store(double *results, uint32_t count, struct lanes poison,
                               struct lanes value)
{
    value = lanes_add(value, poison);
    const struct lanes stored = lanes_select(
        lanes_and_not_above(lanes_less(value, lanes_set(INFINITY)), lanes_set(-INFINITY), value),
        value, lanes_set((double)NAN));
    double all[LANES];
    lanes_store(all, stored);
    for (uint32_t i = 0; i < LANES && i < count; i++) {
        results[i] = all[i];
    }
}

LANES_INLINE void kernel_results(const struct kinematics_problem *problem,
                                 const struct kernel_motion *at,
                                 const struct kernel_motion *velocity,
                                 const struct kernel_pose *pose, const struct kernel_load *load,
                                 const struct kernel_observed *observed,
                                 const struct kernel_scratch *scratch, double work_unit,
                                 uint32_t count, double *results, size_t stride)
{
    const struct problem_spring *first = &problem->springs[0];
    const struct lanes zero = lanes_set(0.0);
    const struct lanes length = lanes_set(first->length);
    const struct lanes position_y = lanes_set(first->position_y);
    const struct lanes start_y = lanes_set(problem->start_y);
    const struct lanes by_mass = lanes_set(1.0 / problem->mass);
    const struct lanes travel_y = lanes_sub(at->y, start_y);
    const struct lanes turned = lanes_fma(lanes_set(first->position_x), pose->sine,
                                          lanes_fms(position_y, pose->cosine, position_y));
    const struct lanes steps = lanes_max(observed->contact_steps, lanes_set(1.0));
    const struct lanes square_x = lanes_mul(velocity->x, velocity->x);
    const struct lanes square = lanes_fma(velocity->y, velocity->y, square_x);
    const struct lanes square_yaw = lanes_mul(velocity->yaw, velocity->yaw);
    const struct lanes energy =
        lanes_fma(lanes_set(0.5 * problem->mass), square,
                  lanes_mul(lanes_set(0.5 * problem->yaw_inertia), square_yaw));
    // x - x is 0, or NaN where x is not finite; the energy is not finite where a velocity is not.
    const struct lanes poison =
        lanes_add(lanes_add(lanes_sub(at->x, at->x), lanes_sub(at->y, at->y)),
                  lanes_add(lanes_sub(at->yaw, at->yaw), lanes_sub(energy, energy)));

#define STORE(result, value) kernel_store(results + (result)*stride, count, poison, value)
    STORE(KINEMATICS_LENGTH_LAST, lanes_sub(length, observed->deformation_last));
    STORE(KINEMATICS_LENGTH_MIN, lanes_sub(length, observed->deformation_max));
    STORE(KINEMATICS_PILLAR_TRAVEL, lanes_add(travel_y, turned));
    STORE(KINEMATICS_PROJECTION_TRAVEL,
          lanes_sub(load->first_projection, lanes_add(start_y, position_y)));
    STORE(KINEMATICS_YAW, at->yaw);
    STORE(KINEMATICS_YAW_MAX, observed->yaw_max);
    STORE(KINEMATICS_TRAVEL_X, lanes_sub(at->x, lanes_set(problem->start_x)));
    STORE(KINEMATICS_TRAVEL_Y, travel_y);
    STORE(KINEMATICS_DELTA_VX, lanes_add(velocity->x, lanes_set(problem->speed)));
    STORE(KINEMATICS_DELTA_VY, velocity->y);
    STORE(KINEMATICS_ACCELERATION_MAX, lanes_mul(observed->force_max, by_mass));
    STORE(KINEMATICS_ACCELERATION_MEAN, lanes_div(lanes_mul(observed->force_sum, by_mass), steps));
    STORE(KINEMATICS_KINETIC_ENERGY, energy);
    STORE(KINEMATICS_LATERAL_WORK,
          lanes_mul(lanes_set(work_unit), lanes_load(scratch->lateral_work)));
    const double energy_at_start = 0.5 * problem->mass * problem->speed * problem->speed;
    struct lanes balance = lanes_sub(lanes_set(energy_at_start), energy);
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        const struct lanes work =
            lanes_fnma(lanes_set(work_unit), lanes_load(scratch->springs[i].work), zero);
        balance = lanes_sub(balance, work);
        STORE(KINEMATICS_WORK + i, work);
        STORE(KINEMATICS_WORK + problem->spring_count + i, lanes_load(scratch->springs[i].deepest));
    }
    STORE(KINEMATICS_ENERGY_BALANCE, problem->features.work ? balance : zero);
#undef STORE
}

// One bundle of `count` designs, 1 .. LANES.
LANES_INLINE void kernel_bundle(const struct kinematics_problem *problem,
                                struct problem_features features, bool runge_kutta, uint32_t count,
                                const double *values, double *results, size_t stride, double *rows,
                                struct kernel_scratch *scratch)
{
    const struct lanes zero = lanes_set(0.0);
    kernel_coefficients(problem, count, values, stride, scratch->coefficients);
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        // The vehicle comes towards the barrier, so at time 0 every spring loads.
        lanes_store(scratch->springs[i].reference, lanes_set(-INFINITY));
        if (features.events) {
            lanes_store(scratch->springs[i].event.deformation[2], lanes_set(-INFINITY));
        }
        if (features.rounded) {
            scratch->springs[i].event.contact[1] = lanes_none(); // before time 0 nothing touches
        }
        lanes_store(scratch->springs[i].work, zero);
        lanes_store(scratch->springs[i].deepest, zero);
    }
    lanes_store(scratch->lateral_work, zero);
    struct kernel_motion at = {lanes_set(problem->start_x), lanes_set(problem->start_y), zero};
    struct kernel_motion velocity = {lanes_set(-problem->speed), zero, zero};
    struct kernel_observed observed = {zero, zero, zero, zero, zero, zero};
    struct kernel_pose pose;
    const struct kernel_load load =
        runge_kutta
            ? kernel_runge_kutta(problem, features, &at, &velocity, &pose, &observed, rows, scratch)
            : kernel_leapfrog(problem, features, &at, &velocity, &pose, &observed, rows, scratch);
    kernel_results(problem, &at, &velocity, &pose, &load, &observed, scratch,
                   runge_kutta ? 1.0 : 0.5, count, results, stride);
}

// All designs, bundle by bundle. What most problems lack is left out of the variants for flat
// barriers without unload branches, which are the fast ones; the arithmetic that all do is the
// same. There is one for the defaults, event Verlet with `crushed`, and one for the thesis's pair,
// central difference with `thesis`; who mixes them takes the general one.
LANES_INLINE void kernel_evaluate(const struct kinematics_problem *problem, uint32_t count,
                                  const double *values, double *results, size_t stride,
                                  double *rows)
{
    const struct problem_features features = problem->features;
    const struct problem_features none = {.work = features.work, .deepest = features.deepest};
    const struct problem_features late = {
        .work = features.work, .deepest = features.deepest, .late_start = true};
    const struct problem_features events = {
        .work = features.work, .deepest = features.deepest, .events = true, .crushed = true};
    const struct problem_features both = {.work = features.work,
                                          .deepest = features.deepest,
                                          .events = true,
                                          .crushed = true,
                                          .late_start = true};
    const bool runge_kutta = problem->integrator == KINEMATICS_RUNGE_KUTTA_4;
    const bool plain = !features.rounded && !features.unload && features.crushed == features.events;
    struct kernel_scratch scratch;
    for (uint32_t first = 0; first < count; first += LANES) {
        const uint32_t left = count - first;
#define BUNDLE(these_features)                                                                   \
    kernel_bundle(problem, these_features, false, left, values + first, results + first, stride, \
                  rows, &scratch)
        if (runge_kutta) {
            kernel_bundle(problem, features, true, left, values + first, results + first, stride,
                          rows, &scratch);
        } else if (!plain) {
            BUNDLE(features);
        } else if (features.events) {
            features.late_start ? BUNDLE(both) : BUNDLE(events);
        } else {
            features.late_start ? BUNDLE(late) : BUNDLE(none);
        }
#undef BUNDLE
    }
}

#endif
