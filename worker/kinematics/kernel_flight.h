// Free flight: the steps of a car that has left the barrier for good, which need no forces.
#ifndef SOBOX_WORKER_KINEMATICS_KERNEL_FLIGHT_H
#define SOBOX_WORKER_KINEMATICS_KERNEL_FLIGHT_H

#include "worker/kinematics/kernel_state.h"

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

#endif
