#include "coordinator/search/plan.h"

#include "coordinator/search/explain.h"
#include "coordinator/search/tournament.h"

#include <math.h>

// The bad share to consolidate to, as a part of what the next certificate allows: so far below it
// that the certificate passes with near certainty, and not further.
static const double plan_share_wanted = 0.5;

// A budget that cuts steps short leaves no room for a second certificate, and the box follows less
// closely: with hardly any step left it is this part of that part.
static const double plan_share_short = 0.4;

uint64_t plan_steps_affordable(const struct plan *plan, uint64_t spent, uint32_t samples)
{
    const struct scenario_search *settings = &plan->scenario->search;
    if (settings->evaluations == 0)
        return UINT64_MAX;
    const uint64_t spoken_for =
        spent + settings->certificate_samples + explain_reserve(plan->scenario);
    return spoken_for < settings->evaluations ? (settings->evaluations - spoken_for) / samples : 0;
}

void plan_init(struct plan *plan, const struct scenario *scenario, uint64_t spent)
{
    const struct scenario_search *settings = &scenario->search;
    *plan = (struct plan){.scenario = scenario,
                          .exploration_steps = settings->exploration_steps,
                          .consolidation_steps = settings->consolidation_steps};
    const uint64_t wanted = (uint64_t)settings->exploration_steps + settings->consolidation_steps;
    const uint64_t affordable = plan_steps_affordable(plan, spent, settings->samples);
    if (affordable >= wanted)
        return;
    plan->exploration_steps = (uint32_t)(affordable * settings->exploration_steps / wanted);
    plan->consolidation_steps = (uint32_t)affordable - plan->exploration_steps;
}

uint32_t plan_starts(const struct plan *plan)
{
    const struct scenario_search *settings = &plan->scenario->search;
    const bool given =
        settings->start != NULL || settings->start_box.count > 0 || settings->reference != NULL;
    const uint32_t most = plan->exploration_steps / 2 > 1 ? plan->exploration_steps / 2 : 1;
    uint32_t count = settings->starts;
    if (count == 0)
        count = given ? 1 : tournament_starts(plan->exploration_steps);
    return settings->starts > 0 && count > most ? most : count;
}

double plan_bad_share(const struct plan *plan, const struct certificate *certificate)
{
    const struct scenario_search *settings = &plan->scenario->search;
    const int64_t most =
        certificate_bad_max(certificate, settings->certificate_samples, settings->target_purity);
    // With (sqrt(m + 1) - 0.82)^2 bad samples expected, more than m come in 5 % of cases; where m
    // is large the box's own uncertainty counts for more.
    const double root = most >= 0 ? sqrt((double)most + 1) - 0.82 : 0;
    const double sure = root * root / settings->certificate_samples;
    double share = plan_share_wanted * (double)most / settings->certificate_samples;
    share = share < sure ? share : sure;
    // A certificate that allows no bad sample says little about what it would take.
    if (most <= 0)
        share = (1 - settings->target_purity) / 4;
    if (plan->consolidation_steps < settings->consolidation_steps)
        share *= plan_share_short +
                 (1 - plan_share_short) * plan->consolidation_steps / settings->consolidation_steps;
    // Each miss shows that the box comes out worse than it was meant to.
    for (uint32_t look = 0; look < certificate->looks; look++)
        share *= 0.9;
    return share;
}
