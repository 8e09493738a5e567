#include "worker/kinematics/problem.h"

#include <assert.h>
#include <glib.h>
#include <math.h>

// What a deformation's rate may gain in a step and still be taken for resting by event Verlet
// [m/s2]: 1e-6 m of growth in a step of 1 ms. It is above what a step's errors leave of a spring
// that has come to rest, which falls with the cube of the step, and far below what any spring's
// force does, which is some hundred times as much.
#define PROBLEM_REST_ACCELERATION 1.0

// Appends a branch's points and says how the kernel finds them.
static struct problem_curve problem_add_curve(struct kinematics_problem *problem,
                                              const struct kinematics_curve *from)
{
    const uint32_t count = from->point_count;
    if (count == 0) {
        return (struct problem_curve){.point_count = 0};
    }
    assert(count >= 2);
    const struct problem_curve curve = {
        .point_count = count,
        .point = problem->point_count,
        .value = problem->value_count,
        .acts_above = from->deformation[0] > 0.0 ? nextafter(from->deformation[0], 0.0) : 0.0,
        .last = from->deformation[count - 1],
    };
    problem->deformation = g_renew(double, problem->deformation, problem->point_count + count);
    problem->inverse_width = g_renew(double, problem->inverse_width, problem->point_count + count);
    double *deformation = problem->deformation + problem->point_count;
    double *inverse_width = problem->inverse_width + problem->point_count;
    for (uint32_t i = 0; i < count; i++) {
        deformation[i] = from->deformation[i];
        inverse_width[i] = 0.0;
    }
    for (uint32_t i = 0; i + 1 < count; i++) {
        assert(deformation[i] < deformation[i + 1]);
        inverse_width[i] = 1.0 / (deformation[i + 1] - deformation[i]);
    }
    problem->point_count += count;
    problem->value_count += 2 * count;
    return curve;
}

// A spring whose end just touches the face at time 0 does so in decimal numbers; in binary ones its
// deformation may come out as some 1e-16 m. That would be contact for the integrators that let
// forces act at time 0, by an accident of rounding, so touching is made exact.
static double problem_reach(const struct kinematics_problem *problem,
                            const struct kinematics_spring *spring)
{
    const double touching = 1e-12; // [m] well above rounding, well below any measure of a car
    const double reach = spring->length - spring->position[0];
    return fabs(reach - problem->start_x) < touching ? problem->start_x : reach;
}

static void problem_add_spring(struct kinematics_problem *problem,
                               const struct kinematics_spring *from)
{
    struct problem_spring *spring = &problem->springs[problem->spring_count++];
    spring->position_x = from->position[0];
    spring->position_y = from->position[1];
    spring->length = from->length;
    spring->reach = problem_reach(problem, from);
    assert(from->load.point_count > 0);
    spring->load = problem_add_curve(problem, &from->load);
    spring->unload = problem_add_curve(problem, &from->unload);
    problem->features.unload |= spring->unload.point_count > 0;
    problem->features.late_start |= spring->load.acts_above > 0.0;
}

struct kinematics_problem *kinematics_create(const struct kinematics_setup *setup)
{
    assert(setup->mass > 0.0);
    assert(setup->yaw_inertia > 0.0);
    assert(setup->spring_count >= 1 && setup->spring_count <= KINEMATICS_SPRING_MAX);
    assert(setup->time_step > 0.0 && setup->time_step <= setup->duration);
    const double steps = round(setup->duration / setup->time_step);
    assert(steps < (double)UINT32_MAX);

    struct kinematics_problem *problem = g_new0(struct kinematics_problem, 1);
    problem->mass = setup->mass;
    problem->yaw_inertia = setup->yaw_inertia;
    problem->speed = setup->speed;
    problem->start_x = setup->cog[0] - setup->face_x;
    problem->start_y = setup->cog[1];
    problem->face_x = setup->face_x;
    problem->edge_y = setup->edge_y;
    problem->far_y = setup->edge_y - setup->width;
    problem->edge_radius = setup->edge_radius;
    problem->time_step = setup->time_step;
    problem->rest = PROBLEM_REST_ACCELERATION * setup->time_step * setup->time_step;
    problem->step_count = (uint32_t)steps;
    problem->integrator = setup->integrator;
    problem->features.rounded =
        setup->profile == KINEMATICS_PROFILE_ROUNDED && setup->edge_radius > 0.0;
    problem->features.crushed = setup->reloading == KINEMATICS_RELOADING_CRUSHED;
    problem->features.work = !setup->omitted.energies;
    problem->features.deepest = !setup->omitted.deformations;
    problem->features.events = setup->integrator == KINEMATICS_EVENT_VERLET;
    problem->lowest_y = problem->highest_y = setup->springs[0].position[1];
    for (uint32_t i = 0; i < setup->spring_count; i++) {
        problem_add_spring(problem, &setup->springs[i]);
        problem->lowest_y = fmin(problem->lowest_y, setup->springs[i].position[1]);
        problem->highest_y = fmax(problem->highest_y, setup->springs[i].position[1]);
    }
    assert(problem->value_count <= KINEMATICS_VALUE_MAX);
    return problem;
}

void kinematics_free(struct kinematics_problem *problem)
{
    if (problem != NULL) {
        g_free(problem->deformation);
        g_free(problem->inverse_width);
        g_free(problem);
    }
}

uint32_t kinematics_value_count(const struct kinematics_problem *problem)
{
    return problem->value_count;
}

uint32_t kinematics_result_count(const struct kinematics_problem *problem)
{
    return KINEMATICS_WORK + 2 * problem->spring_count;
}

uint32_t kinematics_deformation_row(const struct kinematics_problem *problem, uint32_t index)
{
    assert(index < problem->spring_count);
    return KINEMATICS_WORK + problem->spring_count + index;
}

uint32_t kinematics_row_count(const struct kinematics_problem *problem)
{
    return problem->step_count + 1;
}

uint32_t kinematics_column_count(const struct kinematics_problem *problem)
{
    return KINEMATICS_COLUMN_SPRING + problem->spring_count * KINEMATICS_SPRING_COLUMN_COUNT;
}
