#include "coordinator/report/reach.h"

#include "common/numeric/random.h"
#include "common/sampling/sampling.h"
#include "worker/kinematics/kinematics.h"
#include "worker/models/model.h"
#include "worker/models/small_overlap.h"

#include <assert.h>
#include <glib.h>

_Static_assert((int)REACH_POINTS % (int)MODEL_BLOCK == 0 &&
                   (int)REACH_CURVES % (int)MODEL_BLOCK == 0 &&
                   ((int)REACH_LEVELS + (int)REACH_BOUNDS) % (int)MODEL_BLOCK == 0,
               "designs are made in whole blocks of one kind: give each kind such a number");

// Numbers of steps that no search comes to, so that designs are drawn anew for each kind.
enum { STEP_POINTS = INT32_MAX - 2, STEP_CURVES, STEP_LEVELS };

// ---- Designs ----

static double at_level(const struct box *box, uint32_t variable, double level)
{
    const double lower = box->lower[variable], upper = box->upper[variable];
    return level >= 1 ? upper : lower + level * (upper - lower);
}

// The number of a spring's direction among all curves of the scenario.
static uint32_t curve_of(const struct scenario_variable *variable)
{
    return variable->spring * SCENARIO_DIRECTION_COUNT + (uint32_t)variable->direction;
}

static void fill_curves(const struct scenario *scenario, const struct box *box, uint64_t seed,
                        uint32_t first, double *values)
{
    for (uint32_t v = 0; v < box->count; v++)
        for (uint32_t i = 0; i < MODEL_BLOCK; i++)
            values[v * MODEL_BLOCK + i] = at_level(
                box, v,
                random_uniform(seed, 0, STEP_CURVES, first + i, curve_of(&scenario->variables[v])));
}

// The corners come first: design 0 to 3 has its axial curves at the bound that bit 0 says, its
// lateral ones at that of bit 1.
static double level_of(uint64_t seed, uint32_t design, enum scenario_direction direction)
{
    if (design < REACH_BOUNDS)
        return (design >> direction & 1) != 0 ? 1 : 0;
    return random_uniform(seed, 0, STEP_LEVELS, design, (uint32_t)direction);
}

static void fill_levels(const struct scenario *scenario, const struct box *box, uint64_t seed,
                        uint32_t first, double *values)
{
    for (uint32_t v = 0; v < box->count; v++)
        for (uint32_t i = 0; i < MODEL_BLOCK; i++)
            values[v * MODEL_BLOCK + i] =
                at_level(box, v, level_of(seed, first + i, scenario->variables[v].direction));
}

// A block of one kind; `index` counts designs over all kinds.
static void fill_block(const struct scenario *scenario, const struct box *box, uint64_t seed,
                       uint32_t index, double *values)
{
    const struct sampling points = {.seed = seed,
                                    .step = STEP_POINTS,
                                    .samples = REACH_POINTS,
                                    .method = SAMPLING_METHOD_UNIFORM};
    if (index < REACH_POINTS)
        sampling_fill(&points, box, index, MODEL_BLOCK, values, MODEL_BLOCK);
    else if (index < REACH_POINTS + REACH_CURVES)
        fill_curves(scenario, box, seed, index - REACH_POINTS, values);
    else
        fill_levels(scenario, box, seed, index - REACH_POINTS - REACH_CURVES, values);
}

// ---- Crashes ----

// Counts the designs of a block that turn too far; `turned` (MODEL_BLOCK) knows those that did in
// an earlier case.
static void take_turns(struct reach *reach, const double *yaw_max, bool *turned)
{
    const double degree = G_PI / 180.0; // [rad]
    for (uint32_t i = 0; i < MODEL_BLOCK; i++) {
        if (turned[i] || !small_overlap_turned(yaw_max[i] / degree))
            continue;
        turned[i] = true;
        reach->turned++;
    }
}

// Raises the greatest deformations to those of a block in one case. A motion that left the finite
// numbers says nothing.
static void take_block(struct reach *reach, const struct kinematics_problem *problem,
                       uint32_t spring_count, const double *values, double *results, bool *turned)
{
    kinematics_evaluate(problem, MODEL_BLOCK, values, results, MODEL_BLOCK);
    take_turns(reach, results + (size_t)KINEMATICS_YAW_MAX * MODEL_BLOCK, turned);
    for (uint32_t s = 0; s < spring_count; s++) {
        const double *row = results + (size_t)kinematics_deformation_row(problem, s) * MODEL_BLOCK;
        for (uint32_t i = 0; i < MODEL_BLOCK; i++)
            if (row[i] > reach->deformation_max[s])
                reach->deformation_max[s] = row[i];
    }
}

// All designs in one case: a case has the variables of its scenario, and a vehicle and a barrier of
// its own.
static void take_case(struct reach *reach, const struct scenario *of, const struct box *box,
                      uint64_t seed, bool turned[REACH_DESIGNS])
{
    const struct kinematics_omitted omitted = {.energies = true};
    struct kinematics_problem *problem = small_overlap_problem(of, NULL, omitted);
    assert(kinematics_value_count(problem) == box->count);
    double *values = g_new(double, (size_t)box->count *MODEL_BLOCK);
    double *results = g_new(double, (size_t)kinematics_result_count(problem) * MODEL_BLOCK);
    for (uint32_t index = 0; index < REACH_DESIGNS; index += MODEL_BLOCK) {
        fill_block(of, box, seed, index, values);
        take_block(reach, problem, of->spring_count, values, results, turned + index);
    }
    g_free(results);
    g_free(values);
    kinematics_free(problem);
}

void reach_find(struct reach *reach, const struct scenario *scenario, const struct box *box,
                uint64_t seed)
{
    *reach = (struct reach){0};
    if (scenario->spring_count == 0)
        return;
    assert(box->count == scenario->design_space.count);
    bool turned[REACH_DESIGNS] = {false};
    if (scenario->case_count == 0)
        take_case(reach, scenario, box, seed, turned);
    for (uint32_t i = 0; i < scenario->case_count; i++)
        take_case(reach, &scenario->cases[i], box, seed, turned);
    reach->spring_count = scenario->spring_count;
}

// ---- The rule ----

uint32_t reach_points(const struct reach *reach, const struct scenario *scenario, uint32_t spring)
{
    const struct scenario_spring *curve = &scenario->springs[spring];
    if (reach->spring_count == 0)
        return curve->point_count;
    assert(spring < reach->spring_count);
    const double pressed = reach->deformation_max[spring];
    // Only a spring that is pressed pushes, and not before its first point.
    if (!(pressed > 0 && pressed >= curve->deformation[0]))
        return 0;
    uint32_t count = 1;
    while (count < curve->point_count && pressed > curve->deformation[count - 1])
        count++;
    return count;
}

uint32_t reach_beyond(const struct reach *reach, const struct scenario *scenario, uint32_t spring)
{
    const uint32_t reached = reach_points(reach, scenario, spring);
    if (reached == scenario->springs[spring].point_count)
        return reached;
    return reached > 0 ? reached - 1 : 0;
}

bool reach_variable(const struct reach *reach, const struct scenario *scenario, uint32_t variable)
{
    const struct scenario_variable *place = &scenario->variables[variable];
    return place->spring == SCENARIO_NO_SPRING ||
           place->point < reach_points(reach, scenario, place->spring);
}

bool reach_everything(const struct reach *reach, const struct scenario *scenario)
{
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        if (reach_points(reach, scenario, i) < scenario->springs[i].point_count)
            return false;
    return true;
}
