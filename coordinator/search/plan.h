// What a search may spend: how its budget of evaluations is shared between exploration and
// consolidation, how many boxes are to grow, and how pure the box has to become for its
// certificate.
#ifndef SOBOX_COORDINATOR_SEARCH_PLAN_H
#define SOBOX_COORDINATOR_SEARCH_PLAN_H

#include "common/scenario/scenario.h"
#include "coordinator/search/certificate.h"

struct plan {
    const struct scenario *scenario; // borrowed
    uint32_t exploration_steps;      // what the budget leaves of the scenario's
    uint32_t consolidation_steps;    // likewise
};

// Shares what is left after `spent` evaluations between exploration and consolidation as the
// scenario does. `scenario` is borrowed.
void plan_init(struct plan *plan, const struct scenario *scenario, uint64_t spent);

// How many steps of `samples` the budget has room for after `spent` evaluations, beside a
// certificate and an explanation; without a budget UINT64_MAX.
uint64_t plan_steps_affordable(const struct plan *plan, uint64_t spent, uint32_t samples);

// How many boxes are to grow. Where something was given to begin with, no others are sought unless
// asked for. Each needs two steps at least.
uint32_t plan_starts(const struct plan *plan);

// The share of bad designs to consolidate to, so that the next look of `certificate` passes with
// near certainty.
double plan_bad_share(const struct plan *plan, const struct certificate *certificate);

#endif
