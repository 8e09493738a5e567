#include "common/scenario/scenario.h"

#include "common/scenario/formula.h"
#include "common/scenario/plausibility_find.h"
#include "common/scenario/words.h"

#include "common/numeric/rounding.h"
#include <assert.h>

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

const char *const scenario_model_words[] = {
    [SCENARIO_MODEL_SMALL_OVERLAP] = "small_overlap",
    [SCENARIO_MODEL_HYPERSPHERE] = "hypersphere",
    [SCENARIO_MODEL_ELLIPSE] = "ellipse",
    [SCENARIO_MODEL_LINEAR] = "linear",
    [SCENARIO_MODEL_ROSENBROCK] = "rosenbrock",
    [SCENARIO_MODEL_TWO_SECTION_CRASH] = "two_section_crash",
    [SCENARIO_MODEL_ORDERED_CRASH] = "ordered_crash",
    [SCENARIO_MODEL_CORRIDOR_CRASH] = "corridor_crash",
    NULL,
};
const char *const scenario_profile_words[] = {
    [SCENARIO_PROFILE_FLAT] = "flat",
    [SCENARIO_PROFILE_ROUNDED] = "rounded",
    NULL,
};
const char *const scenario_integrator_words[] = {
    [SCENARIO_INTEGRATOR_CENTRAL_DIFFERENCE] = "central_difference",
    [SCENARIO_INTEGRATOR_VELOCITY_VERLET] = "velocity_verlet",
    [SCENARIO_INTEGRATOR_RUNGE_KUTTA_4] = "runge_kutta_4",
    [SCENARIO_INTEGRATOR_EVENT_VERLET] = "event_verlet",
    NULL,
};
const char *const scenario_reloading_words[] = {
    [SCENARIO_RELOADING_THESIS] = "thesis",
    [SCENARIO_RELOADING_CRUSHED] = "crushed",
    NULL,
};
const char *const scenario_response_words[] = {
    [SCENARIO_RESPONSE_ANY] = "any",
    [SCENARIO_RESPONSE_ROTATING] = "rotating",
    [SCENARIO_RESPONSE_GLANCING_OFF] = "glancing_off",
    NULL,
};
const char *const scenario_sampling_words[] = {
    [SAMPLING_METHOD_UNIFORM] = "uniform",
    [SAMPLING_METHOD_LATIN_HYPERCUBE] = "latin_hypercube",
    [SAMPLING_METHOD_SOBOL] = "sobol",
    NULL,
};
const char *const scenario_promise_words[] = {
    [PROMISE_POINTS] = "points",
    [PROMISE_CURVES] = "curves",
    [PROMISE_EVERY] = "every",
    NULL,
};

static const struct {
    const char *name;
    const char *unit;
} outcomes[] = {
#define OUTCOME_ENTRY(enumerator, text, si_unit, meaning) \
    [enumerator] = {.name = text, .unit = si_unit},
    OUTCOME_LIST(OUTCOME_ENTRY)
#undef OUTCOME_ENTRY
};

void scenario_init(struct scenario *scenario)
{
    *scenario = (struct scenario){
        .model = SCENARIO_MODEL_SMALL_OVERLAP,
        .barrier = {.width = 1.15, .edge_radius = 0.15, .profile = SCENARIO_PROFILE_FLAT},
        .simulation =
            {
                .duration = 0.150,
                .time_step = 1.0e-3,
                .integrator = SCENARIO_INTEGRATOR_EVENT_VERLET,
                .reloading = SCENARIO_RELOADING_CRUSHED,
            },
        .search =
            {
                .samples = 200,
                .exploration_steps = 100,
                .consolidation_steps = 100,
                .certificate_samples = 10000,
                .target_purity = 0.99,
                .seed = 1,
                .promise = PROMISE_EVERY,
                .sampling = SAMPLING_METHOD_UNIFORM,
                .explain_samples = SCENARIO_EXPLAIN_AUTO,
            },
    };
}

static void search_fini(struct scenario_search *search)
{
    g_free(search->start);
    box_fini(&search->start_box);
    g_free(search->reference);
    g_free(search->weights);
    g_free(search->minimum_widths);
    g_free(search->hold.lower);
    g_free(search->hold.upper);
    g_free(search->tie);
}

static bool both_held(const struct scenario_hold *hold, uint32_t variable)
{
    return hold->lower != NULL && hold->upper != NULL && !isnan(hold->lower[variable]) &&
           !isnan(hold->upper[variable]);
}

bool scenario_is_box(const struct scenario *scenario)
{
    const struct box *space = &scenario->design_space;
    for (uint32_t v = 0; v < space->count; v++) {
        if (space->lower[v] < space->upper[v] && !both_held(&scenario->search.hold, v))
            return false;
    }
    return true;
}

static bool is_free(const double *held, uint32_t variable)
{
    return held == NULL || isnan(held[variable]);
}

bool scenario_is_rounded(const struct scenario *scenario, const struct box *box, uint32_t variable)
{
    const struct scenario_hold *hold = &scenario->search.hold;
    const double step = scenario->search.round;
    if (!(step > 0) || box->lower[variable] == box->upper[variable])
        return true;
    const bool all = scenario_is_box(scenario);
    return !((all || is_free(hold->lower, variable)) &&
             !rounding_is_multiple(box->lower[variable], step)) &&
           !((all || is_free(hold->upper, variable)) &&
             !rounding_is_multiple(box->upper[variable], step));
}

void scenario_fini(struct scenario *scenario)
{
    for (uint32_t i = 0; i < scenario->case_count; i++)
        scenario_fini(&scenario->cases[i]);
    g_free(scenario->cases);
    search_fini(&scenario->search);
    g_free(scenario->formula.inputs);
    g_free(scenario->formula.constants);
    g_free(scenario->springs);
    g_free(scenario->variables);
    curve_map_fini(&scenario->curves);
    box_fini(&scenario->design_space);
    g_free(scenario->constraints);
    plausibility_find_free(scenario);
    g_free(scenario->text);
    *scenario = (struct scenario){0};
}

// ------------------------------------------------------------------------------------------------
// Outcomes

// Of a scenario without cases.
static uint32_t own_outcome_count(const struct scenario *scenario)
{
    return scenario->model == SCENARIO_MODEL_SMALL_OVERLAP
               ? OUTCOME_ENERGY_ABSORBED + 2 * scenario->spring_count
               : formula_outcome_count(scenario);
}

uint32_t scenario_outcome_count(const struct scenario *scenario)
{
    if (scenario->case_count == 0)
        return own_outcome_count(scenario);
    uint32_t count = 0;
    for (uint32_t i = 0; i < scenario->case_count; i++)
        count += own_outcome_count(&scenario->cases[i]);
    return count;
}

// The case that has the outcome, or the scenario itself; `outcome` becomes its index there.
static const struct scenario *owner(const struct scenario *scenario, uint32_t *outcome)
{
    assert(*outcome < scenario_outcome_count(scenario));
    if (scenario->case_count == 0)
        return scenario;
    uint32_t index = 0;
    while (*outcome >= own_outcome_count(&scenario->cases[index]))
        *outcome -= own_outcome_count(&scenario->cases[index++]);
    return &scenario->cases[index];
}

uint32_t scenario_outcome_find(const struct scenario *scenario, const char *name)
{
    uint32_t count = scenario_outcome_count(scenario);
    char candidate[SCENARIO_OUTCOME_NAME_SIZE];
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(scenario_outcome_name(scenario, i, candidate), name) == 0)
            return i;
    }
    return count;
}

// Whether an outcome of the crash model is a spring's greatest deformation.
static bool is_deformation(const struct scenario *scenario, uint32_t outcome)
{
    return outcome >= OUTCOME_ENERGY_ABSORBED + scenario->spring_count;
}

static void own_outcome_name(const struct scenario *scenario, uint32_t outcome,
                             char name[SCENARIO_OUTCOME_NAME_SIZE])
{
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP)
        formula_outcome_name(scenario, outcome, name);
    else if (outcome < OUTCOME_ENERGY_ABSORBED)
        g_strlcpy(name, outcomes[outcome].name, SCENARIO_OUTCOME_NAME_SIZE);
    else {
        const uint32_t row = outcome - OUTCOME_ENERGY_ABSORBED;
        snprintf(name, SCENARIO_OUTCOME_NAME_SIZE, "%s.%s",
                 is_deformation(scenario, outcome) ? "deformation_max" : "energy_absorbed",
                 scenario->springs[row % scenario->spring_count].name);
    }
}

const char *scenario_outcome_name(const struct scenario *scenario, uint32_t outcome,
                                  char name[SCENARIO_OUTCOME_NAME_SIZE])
{
    char own[SCENARIO_OUTCOME_NAME_SIZE];
    const struct scenario *of = owner(scenario, &outcome);
    own_outcome_name(of, outcome, own);
    g_strlcpy(name, of == scenario ? "" : of->name, SCENARIO_OUTCOME_NAME_SIZE);
    g_strlcat(name, of == scenario ? "" : ".", SCENARIO_OUTCOME_NAME_SIZE);
    g_strlcat(name, own, SCENARIO_OUTCOME_NAME_SIZE);
    return name;
}

const char *scenario_outcome_unit(const struct scenario *scenario, uint32_t outcome)
{
    const struct scenario *of = owner(scenario, &outcome);
    if (of->model != SCENARIO_MODEL_SMALL_OVERLAP)
        return formula_outcome_unit(of, outcome);
    if (outcome < OUTCOME_ENERGY_ABSORBED)
        return outcomes[outcome].unit;
    return is_deformation(of, outcome) ? "m" : "J";
}

// ------------------------------------------------------------------------------------------------
// Words

const char *scenario_model_name(enum scenario_model model)
{
    return scenario_model_words[model];
}

const char *scenario_response_name(enum scenario_response response)
{
    return scenario_response_words[response];
}

const char *scenario_integrator_name(enum scenario_integrator integrator)
{
    return scenario_integrator_words[integrator];
}

const char *scenario_reloading_name(enum scenario_reloading reloading)
{
    return scenario_reloading_words[reloading];
}

const char *scenario_sampling_name(enum sampling_method sampling)
{
    return scenario_sampling_words[sampling];
}

const char *scenario_profile_name(enum scenario_profile profile)
{
    return scenario_profile_words[profile];
}

const char *scenario_direction_name(enum scenario_direction direction)
{
    static const char *const names[] = {[SCENARIO_DIRECTION_X] = "x", [SCENARIO_DIRECTION_Y] = "y"};
    return names[direction];
}
