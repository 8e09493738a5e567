// What a search says of itself: how far it has come, and what it has found.
#include "coordinator/search/search_state.h"

#include <glib.h>
#include <math.h>

// Steps still to come if everything goes as it should.
static uint32_t steps_left(const struct search *search)
{
    uint32_t left = 0;
    // It is not known before it begins which bounds lie on the edge of the design space.
    if (search->scenario->search.explain_samples > 0 && search->phase < SEARCH_PHASE_EXPLAIN)
        left += explain_steps_most(search->scenario);
    switch (search->phase) {
    case SEARCH_PHASE_SEEK:
        left += 1 + search->plan.exploration_steps + search->plan.consolidation_steps +
                DESIGN_KIND_COUNT;
        break;
    case SEARCH_PHASE_EXPLORE:
        left += search->plan.exploration_steps - search->tournament.steps +
                search->plan.consolidation_steps + DESIGN_KIND_COUNT;
        break;
    case SEARCH_PHASE_CONSOLIDATE:
        left += search->consolidate.step_count - search->consolidate.steps + DESIGN_KIND_COUNT;
        break;
    case SEARCH_PHASE_CERTIFY:
        left += DESIGN_KIND_COUNT - (uint32_t)search->kind;
        break;
    case SEARCH_PHASE_EXPLAIN:
        left += search->explain.step_count - search->explained;
        break;
    case SEARCH_PHASE_DONE:
        break;
    }
    return left;
}

void search_progress(const struct search *search, struct search_progress *progress)
{
    const struct search_step *last = &search->last;
    *progress = (struct search_progress){
        .phase = search->phase,
        .step = search->step,
        .step_count = search->step + steps_left(search),
        .evaluations = search->evaluations,
        .good_share = search->step > 0 ? (double)last->good / last->samples : 0,
        .log_volume = box_log_volume(&search->result, &search->frame.all),
        .box = &search->result,
    };
}

static uint32_t blocking_constraint(const struct search *search)
{
    uint32_t most = 0;
    for (uint32_t i = 1; i < G_N_ELEMENTS(search->blocked); i++) {
        if (search->blocked[i] > search->blocked[most])
            most = i;
    }
    return most;
}

static struct digest result_digest(const struct search *search)
{
    struct digest_state state;
    digest_start(&state);
    digest_doubles(&state, search->result.lower, search->result.count);
    digest_doubles(&state, search->result.upper, search->result.count);
    digest_u64(&state, search->counted.status);
    digest_u64(&state, search->counted.step);
    digest_u64(&state, search->counted.evaluations);
    digest_u64(&state, search->counted.non_finite);
    digest_u64(&state, search->certificate.samples);
    digest_u64(&state, search->certificate.bad);
    for (int kind = DESIGN_KIND_POINTS + 1; kind < DESIGN_KIND_COUNT; kind++) {
        digest_u64(&state, search->kinds[kind].samples);
        digest_u64(&state, search->kinds[kind].bad);
    }
    return digest_end(&state);
}

static struct search_purity purity_of(const struct certificate *certificate)
{
    struct search_purity purity = {
        .samples = certificate->samples, .bad = certificate->bad, .lower95 = certificate->lower95};
    if (certificate->samples > 0)
        purity.estimate =
            (double)(certificate->samples - certificate->bad) / (double)certificate->samples;
    return purity;
}

void search_result(const struct search *search, struct search_result *result)
{
    *result = (struct search_result){
        .status = search->status,
        .box = &search->result,
        .log_volume = box_log_volume(&search->result, &search->frame.all),
        .evaluations = search->evaluations,
        .non_finite = search->non_finite + search->non_finite_beside,
        .steps = search->step,
        .blocking_constraint = blocking_constraint(search),
        .digest = result_digest(search),
    };
    if (search->every.worst.count > 0 && isfinite(search->every.margin)) {
        result->worst = search->every.worst.lower;
        result->margin = search->every.margin;
    }
    result->holders = search->every.holders;
    result->gains = search->every.gains;
    result->purity = purity_of(&search->certificate);
    for (int kind = DESIGN_KIND_POINTS; kind < DESIGN_KIND_COUNT; kind++)
        result->kinds[kind] =
            purity_of(kind == DESIGN_KIND_POINTS ? &search->certificate : &search->kinds[kind]);
}
