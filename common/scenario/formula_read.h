// Reads what only models in closed form have: variables and parameters.
#ifndef SOBOX_COMMON_SCENARIO_FORMULA_READ_H
#define SOBOX_COMMON_SCENARIO_FORMULA_READ_H

#include "common/scenario/scenario.h"
#include "common/scenario/tree.h"

struct formula_document {
    const struct tree_node *root; // of the scenario
    const struct tree_node *variables;
    const struct tree_node *parameters; // NULL: there are none
};

// Fills variables, design space and formula, and adds the constraints of limits among the
// parameters. The model is in the scenario already. Returns false with `error` filled
// (STATUS_INVALID).
bool formula_read(const struct formula_document *document, struct scenario *scenario,
                  struct error *error);

#endif
