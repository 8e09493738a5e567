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

#include "worker/kinematics/kernel_events.h"
#include "worker/kinematics/kernel_flight.h"
#include "worker/kinematics/kernel_results.h"
#include "worker/kinematics/kernel_turns.h"

// Remembers the deformation beyond which a spring loads from now on.
LANES_INLINE void kernel_keep_reference(const struct kinematics_problem *problem,
                                        struct problem_features features, uint32_t number,
                                        struct lanes s, struct lanes_mask contact,
                                        struct lanes_mask loading, struct lanes reference,
                                        struct kernel_spring *kept)
{
    if (features.events) {
        const struct lanes next = lanes_add(s, lanes_set(problem->rest));
        lanes_store(kept->reference[number % 2],
                    features.crushed ? lanes_select(loading, next, reference) : next);
    } else if (features.crushed) {
        lanes_store(kept->reference[0], lanes_select(contact, lanes_max(reference, s), reference));
    } else {
        lanes_store(kept->reference[0], s);
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
    struct lanes moment = zero;
    struct kernel_load load;
    load.contact = lanes_none();
    load.switches = (struct kernel_bits){0, 0, 0};
    if (features.events) {
        kernel_keep_pose(pose, number, &scratch->past);
    }
    uint32_t other = 0;
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        const struct problem_spring *spring = &problem->springs[i];
        struct kernel_spring *kept = &scratch->springs[i];
        const struct kernel_place place = kernel_place(problem, features, spring, at, pose);
        const struct lanes s = lanes_add(lanes_set(spring->reach), place.place);
        const struct lanes_mask contact = lanes_and_less(place.projected, zero, s);
        const struct lanes reference =
            lanes_load(kept->reference[features.events ? 1 - number % 2 : 0]);
        struct lanes_mask loading;
        if (velocity == NULL || features.crushed) {
            loading = lanes_and_less(contact, reference, s);
        } else {
            loading = lanes_and(contact, kernel_grows(spring, &place, pose, velocity));
        }
        if (settled) {
            kernel_keep_reference(problem, features, number, s, contact, loading, reference, kept);
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
        moment = lanes_fnma(lanes_set(spring->position_y), x, moment);
        moment = lanes_fma(place.place, y, moment);
        if (features.work || recording) {
            lanes_store(kept->force_x, x);
            lanes_store(kept->force_y, y);
        }
        if (features.work || features.rounded || recording) {
            lanes_store(kept->place, place.place);
        }
        if (recording) {
            lanes_store(kept->contact, lanes_keep(contact, lanes_set(1.0)));
        }
        if (!features.events) {
            load.contact = lanes_or(load.contact, contact);
        } else {
            other |= kernel_keep_event(features, i, number, &place, s, contact, loading, acts,
                                       gives, &kept->event, &load.switches);
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
    if (features.events) {
        load.contact = lanes_from_bits(load.switches.contact);
    }
    load.moment = moment;
    load.x = lanes_fms(pose->cosine, sum_x, lanes_mul(pose->sine, sum_y));
    load.felt = load.x;
    if (features.events && weight > 0.0 && __builtin_expect(other != 0, false)) {
        scratch->left = lanes_none();
        const struct kernel_pose copy = *pose; // so that registers may keep the bundle's own
        kernel_find_events(problem, features, number, weight, &copy, scratch);
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

// The way of a step after the forces have acted over `weight` of one.
LANES_INLINE struct kernel_motion kernel_kicked(const struct kinematics_problem *problem,
                                                const struct kernel_motion *way,
                                                const struct kernel_load *load, double weight)
{
    const double dt = problem->time_step;
    const struct lanes kick = lanes_set(weight * (dt * dt / problem->mass));
    const struct lanes kick_yaw = lanes_set(weight * (dt * dt / problem->yaw_inertia));
    return (struct kernel_motion){lanes_fma(load->x, kick, way->x),
                                  lanes_fma(load->y, kick, way->y),
                                  lanes_fma(load->moment, kick_yaw, way->yaw)};
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
    const double start_weight = problem->integrator == KINEMATICS_CENTRAL_DIFFERENCE ? 0.0 : 0.5;
    struct kernel_motion way = {lanes_set(-problem->speed * dt), lanes_set(0.0), lanes_set(0.0)};
    struct kernel_load load;
    for (uint32_t step = 0;; step++) {
        const bool last = step == problem->step_count;
        const double weight = step == 0 ? start_weight : last ? 0.5 : 1.0;
        *pose = kernel_pose(at);
        load = kernel_forces(problem, features, at, pose, NULL, true, step,
                             step == 0 ? 0.0 : weight, rows != NULL, scratch);
        struct kernel_motion next = kernel_kicked(problem, &way, &load, weight);
        if (features.events && step > 0) {
            const uint32_t turning =
                kernel_turning(problem, features, step, at, &next, pose, &load.switches, scratch);
            if (__builtin_expect(turning != 0, false)) {
                const struct kernel_moment moment = {*at,    way,  *pose,   load,
                                                     weight, step, turning, rows != NULL};
                kernel_switch_all(problem, features, &moment, scratch);
                kernel_switch_apply(pose, scratch, &load);
                next = kernel_kicked(problem, &way, &load, weight);
            }
        }
        if (weight > 0.0) {
            kernel_observe(pose, &load, observed);
        }
        const struct kernel_motion before = way;
        way = next;
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
        lanes_store(scratch->springs[i].reference[0], lanes_set(-INFINITY));
        lanes_store(scratch->springs[i].reference[1], lanes_set(-INFINITY));
        scratch->springs[i].event.contact[1] = 0; // before time 0 nothing touches
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
// central difference with `thesis`; who mixes them takes the general one. Of the defaults there is
// one more for who wants neither work nor greatest deformations, which is what searches want.
LANES_INLINE void kernel_evaluate(const struct kinematics_problem *problem, uint32_t count,
                                  const double *values, double *results, size_t stride,
                                  double *rows)
{
    const struct problem_features features = problem->features;
    const bool runge_kutta = problem->integrator == KINEMATICS_RUNGE_KUTTA_4;
    const bool plain = !features.rounded && !features.unload && features.crushed == features.events;
    const bool lean = !features.work && !features.deepest;
    struct kernel_scratch scratch;
    for (uint32_t first = 0; first < count; first += LANES) {
        const uint32_t left = count - first;
#define BUNDLE(these_features)                                                                   \
    kernel_bundle(problem, these_features, false, left, values + first, results + first, stride, \
                  rows, &scratch)
#define FEATURES(...)                                                   \
    (struct problem_features)                                           \
    {                                                                   \
        .work = features.work, .deepest = features.deepest, __VA_ARGS__ \
    }
        if (runge_kutta) {
            kernel_bundle(problem, features, true, left, values + first, results + first, stride,
                          rows, &scratch);
        } else if (!plain) {
            BUNDLE(features);
        } else if (features.events && features.late_start && lean) {
            BUNDLE(
                ((struct problem_features){.events = true, .crushed = true, .late_start = true}));
        } else if (features.events && lean) {
            BUNDLE(((struct problem_features){.events = true, .crushed = true}));
        } else if (features.events && features.late_start) {
            BUNDLE(FEATURES(.events = true, .crushed = true, .late_start = true));
        } else if (features.events) {
            BUNDLE(FEATURES(.events = true, .crushed = true));
        } else if (features.late_start) {
            BUNDLE(FEATURES(.late_start = true));
        } else {
            BUNDLE(FEATURES(.late_start = false));
        }
#undef FEATURES
#undef BUNDLE
    }
}

#endif
