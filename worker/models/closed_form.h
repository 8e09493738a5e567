// Models in closed form (common/scenario/formula.h says what each computes): one row of numbers an
// input, one an outcome, the designs side by side. Additions, products, divisions and square roots
// only, each exactly rounded, in a fixed order: the same bits on every machine.
#ifndef SOBOX_WORKER_MODELS_CLOSED_FORM_H
#define SOBOX_WORKER_MODELS_CLOSED_FORM_H

#include "common/scenario/scenario.h"

#include <stddef.h>

struct closed_form;

// Prepares the formula of a scenario that is not of the crash model and has no cases of its own.
// Nothing is kept. The caller frees it.
struct closed_form *closed_form_create(const struct scenario *scenario);
void closed_form_free(struct closed_form *form);

uint32_t closed_form_outcome_count(const struct closed_form *form);

// As model_evaluate(): rows of MODEL_BLOCK.
void closed_form_evaluate(const struct closed_form *form, uint32_t count, const double *values,
                          double *outcomes);

#endif
