// Scenarios as crashes of the reference.
#ifndef SOBOX_TESTS_PHYSICS_REFERENCE_SCENARIO_H
#define SOBOX_TESTS_PHYSICS_REFERENCE_SCENARIO_H

#include "common/scenario/scenario.h"
#include "tests/physics/reference.h"

#include <stddef.h>
#include <string.h>

// The crash of a scenario without its forces and without a step.
static inline struct reference_crash reference_crash_of(const struct scenario *scenario)
{
    const struct scenario_barrier *barrier = &scenario->barrier;
    struct reference_crash crash = {
        .mass = scenario->vehicle.mass,
        .yaw_inertia = scenario->vehicle.yaw_inertia,
        .speed = scenario->vehicle.speed,
        .cog = {scenario->vehicle.cog[0], scenario->vehicle.cog[1]},
        .face_x = barrier->face_x,
        .edge_y = barrier->edge_y,
        .width = barrier->width,
        .radius = barrier->profile == SCENARIO_PROFILE_ROUNDED ? barrier->edge_radius : 0.0,
        .crushed = scenario->simulation.reloading == SCENARIO_RELOADING_CRUSHED,
        .duration = scenario->simulation.duration,
        .spring_count = scenario->spring_count,
    };
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const struct scenario_spring *from = &scenario->springs[i];
        struct reference_spring *to = &crash.springs[i];
        to->length = from->length;
        to->point_count = from->point_count;
        memcpy(to->place, from->position, sizeof to->place);
        memcpy(to->deformation, from->deformation, from->point_count * sizeof *to->deformation);
    }
    return crash;
}

// The forces of one design, in the order of the scenario's variables: values[variable * stride].
static inline void reference_set_forces(struct reference_crash *crash, const double *values,
                                        size_t stride)
{
    for (uint32_t i = 0; i < crash->spring_count; i++) {
        for (int direction = 0; direction < 2; direction++) {
            for (uint32_t point = 0; point < crash->springs[i].point_count; point++) {
                crash->springs[i].force[direction][point] = *values;
                values += stride;
            }
        }
    }
}

#endif
