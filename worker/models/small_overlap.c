#include "worker/models/small_overlap.h"

#include <glib.h>
#include <math.h>

#define SAME(result, outcome)                       \
    _Static_assert((int)(result) == (int)(outcome), \
                   "results and outcomes share their rows: give both lists the same order")
SAME(KINEMATICS_LENGTH_LAST, OUTCOME_S_L);
SAME(KINEMATICS_LENGTH_MIN, OUTCOME_S_L_MIN);
SAME(KINEMATICS_PILLAR_TRAVEL, OUTCOME_ABWAP);
SAME(KINEMATICS_PROJECTION_TRAVEL, OUTCOME_ABWP);
SAME(KINEMATICS_YAW, OUTCOME_YAW_DEG);
SAME(KINEMATICS_YAW_MAX, OUTCOME_YAW_MAX_DEG);
SAME(KINEMATICS_TRAVEL_X, OUTCOME_TRAVEL_X);
SAME(KINEMATICS_TRAVEL_Y, OUTCOME_TRAVEL_Y);
SAME(KINEMATICS_DELTA_VX, OUTCOME_DELTA_VX);
SAME(KINEMATICS_DELTA_VY, OUTCOME_DELTA_VY);
SAME(KINEMATICS_ACCELERATION_MAX, OUTCOME_DECEL_MAX_G);
SAME(KINEMATICS_ACCELERATION_MEAN, OUTCOME_DECEL_MEAN_G);
SAME(KINEMATICS_KINETIC_ENERGY, OUTCOME_KINETIC_ENERGY);
SAME(KINEMATICS_LATERAL_WORK, OUTCOME_LATERAL_WORK);
SAME(KINEMATICS_ENERGY_BALANCE, OUTCOME_ENERGY_BALANCE);
SAME(KINEMATICS_WORK, OUTCOME_ENERGY_ABSORBED);
#undef SAME

static enum kinematics_integrator small_overlap_integrator(enum scenario_integrator integrator)
{
    switch (integrator) {
    case SCENARIO_INTEGRATOR_VELOCITY_VERLET:
        return KINEMATICS_VELOCITY_VERLET;
    case SCENARIO_INTEGRATOR_RUNGE_KUTTA_4:
        return KINEMATICS_RUNGE_KUTTA_4;
    case SCENARIO_INTEGRATOR_EVENT_VERLET:
        return KINEMATICS_EVENT_VERLET;
    case SCENARIO_INTEGRATOR_CENTRAL_DIFFERENCE:
        break;
    }
    return KINEMATICS_CENTRAL_DIFFERENCE;
}

static struct kinematics_spring small_overlap_spring(const struct scenario_spring *spring,
                                                     const struct design_spring *design)
{
    struct kinematics_spring made = {
        .position = {spring->position[0], spring->position[1]},
        .length = spring->length,
        .load = {spring->deformation, spring->point_count},
    };
    if (design != NULL) {
        made.load = (struct kinematics_curve){design->load.deformation, design->load.point_count};
        made.unload =
            (struct kinematics_curve){design->unload.deformation, design->unload.point_count};
    }
    return made;
}

struct kinematics_problem *small_overlap_problem(const struct scenario *scenario,
                                                 const struct design *design,
                                                 struct kinematics_omitted omitted)
{
    struct kinematics_spring springs[KINEMATICS_SPRING_MAX];
    _Static_assert((int)SCENARIO_SPRING_MAX <= (int)KINEMATICS_SPRING_MAX,
                   "the kinematics must take every scenario: raise KINEMATICS_SPRING_MAX");
    _Static_assert((int)SCENARIO_VARIABLE_MAX <= (int)KINEMATICS_VALUE_MAX &&
                       4 * DESIGN_POINT_MAX <= KINEMATICS_VALUE_MAX,
                   "the kinematics must take every design: raise KINEMATICS_VALUE_MAX");
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        springs[i] = small_overlap_spring(&scenario->springs[i],
                                          design != NULL ? &design->springs[i] : NULL);
    }
    const struct scenario_barrier *barrier = &scenario->barrier;
    const struct kinematics_setup setup = {
        .mass = scenario->vehicle.mass,
        .yaw_inertia = scenario->vehicle.yaw_inertia,
        .speed = scenario->vehicle.speed,
        .cog = {scenario->vehicle.cog[0], scenario->vehicle.cog[1]},
        .face_x = barrier->face_x,
        .edge_y = barrier->edge_y,
        .width = barrier->width,
        .edge_radius = barrier->edge_radius,
        .profile = barrier->profile == SCENARIO_PROFILE_ROUNDED ? KINEMATICS_PROFILE_ROUNDED
                                                                : KINEMATICS_PROFILE_FLAT,
        .springs = springs,
        .spring_count = scenario->spring_count,
        .duration = scenario->simulation.duration,
        .time_step = scenario->simulation.time_step,
        .integrator = small_overlap_integrator(scenario->simulation.integrator),
        .reloading = scenario->simulation.reloading == SCENARIO_RELOADING_CRUSHED
                         ? KINEMATICS_RELOADING_CRUSHED
                         : KINEMATICS_RELOADING_THESIS,
        .omitted = omitted,
    };
    return kinematics_create(&setup);
}

static double *values_of_branch(const struct design_branch *branch, double *values)
{
    for (int direction = 0; direction < SCENARIO_DIRECTION_COUNT; direction++) {
        for (uint32_t point = 0; point < branch->point_count; point++) {
            *values++ = branch->force[direction][point];
        }
    }
    return values;
}

void small_overlap_values(const struct design *design, double *values)
{
    for (uint32_t i = 0; i < design->spring_count; i++) {
        values = values_of_branch(&design->springs[i].load, values);
        values = values_of_branch(&design->springs[i].unload, values);
    }
}

// outcome /= by, for all designs.
static void divide(double *outcomes, enum outcome outcome, double by, uint32_t count, size_t stride)
{
    double *row = outcomes + (size_t)outcome * stride;
    for (uint32_t i = 0; i < count; i++) {
        row[i] /= by;
    }
}

void small_overlap_outcomes(double overlap, uint32_t count, double *outcomes, size_t stride)
{
    const double degree = G_PI / 180.0; // [rad]
    divide(outcomes, OUTCOME_ABWAP, overlap, count, stride);
    divide(outcomes, OUTCOME_ABWP, overlap, count, stride);
    divide(outcomes, OUTCOME_YAW_DEG, degree, count, stride);
    divide(outcomes, OUTCOME_YAW_MAX_DEG, degree, count, stride);
    divide(outcomes, OUTCOME_TRAVEL_X, -1.0, count, stride); // positive forwards
    divide(outcomes, OUTCOME_DECEL_MAX_G, SMALL_OVERLAP_GRAVITY, count, stride);
    divide(outcomes, OUTCOME_DECEL_MEAN_G, SMALL_OVERLAP_GRAVITY, count, stride);
}

bool small_overlap_turned(double yaw_max_deg)
{
    const double upright = 90.0; // [degrees] at it the cosine is 0, or rounding
    return yaw_max_deg >= upright && yaw_max_deg < (double)INFINITY;
}
