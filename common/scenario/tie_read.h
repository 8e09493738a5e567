// Variables that share a corridor: `search.tie`, a list of lists of names.
#ifndef SOBOX_COMMON_SCENARIO_TIE_READ_H
#define SOBOX_COMMON_SCENARIO_TIE_READ_H

#include "common/scenario/scenario.h"
#include "common/scenario/tree.h"

// Fills search->tie from the list `node`. Springs that are tied stand for each other point by
// point, so they must have the same points, and variables the same design space. Returns false with
// `error` filled.
bool tie_read(const struct tree_node *node, const struct scenario *scenario,
              struct scenario_search *search, struct error *error);

#endif
