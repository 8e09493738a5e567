// The results of a bundle, from its motion at the end and what was gathered on the way.
#ifndef SOBOX_WORKER_KINEMATICS_KERNEL_RESULTS_H
#define SOBOX_WORKER_KINEMATICS_KERNEL_RESULTS_H

#include "worker/kinematics/kernel_state.h"

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

#endif
