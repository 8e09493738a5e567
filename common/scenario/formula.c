#include "common/scenario/formula.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stdio.h>

struct formula_outcome {
    const char *name;
    const char *unit;
};

// The linear model's outcome stands for all its rows.
static const struct {
    uint32_t count;
    struct formula_outcome outcomes[3];
} formulas[SCENARIO_MODEL_COUNT] = {
    [SCENARIO_MODEL_HYPERSPHERE] = {1, {{"distance", "1"}}},
    [SCENARIO_MODEL_ELLIPSE] = {1, {{"level", "1"}}},
    [SCENARIO_MODEL_LINEAR] = {0, {{"row", "1"}}},
    [SCENARIO_MODEL_ROSENBROCK] = {1, {{"value", "1"}}},
    [SCENARIO_MODEL_TWO_SECTION_CRASH] =
        {3,
         {
             [FORMULA_TWO_SECTION_ENERGY_REMAINING] = {"energy_remaining", "J"},
             [FORMULA_TWO_SECTION_DECEL_MAX] = {"decel_max", "m/s2"},
             [FORMULA_TWO_SECTION_ORDER] = {"order", "N"},
         }},
    [SCENARIO_MODEL_ORDERED_CRASH] = {3,
                                      {
                                          [FORMULA_ORDERED_ENERGY_REMAINING] = {"energy_remaining",
                                                                                "J"},
                                          [FORMULA_ORDERED_ORDER_MAX] = {"order_max", "N"},
                                          [FORMULA_ORDERED_DECEL_MAX] = {"decel_max", "m/s2"},
                                      }},
    [SCENARIO_MODEL_CORRIDOR_CRASH] =
        {2,
         {
             [FORMULA_CORRIDOR_ENERGY_REMAINING] = {"energy_remaining", "J"},
             [FORMULA_CORRIDOR_FORCE_MAX] = {"force_max", "N"},
         }},
};

uint32_t formula_outcome_count(const struct scenario *scenario)
{
    assert(scenario->model != SCENARIO_MODEL_SMALL_OVERLAP);
    return scenario->model == SCENARIO_MODEL_LINEAR ? scenario->formula.rows
                                                    : formulas[scenario->model].count;
}

const char *formula_outcome_name(const struct scenario *scenario, uint32_t outcome,
                                 char name[SCENARIO_OUTCOME_NAME_SIZE])
{
    assert(outcome < formula_outcome_count(scenario));
    if (scenario->model == SCENARIO_MODEL_LINEAR)
        snprintf(name, SCENARIO_OUTCOME_NAME_SIZE, "row_%u", outcome + 1);
    else
        g_strlcpy(name, formulas[scenario->model].outcomes[outcome].name,
                  SCENARIO_OUTCOME_NAME_SIZE);
    return name;
}

const char *formula_outcome_unit(const struct scenario *scenario, uint32_t outcome)
{
    assert(outcome < formula_outcome_count(scenario));
    return scenario->model == SCENARIO_MODEL_LINEAR
               ? "1"
               : formulas[scenario->model].outcomes[outcome].unit;
}

// ---- How large outcomes get ----

// The greatest magnitude that an input has in the design space.
static double greatest(const struct scenario *scenario, uint32_t index)
{
    const struct scenario_input *input = &scenario->formula.inputs[index];
    if (input->variable == SCENARIO_CONSTANT)
        return fabs(input->value);
    return fmax(fabs(scenario->design_space.lower[input->variable]),
                fabs(scenario->design_space.upper[input->variable]));
}

static double greatest_from(const struct scenario *scenario, uint32_t first)
{
    double force = 0;
    for (uint32_t i = first; i < scenario->formula.input_count; i++)
        force = fmax(force, greatest(scenario, i));
    return force;
}

static double row_scale(const struct scenario *scenario, uint32_t row)
{
    const struct scenario_formula *formula = &scenario->formula;
    double sum = 0;
    for (uint32_t i = 0; i < formula->input_count; i++)
        sum += fabs(formula->constants[row * formula->input_count + i]) * greatest(scenario, i);
    return sum;
}

static double two_section_scale(const struct scenario *scenario,
                                enum formula_two_section_outcome outcome)
{
    const double force = fmax(greatest(scenario, FORMULA_TWO_SECTION_F1),
                              greatest(scenario, FORMULA_TWO_SECTION_F2));
    const double speed = greatest(scenario, FORMULA_TWO_SECTION_SPEED);
    const double mass = greatest(scenario, FORMULA_TWO_SECTION_MASS);
    switch (outcome) {
    case FORMULA_TWO_SECTION_ENERGY_REMAINING:
        return 0.5 * mass * speed * speed;
    case FORMULA_TWO_SECTION_DECEL_MAX:
        return force / mass;
    case FORMULA_TWO_SECTION_ORDER:
        return force;
    }
    return 1;
}

static double ordered_scale(const struct scenario *scenario, enum formula_ordered_outcome outcome)
{
    const double force = greatest_from(scenario, FORMULA_ORDERED_FORCE);
    const double speed = greatest(scenario, FORMULA_ORDERED_SPEED);
    const double mass = greatest(scenario, FORMULA_ORDERED_MASS);
    switch (outcome) {
    case FORMULA_ORDERED_ENERGY_REMAINING:
        return 0.5 * mass * speed * speed;
    case FORMULA_ORDERED_ORDER_MAX:
        return force;
    case FORMULA_ORDERED_DECEL_MAX:
        return force / mass;
    }
    return 1;
}

static double corridor_scale(const struct scenario *scenario, enum formula_corridor_outcome outcome)
{
    return outcome == FORMULA_CORRIDOR_ENERGY_REMAINING
               ? greatest(scenario, FORMULA_CORRIDOR_ENERGY)
               : greatest_from(scenario, FORMULA_CORRIDOR_FORCE);
}

double formula_outcome_scale(const struct scenario *scenario, uint32_t outcome)
{
    assert(outcome < formula_outcome_count(scenario));
    double scale = 1;
    switch (scenario->model) {
    case SCENARIO_MODEL_HYPERSPHERE:
        scale = sqrt(scenario->formula.input_count) / 2;
        break;
    case SCENARIO_MODEL_LINEAR:
        scale = row_scale(scenario, outcome);
        break;
    case SCENARIO_MODEL_TWO_SECTION_CRASH:
        scale = two_section_scale(scenario, (enum formula_two_section_outcome)outcome);
        break;
    case SCENARIO_MODEL_ORDERED_CRASH:
        scale = ordered_scale(scenario, (enum formula_ordered_outcome)outcome);
        break;
    case SCENARIO_MODEL_CORRIDOR_CRASH:
        scale = corridor_scale(scenario, (enum formula_corridor_outcome)outcome);
        break;
    default:
        break;
    }
    return scale > 0 && isfinite(scale) ? scale : 1;
}
