// Reads what only the crash model has: vehicle, barrier, springs, simulation, response.
#ifndef SOBOX_COMMON_SCENARIO_CRASH_READ_H
#define SOBOX_COMMON_SCENARIO_CRASH_READ_H

#include "common/scenario/scenario.h"
#include "common/scenario/tree.h"

struct crash_document {
    const struct tree_node *vehicle;
    const struct tree_node *barrier;
    const struct tree_node *springs;
    const struct tree_node *simulation; // NULL: all default
    const struct tree_node *firewall_distance;
};

// Fills vehicle, barrier, springs, simulation, variables and design space, and adds the constraints
// of the response, and holds the numbers against what cars are like (plausibility.h). Response and
// firewall distance are in the scenario already. Returns false with `error` filled
// (STATUS_INVALID).
bool crash_read(const struct crash_document *document, struct scenario *scenario,
                struct error *error);

#endif
