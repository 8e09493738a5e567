#include "worker/models/model.h"
#include "worker/kinematics/kinematics.h"
#include "worker/models/small_overlap.h"

#include <assert.h>
#include <glib.h>

struct model {
    struct kinematics_problem *problem;
    double overlap; // [m]
};

struct model *model_create(const struct scenario *scenario)
{
    assert(scenario->model == SCENARIO_MODEL_SMALL_OVERLAP);
    struct model *model = g_new(struct model, 1);
    model->problem = small_overlap_problem(scenario, NULL);
    model->overlap = scenario->barrier.overlap;
    return model;
}

void model_free(struct model *model)
{
    if (model != NULL) {
        kinematics_free(model->problem);
        g_free(model);
    }
}

uint32_t model_variable_count(const struct model *model)
{
    return kinematics_value_count(model->problem);
}

uint32_t model_outcome_count(const struct model *model)
{
    return kinematics_result_count(model->problem);
}

void model_evaluate(const struct model *model, uint32_t count, const double *values,
                    double *outcomes)
{
    assert(count >= 1 && count <= MODEL_BLOCK);
    kinematics_evaluate(model->problem, count, values, outcomes, MODEL_BLOCK);
    small_overlap_outcomes(model->overlap, count, outcomes, MODEL_BLOCK);
}
