// Constraints: what a design must meet to be good.
#ifndef SOBOX_COMMON_SCENARIO_CONSTRAINT_H
#define SOBOX_COMMON_SCENARIO_CONSTRAINT_H

#include "common/scenario/scenario.h"
#include "common/scenario/tree.h"

// Adds min <= outcome <= max; an infinite bound is none. Outcome and design space are known. There
// is room for SCENARIO_CONSTRAINT_MAX.
void constraint_add(struct scenario *scenario, uint32_t outcome, double min, double max);

// Adds the user's constraints from the mapping `node`, NULL for none, to those that the model
// brings along. Returns false with `error` filled (STATUS_INVALID).
bool constraint_read(const struct tree_node *node, struct scenario *scenario, struct error *error);

#endif
