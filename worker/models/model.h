// A model: a function from a design to outcomes. Prepared once from a scenario, then read-only and
// shared by all threads. With cases it is the functions of all cases, whose outcomes stand one
// after the other as scenario_outcome_name() counts them.
#ifndef SOBOX_WORKER_MODELS_MODEL_H
#define SOBOX_WORKER_MODELS_MODEL_H

#include "common/scenario/scenario.h"

#include <stddef.h>
#include <stdint.h>

enum {
    MODEL_BLOCK = 64, // designs that model_evaluate() takes at once: whole vectors of every width
};

struct model;

// Prepares the model of a scenario; keeps no pointer into it. The caller frees it.
struct model *model_create(const struct scenario *scenario);
void model_free(struct model *model);

uint32_t model_variable_count(const struct model *model);
uint32_t model_outcome_count(const struct model *model);

// Evaluates `count` (1..MODEL_BLOCK) designs. values[variable * MODEL_BLOCK + i] is a variable of
// design i; outcomes[outcome * MODEL_BLOCK + i] receives its outcomes. Lanes from `count` up are
// neither read nor left untouched. The result of a design does not depend on its lane or on its
// neighbours. Allocates nothing.
void model_evaluate(const struct model *model, uint32_t count, const double *values,
                    double *outcomes);

// The same for one who only holds the outcomes against the scenario's constraints: energies
// are 0 where none bounds an energy, deformations where none bounds a deformation. The energies
// take a quarter of the time.
void model_evaluate_judged(const struct model *model, uint32_t count, const double *values,
                           double *outcomes);

#endif
