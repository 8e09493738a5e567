// A mid-size sedan and random crashes of it, for tests: a setup that can be changed before it is
// prepared, and a generator of numbers that is the same everywhere.
#ifndef SOBOX_TESTS_PHYSICS_SEDAN_H
#define SOBOX_TESTS_PHYSICS_SEDAN_H

#include "worker/kinematics/kinematics.h"

#include <string.h>

enum { SEDAN_SPRING_MAX = 8, SEDAN_POINT_MAX = 9 };

// A setup with room for its springs and curves.
struct sedan {
    struct kinematics_setup setup;
    struct kinematics_spring springs[SEDAN_SPRING_MAX];
    double deformation[SEDAN_SPRING_MAX][SEDAN_POINT_MAX];
    double unload_deformation[SEDAN_SPRING_MAX][SEDAN_POINT_MAX];
};

// A number in [0, 1).
static inline double sedan_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    uint64_t mixed = (*state ^ *state >> 32) * UINT64_C(0x9e3779b97f4a7c15);
    return (double)(mixed >> 11) * 0x1p-53;
}

static inline double sedan_between(uint64_t *state, double lower, double upper)
{
    return lower + (upper - lower) * sedan_random(state);
}

// One pair of springs at the A-pillar, deformations 0 to 1.2 m in equal parts, 150 steps of 1 ms.
static inline void sedan_init(struct sedan *sedan, uint32_t spring_count, uint32_t point_count)
{
    memset(sedan, 0, sizeof *sedan);
    sedan->setup = (struct kinematics_setup){
        .mass = 1650.0,
        .yaw_inertia = 3000.0,
        .speed = 17.889,
        .face_x = -2.08,
        .edge_y = -0.455,
        .width = 1.15,
        .edge_radius = 0.15,
        .profile = KINEMATICS_PROFILE_FLAT,
        .springs = sedan->springs,
        .spring_count = spring_count,
        .duration = 0.150,
        .time_step = 1e-3,
        .integrator = KINEMATICS_CENTRAL_DIFFERENCE,
        .reloading = KINEMATICS_RELOADING_THESIS,
    };
    for (uint32_t i = 0; i < spring_count; i++) {
        for (uint32_t point = 0; point < point_count; point++) {
            sedan->deformation[i][point] = 1.2 * point / (point_count - 1);
        }
        sedan->springs[i] = (struct kinematics_spring){
            .position = {-0.83 - 0.05 * i, -0.75 + 0.08 * i},
            .length = 1.25 - 0.05 * i,
            .load = {sedan->deformation[i], point_count},
        };
    }
}

// A crash with random vehicle, barrier, springs and curves: everything that a setup can say.
static inline void sedan_randomize(struct sedan *sedan, uint64_t *state)
{
    const uint32_t spring_count = 1 + (uint32_t)(sedan_random(state) * 5.0);
    sedan_init(sedan, spring_count, 2 + (uint32_t)(sedan_random(state) * 8.0));
    struct kinematics_setup *setup = &sedan->setup;
    setup->mass = sedan_between(state, 1200.0, 2500.0);
    setup->yaw_inertia = sedan_between(state, 2000.0, 4500.0);
    setup->speed = sedan_between(state, 5.0, 25.0);
    setup->cog[0] = sedan_between(state, -0.5, 0.5);
    setup->cog[1] = sedan_between(state, -0.1, 0.1);
    setup->face_x += setup->cog[0];
    setup->width = sedan_between(state, 0.3, 1.5);
    setup->edge_radius = sedan_between(state, 0.02, 0.25);
    setup->profile =
        sedan_random(state) < 0.5 ? KINEMATICS_PROFILE_FLAT : KINEMATICS_PROFILE_ROUNDED;
    for (uint32_t i = 0; i < spring_count; i++) {
        struct kinematics_spring *spring = &sedan->springs[i];
        spring->position[0] = sedan_between(state, -1.0, -0.6);
        spring->position[1] = sedan_between(state, -0.9, -0.4);
        // A nanometre short of the face, so that no rounding decides on contact at time 0.
        spring->length = spring->position[0] - (setup->face_x - setup->cog[0]) - 1e-9 +
                         (sedan_random(state) < 0.3 ? sedan_between(state, -0.2, 0.1) : 0.0);
        double s = sedan_random(state) < 0.3 ? sedan_between(state, -0.1, 0.2) : 0.0;
        for (uint32_t point = 0; point < spring->load.point_count; point++) {
            sedan->deformation[i][point] = s;
            s += sedan_between(state, 0.02, 0.3);
        }
        if (sedan_random(state) < 0.4) {
            double t = sedan_between(state, -0.1, 0.4);
            spring->unload.deformation = sedan->unload_deformation[i];
            spring->unload.point_count = 2 + (uint32_t)(sedan_random(state) * 3.0);
            for (uint32_t point = 0; point < spring->unload.point_count; point++) {
                sedan->unload_deformation[i][point] = t;
                t += sedan_between(state, 0.02, 0.3);
            }
        }
    }
}

// Random forces for `count` designs of a problem: values[value * stride + design].
static inline void sedan_forces(const struct sedan *sedan, uint32_t value_count, uint64_t *state,
                                uint32_t count, double *values, size_t stride)
{
    const double greatest = 600e3 / sedan->setup.spring_count;
    for (uint32_t value = 0; value < value_count; value++) {
        for (uint32_t i = 0; i < count; i++) {
            values[value * stride + i] = greatest * sedan_random(state);
        }
    }
}

#endif
