#include "worker/models/model.h"

#include "worker/kinematics/kinematics.h"
#include "worker/models/closed_form.h"
#include "worker/models/small_overlap.h"

#include <assert.h>
#include <glib.h>
#include <stdbool.h>

// One function of the design: the crash model, or a formula. The other one is NULL.
struct part {
    struct kinematics_problem *problem;
    struct kinematics_problem *judged; // without what no constraint bounds
    double overlap;                    // [m]
    struct closed_form *form;
    uint32_t variable_count; // the same in all parts
    uint32_t outcome_count;
};

struct model {
    struct part *parts; // (part_count) one, or one a case
    uint32_t part_count;
    uint32_t variable_count;
    uint32_t outcome_count; // of all parts
};

// ---- Parts ----

// Whether some constraint of the whole scenario bounds one of the outcomes from..before.
static bool outcomes_bounded(const struct scenario *whole, uint32_t from, uint32_t before)
{
    for (uint32_t i = 0; i < whole->constraint_count; i++) {
        const uint32_t outcome = whole->constraints[i].outcome;
        if (outcome >= from && outcome < before) {
            return true;
        }
    }
    return false;
}

// What no constraint of the whole scenario bounds of this part, whose outcomes begin at `first`.
static struct kinematics_omitted part_omitted(const struct scenario *whole,
                                              const struct scenario *scenario, uint32_t first)
{
    const uint32_t energies = first + OUTCOME_LATERAL_WORK;
    const uint32_t deformations = first + OUTCOME_ENERGY_ABSORBED + scenario->spring_count;
    return (struct kinematics_omitted){
        .energies = !outcomes_bounded(whole, energies, deformations),
        .deformations =
            !outcomes_bounded(whole, deformations, deformations + scenario->spring_count),
    };
}

static void part_init(struct part *part, const struct scenario *whole,
                      const struct scenario *scenario, uint32_t first)
{
    *part = (struct part){.overlap = scenario->barrier.overlap};
    if (scenario->model == SCENARIO_MODEL_SMALL_OVERLAP) {
        part->problem = small_overlap_problem(scenario, NULL, (struct kinematics_omitted){0});
        part->judged = small_overlap_problem(scenario, NULL, part_omitted(whole, scenario, first));
        part->variable_count = kinematics_value_count(part->problem);
        part->outcome_count = kinematics_result_count(part->problem);
    } else {
        part->form = closed_form_create(scenario);
        part->variable_count = scenario->design_space.count;
        part->outcome_count = closed_form_outcome_count(part->form);
    }
}

static void part_fini(struct part *part)
{
    kinematics_free(part->judged);
    kinematics_free(part->problem);
    closed_form_free(part->form);
}

static void part_evaluate(const struct part *part, bool judged, uint32_t count,
                          const double *values, double *outcomes)
{
    if (part->form != NULL) {
        closed_form_evaluate(part->form, count, values, outcomes);
        return;
    }
    kinematics_evaluate(judged ? part->judged : part->problem, count, values, outcomes,
                        MODEL_BLOCK);
    small_overlap_outcomes(part->overlap, count, outcomes, MODEL_BLOCK);
}

// ---- The whole ----

struct model *model_create(const struct scenario *scenario)
{
    struct model *model = g_new(struct model, 1);
    *model = (struct model){
        .part_count = scenario->case_count > 0 ? scenario->case_count : 1,
    };
    model->parts = g_new(struct part, model->part_count);
    for (uint32_t i = 0; i < model->part_count; i++) {
        part_init(&model->parts[i], scenario,
                  scenario->case_count > 0 ? &scenario->cases[i] : scenario, model->outcome_count);
        model->outcome_count += model->parts[i].outcome_count;
    }
    model->variable_count = model->parts[0].variable_count;
    return model;
}

void model_free(struct model *model)
{
    if (model == NULL) {
        return;
    }
    for (uint32_t i = 0; i < model->part_count; i++) {
        part_fini(&model->parts[i]);
    }
    g_free(model->parts);
    g_free(model);
}

uint32_t model_variable_count(const struct model *model)
{
    return model->variable_count;
}

uint32_t model_outcome_count(const struct model *model)
{
    return model->outcome_count;
}

static void evaluate_parts(const struct model *model, bool judged, uint32_t count,
                           const double *values, double *outcomes)
{
    assert(count >= 1 && count <= MODEL_BLOCK);
    for (uint32_t i = 0; i < model->part_count; i++) {
        part_evaluate(&model->parts[i], judged, count, values, outcomes);
        outcomes += (size_t)model->parts[i].outcome_count * MODEL_BLOCK;
    }
}

void model_evaluate(const struct model *model, uint32_t count, const double *values,
                    double *outcomes)
{
    evaluate_parts(model, false, count, values, outcomes);
}

void model_evaluate_judged(const struct model *model, uint32_t count, const double *values,
                           double *outcomes)
{
    evaluate_parts(model, true, count, values, outcomes);
}
