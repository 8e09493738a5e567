#include "coordinator/search/search.h"

#include "coordinator/search/search_state.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

enum {
    SEARCH_SEEK_CHOICE = 4, // good designs sought for each start: a choice, lest a region be missed
    SEARCH_ARCHIVE = 1 << 20,     // numbers of bad samples that are remembered, and
    SEARCH_ARCHIVE_BAD = 1 << 14, // bad samples at least
};

// The bad share that exploration aims at: enough bad samples to shape the box by.
static const double search_explore_bad = 0.3;

// How fast the volume follows the good share while exploring: it has far to go.
static const double search_explore_volume_gain = 1.2;
static const double search_explore_volume_eager = 4; // at most, times as fast

// The box that is being worked on; there is one once exploration has begun.
static struct explore *current(struct search *search)
{
    return tournament_current(&search->tournament);
}

// The box of the free variables that stands for the search as it is: until there is one, what is
// being sampled; if there will be none, the least violating design alone.
static const struct box *standing(struct search *search)
{
    const struct explore *explore = current(search);
    if (search->every.box.count > 0)
        return &search->every.box;
    return explore == NULL ? &search->seek.box : &explore->box;
}

// ---- what to sample next

void search_ask_requested(struct search *search, uint32_t samples, enum sampling_method method,
                          enum verdict_detail detail)
{
    search->request = (struct search_request){
        .sampling = {.seed = search->seed,
                     .step = search->step,
                     .samples = samples,
                     .method = method,
                     .curves = &search->scenario->curves},
        .phase = search->phase,
        .detail = detail,
        .box = &search->requested,
    };
}

void search_ask(struct search *search, const struct box *box, uint32_t samples,
                enum sampling_method method, enum verdict_detail detail)
{
    frame_widen(&search->frame, box, &search->requested);
    search_ask_requested(search, samples, method, detail);
}

// Just outside the next bound.
static void ask_slab(struct search *search)
{
    box_assign(&search->requested, explain_slab(&search->explain, search->explained));
    search_ask_requested(search, search->explain_samples, SAMPLING_METHOD_UNIFORM,
                         VERDICT_DETAIL_FULL);
}

// Whether a box holds one design only: it is looked at once.
static bool is_design(const struct box *box)
{
    for (uint32_t v = 0; v < box->count; v++) {
        if (box->lower[v] != box->upper[v])
            return false;
    }
    return true;
}

static void ask_next(struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    if (search_every_active(search)) {
        search_every_ask(search);
        return;
    }
    switch (search->phase) {
    case SEARCH_PHASE_SEEK:
        search_ask(search, &search->seek.box, is_design(&search->seek.box) ? 1 : settings->samples,
                   SAMPLING_METHOD_LATIN_HYPERCUBE, VERDICT_DETAIL_FULL);
        break;
    case SEARCH_PHASE_EXPLORE:
        search_ask(search, &current(search)->sampled, settings->samples, settings->sampling,
                   VERDICT_DETAIL_FULL);
        break;
    case SEARCH_PHASE_CONSOLIDATE:
        search_ask(search, &current(search)->sampled, search->samples, settings->sampling,
                   VERDICT_DETAIL_FULL);
        break;
    case SEARCH_PHASE_CERTIFY:
        // Clopper-Pearson holds for independent samples only.
        if (search->kind != DESIGN_KIND_POINTS) {
            search_ask(search, &current(search)->box, search->kind_samples,
                       protocol_kind_method(search->kind), VERDICT_DETAIL_SHARE);
            break;
        }
        search_ask(search, &current(search)->box, settings->certificate_samples,
                   SAMPLING_METHOD_UNIFORM,
                   settings->explain_samples > 0 ? VERDICT_DETAIL_FULL : VERDICT_DETAIL_SHARE);
        break;
    case SEARCH_PHASE_EXPLAIN:
        ask_slab(search);
        break;
    case SEARCH_PHASE_DONE:
        break;
    }
}

// ---- the samples of the finished step

static void recall(struct search *search, const struct verdict *verdicts)
{
    const struct sampling *sampling = &search->request.sampling;
    search->good_count = verdict_good_count(verdicts, sampling->samples);
    if (search->phase == SEARCH_PHASE_EXPLAIN || search->kind != DESIGN_KIND_POINTS ||
        search_every_active(search))
        return; // makes its own again, or is only counted
    // How badly a certificate's samples violate is known only when the box is to be explained, and
    // no box may depend on that.
    const bool known = search->phase != SEARCH_PHASE_CERTIFY;
    recall_step(&search->recall, sampling, &search->requested, verdicts, search->good_count, known);
}

// Keeps the bad samples for good, as far as there is room.
static void remember(struct search *search)
{
    const struct box *sampled =
        search->phase == SEARCH_PHASE_SEEK ? &search->seek.box : &current(search)->sampled;
    const uint32_t most = SEARCH_ARCHIVE / search->frame.space.count;
    survey_add(&search->survey, sampled, search->recall.looked_at, &search->recall.bad,
               most > SEARCH_ARCHIVE_BAD ? most : SEARCH_ARCHIVE_BAD);
}

static void count_verdicts(struct search *search, const struct verdict *verdicts)
{
    const uint32_t samples = search->request.sampling.samples;
    search->evaluations += samples;
    if (search->request.detail == VERDICT_DETAIL_SHARE)
        return;
    const bool beside =
        search->phase == SEARCH_PHASE_CERTIFY || search->phase == SEARCH_PHASE_EXPLAIN;
    uint64_t *non_finite = beside ? &search->non_finite_beside : &search->non_finite;
    for (uint32_t i = 0; i < samples; i++) {
        *non_finite += verdicts[i].violation == VERDICT_NON_FINITE;
        if (search->phase == SEARCH_PHASE_SEEK && verdicts[i].violation != VERDICT_GOOD)
            search->blocked[verdicts[i].constraint]++;
    }
}

// ---- from phase to phase

static void finish(struct search *search, enum search_status status)
{
    search->phase = SEARCH_PHASE_DONE;
    search->status = status;
    search->counted = (struct counted){.step = search->step,
                                       .evaluations = search->evaluations,
                                       .non_finite = search->non_finite,
                                       .status = status};
}

void search_begin_explain(struct search *search, enum search_status status)
{
    search->phase = SEARCH_PHASE_DONE;
    search->status = status;
    // Where every design is good, the limits of the box have said already what holds it.
    if (search->scenario->search.explain_samples == 0 || search->every.holders != NULL)
        return;
    frame_widen(&search->frame, standing(search), &search->result);
    explain_init(&search->explain, search->scenario, &search->result);
    search->explain_samples = explain_samples(&search->scenario->search, search->explain.step_count,
                                              search->counted.evaluations);
    if (search->explain_samples == 0)
        return;
    search->phase = SEARCH_PHASE_EXPLAIN;
    search->status = SEARCH_STATUS_RUNNING;
}

// A budget that was given leaves nothing for an attack.
void search_finish_box(struct search *search, enum search_status status)
{
    finish(search, status);
    const bool attacked = search->every.box.count > 0;
    if (attacked || search->scenario->search.evaluations > 0) {
        search_begin_explain(search, status);
        return;
    }
    search_every_look(search, standing(search), status);
    search->status = SEARCH_STATUS_RUNNING;
}

static void complete_explain(struct search *search)
{
    if (++search->explained == search->explain.step_count) {
        search->phase = SEARCH_PHASE_DONE;
        search->status = search->counted.status;
    }
}

static bool has_volume(const struct box *box, const struct box *space)
{
    return volume_of(box, space).mantissa > 0;
}

static void start_certify(struct search *search)
{
    if (search->scenario->search.round > 0)
        demands_round(&search->demands, search->scenario->search.round, &current(search)->box);
    if (has_volume(&current(search)->box, &search->frame.space))
        search->phase = SEARCH_PHASE_CERTIFY;
    else
        finish(search, SEARCH_STATUS_NO_GOOD_DESIGN);
}

// The tournament is over before it starts: `box` has won.
static void award(struct search *search, const struct box *box)
{
    search->tournament.demands = &search->demands;
    tournament_award(&search->tournament, &search->frame.space, box);
}

static void start_consolidate(struct search *search, uint32_t steps, double bad_from)
{
    search->phase = SEARCH_PHASE_CONSOLIDATE;
    stagnation_reset(&search->stagnation);
    consolidate_start(&search->consolidate, current(search), steps, bad_from,
                      plan_bad_share(&search->plan, &search->certificate));
    if (steps == 0)
        start_certify(search);
}

// A box that did not get anywhere in the steps it had: what the samples so far leave of the design
// space is more than a single design.
static void cut_from_space(struct search *search)
{
    struct trim_options options = trim_options_default();
    options.threads = search->threads;
    options.keep = search->demands.reference;
    struct box cut;
    box_init(&cut, search->frame.space.count);
    trim(&search->frame.space, NULL, &search->seek.good, &search->survey.bad, &options, &cut);
    tournament_fini(&search->tournament);
    award(search, &cut);
    box_fini(&cut);
}

static void end_explore(struct search *search)
{
    if (!has_volume(&current(search)->box, &search->frame.space))
        cut_from_space(search);
    start_consolidate(search, search->plan.consolidation_steps, search_explore_bad);
}

// Lines up what was given, then what was found.
static void start_explore(struct search *search)
{
    plan_init(&search->plan, search->scenario, search->evaluations);
    uint32_t count = plan_starts(&search->plan);
    if (search->scenario->search.promise != PROMISE_POINTS &&
        search->scenario->search.starts == 0 && search->given.begin.count == 0)
        count = (search->plan.exploration_steps + search->plan.consolidation_steps) / 20;
    struct cloud starts;
    cloud_init(&starts, search->frame.space.count);
    const bool begun = search->given.begin.count > 0;
    if (begun) {
        cloud_add(&starts, search->given.begin.lower, 1, 0);
        count--;
    }
    seek_starts(&search->seek, count, &starts);
    if (search->scenario->search.promise != PROMISE_POINTS) {
        search_every_start(search, &starts,
                           search->plan.exploration_steps + search->plan.consolidation_steps);
        cloud_fini(&starts);
        return;
    }
    search->tournament.demands = &search->demands;
    tournament_start(&search->tournament, &search->frame.space, &starts,
                     search->plan.exploration_steps);
    if (begun)
        explore_begin(&search->tournament.explores[0], &search->given.begin);
    cloud_fini(&starts);
    search->phase = SEARCH_PHASE_EXPLORE;
    if (search->plan.exploration_steps == 0)
        end_explore(search);
}

// Whether the whole design space turned out good when it was last sampled.
static bool all_good(const struct search *search)
{
    return search->good_count == search->request.sampling.samples;
}

// Sampled the whole design space and found it good: there is nothing to search for.
static void take_whole_space(struct search *search)
{
    if (search->scenario->search.promise != PROMISE_POINTS) {
        // Not for an adversary, perhaps: the design space is where it begins.
        struct cloud none;
        cloud_init(&none, search->frame.space.count);
        search_every_start(search, &none,
                           search->plan.exploration_steps + search->plan.consolidation_steps);
        cloud_fini(&none);
        return;
    }
    award(search, &search->frame.space);
    start_certify(search);
}

// No good design: what remains to be said is which design violates least.
static void give_up(struct search *search)
{
    const struct cloud *elite = &search->seek.elite;
    for (uint32_t v = 0; v < search->frame.space.count; v++)
        search->seek.box.lower[v] = search->seek.box.upper[v] = cloud_column(elite, v)[0];
    finish(search, SEARCH_STATUS_NO_GOOD_DESIGN);
}

// Has nothing more to look for: explores what there is.
static void end_seek(struct search *search)
{
    if (search->given.begin.count > 0 || search->seek.good.count > 0)
        start_explore(search);
    else
        give_up(search);
}

static void complete_given(struct search *search)
{
    struct given *given = &search->given;
    given_complete(given, search->good_count > 0);
    if (given->stage == GIVEN_REFUSED) {
        finish(search, SEARCH_STATUS_NO_GOOD_DESIGN);
        return;
    }
    seek_note(&search->seek, &search->recall.good, &search->recall.bad,
              search->request.sampling.samples);
    given_box(given, &search->seek.box);
    const bool enough = given->begin.count > 0 && plan_starts(&search->plan) == 1;
    const uint64_t affordable =
        plan_steps_affordable(&search->plan, search->evaluations, search->scenario->search.samples);
    if (given->stage == GIVEN_NONE && (enough || affordable == 0))
        end_seek(search);
}

static void complete_seek(struct search *search)
{
    if (search->given.stage != GIVEN_NONE) {
        complete_given(search);
        return;
    }
    const bool whole = box_equal(&search->seek.box, &search->frame.space);
    seek_complete(&search->seek, &search->recall.good, &search->recall.bad,
                  search->request.sampling.samples);
    // With something to begin with, others are welcome but not needed.
    const bool begun = search->given.begin.count > 0 && search->seek.round >= SEEK_WHOLE_ROUNDS;
    if (whole && all_good(search))
        take_whole_space(search);
    else if (search->seek.state != SEEK_LOOKING || begun ||
             plan_steps_affordable(&search->plan, search->evaluations,
                                   search->scenario->search.samples) == 0)
        end_seek(search);
}

// What the finished step showed.
static struct explore_step shown(const struct search *search)
{
    return (struct explore_step){
        .good = &search->recall.good,
        .bad = &search->recall.bad,
        .samples = search->request.sampling.samples,
        .good_count = search->good_count,
        .threads = search->threads,
    };
}

static bool stagnates(struct search *search)
{
    const struct box *box = &current(search)->box;
    return stagnation_note(&search->stagnation,
                           demands_volume(&search->demands, box, &search->frame.space));
}

// Whether the last box left is balanced and no longer gains anything.
static bool explored_enough(struct search *search)
{
    return search->tournament.left_count == 1 && current(search)->balancing && stagnates(search);
}

static void complete_explore(struct search *search)
{
    struct explore_step step = shown(search);
    step.bad_share = search_explore_bad;
    step.gain = explore_gain;
    step.volume_gain = search_explore_volume_gain;
    step.volume_eager_max = search_explore_volume_eager;
    const struct explore *sampled = current(search);
    const bool spent = tournament_complete(&search->tournament, &step);
    if (all_good(search) && explore_whole(sampled)) {
        tournament_fini(&search->tournament);
        take_whole_space(search);
    } else if (spent || explored_enough(search)) {
        end_explore(search);
    }
}

static void complete_consolidate(struct search *search)
{
    if (consolidate_complete(&search->consolidate, current(search), shown(search), &search->survey))
        start_certify(search);
    else if (consolidate_resting(&search->consolidate) && stagnates(search))
        consolidate_hasten(&search->consolidate);
}

// The next kind of designs that this model tells apart from points; DESIGN_KIND_COUNT: none is
// left.
enum design_kind search_next_kind(const struct search *search)
{
    const struct curve_map *curves = &search->scenario->curves;
    enum design_kind kind = search->kind;
    do
        kind++;
    while ((kind == DESIGN_KIND_CURVES && curves->count == curves->variables) ||
           (kind == DESIGN_KIND_LEVELS && curves->group_count == curves->variables));
    return kind;
}

// The looks at points are over: what is left of the budget looks at the other kinds.
static void end_certify(struct search *search, enum search_status status)
{
    const struct scenario_search *settings = &search->scenario->search;
    search->certified = status;
    search->kind_samples = settings->certificate_samples;
    if (settings->evaluations > 0) {
        const uint64_t spoken_for = search->evaluations + explain_reserve(search->scenario);
        const uint64_t left =
            spoken_for < settings->evaluations ? settings->evaluations - spoken_for : 0;
        const uint64_t each = left / (DESIGN_KIND_COUNT - 1);
        search->kind_samples = each < search->kind_samples ? (uint32_t)each : search->kind_samples;
    }
    if (search->kind_samples > 0)
        search->kind = search_next_kind(search);
    else
        search_finish_box(search, status);
}

// One look, at the box as it is: it changes nothing, so no other look has to be counted.
static void complete_kind(struct search *search)
{
    const uint32_t samples = search->request.sampling.samples;
    certificate_look_once(&search->kinds[search->kind], samples, samples - search->good_count);
    search->kind = search_next_kind(search);
    if ((uint32_t)search->kind < DESIGN_KIND_COUNT)
        return;
    search->kind = DESIGN_KIND_POINTS;
    search_finish_box(search, search->certified);
}

static void complete_certify(struct search *search)
{
    if (search->kind != DESIGN_KIND_POINTS) {
        complete_kind(search);
        return;
    }
    const struct scenario_search *settings = &search->scenario->search;
    struct certificate *certificate = &search->certificate;
    const double bad_before = plan_bad_share(&search->plan, &search->certificate);
    certificate_look(certificate, search->request.sampling.samples,
                     search->request.sampling.samples - search->good_count);
    if (certificate->lower95 >= settings->target_purity) {
        end_certify(search, SEARCH_STATUS_DONE);
        return;
    }
    const bool hopeless = certificate->looks == CERTIFICATE_LOOKS ||
                          scenario_is_box(search->scenario) ||
                          certificate_bad_max(certificate, settings->certificate_samples,
                                              settings->target_purity) < 0;
    if (hopeless) {
        end_certify(search, SEARCH_STATUS_PURITY_MISSED);
        return;
    }
    search->samples = search->samples > UINT32_MAX / 2 ? search->samples : 2 * search->samples;
    const uint64_t affordable =
        plan_steps_affordable(&search->plan, search->evaluations, search->samples);
    uint32_t steps = settings->consolidation_steps / 4;
    steps = steps > 0 ? steps : 1;
    steps = steps < affordable ? steps : (uint32_t)affordable;
    if (steps == 0)
        end_certify(search, SEARCH_STATUS_PURITY_MISSED);
    else
        start_consolidate(search, steps, bad_before);
}

static void note_step(struct search *search, enum search_phase phase, double growth)
{
    search->last = (struct search_step){
        .step = search->request.sampling.step,
        .phase = phase,
        .samples = search->request.sampling.samples,
        .good = search->good_count,
        .growth = growth,
        .log_volume = box_log_volume(&search->result, &search->frame.all),
    };
}

static void complete_phase(struct search *search, enum search_phase phase)
{
    switch (phase) {
    case SEARCH_PHASE_SEEK:
        complete_seek(search);
        break;
    case SEARCH_PHASE_EXPLORE:
        complete_explore(search);
        break;
    case SEARCH_PHASE_CONSOLIDATE:
        complete_consolidate(search);
        break;
    case SEARCH_PHASE_CERTIFY:
        complete_certify(search);
        break;
    case SEARCH_PHASE_EXPLAIN:
        complete_explain(search);
        break;
    case SEARCH_PHASE_DONE:
        break;
    }
}

void search_complete(struct search *search, const struct verdict *verdicts)
{
    assert(search->phase != SEARCH_PHASE_DONE);
    const enum search_phase phase = search->phase;
    const bool every = search_every_active(search);
    const double growth = phase == SEARCH_PHASE_EXPLORE && !every ? current(search)->rate : 0;
    count_verdicts(search, verdicts);
    recall(search, verdicts);
    if (phase != SEARCH_PHASE_EXPLAIN && search->kind == DESIGN_KIND_POINTS && !every)
        remember(search);
    search->step++;
    if (every)
        search_every_complete(search, verdicts);
    else
        complete_phase(search, phase);
    frame_widen(&search->frame, standing(search), &search->result);
    note_step(search, phase, growth);
    ask_next(search);
}

// ---- making and asking

// There is a box, and nothing to search: it is certified as it is.
static void take_given_box(struct search *search)
{
    if (search->scenario->search.promise != PROMISE_POINTS)
        search_every_take(search);
    else
        take_whole_space(search);
}

struct search *search_create(const struct scenario *scenario, uint64_t seed, int threads)
{
    assert(threads > 0);
    struct search *search = g_new0(struct search, 1);
    search->scenario = scenario;
    search->seed = seed;
    search->threads = threads;
    frame_init(&search->frame, scenario);
    const uint32_t all = scenario->design_space.count;
    box_init(&search->requested, all);
    box_init(&search->result, all);
    box_assign(&search->result, &search->frame.all);
    demands_init(&search->demands, &scenario->search, search->frame.variables,
                 &search->frame.space);
    recall_init(&search->recall, &search->frame);
    survey_init(&search->survey, &search->frame.space);
    search->samples = scenario->search.samples;
    plan_init(&search->plan, search->scenario, search->evaluations);
    stagnation_init(&search->stagnation, scenario->search.stagnation);
    seek_init(&search->seek, &search->frame.space, SEARCH_SEEK_CHOICE * plan_starts(&search->plan));
    given_init(&search->given, &scenario->search, &search->frame);
    given_box(&search->given, &search->seek.box);
    consolidate_init(&search->consolidate, &search->frame.space);
    search->phase = SEARCH_PHASE_SEEK;
    if (scenario_is_box(scenario))
        take_given_box(search);
    ask_next(search);
    return search;
}

void search_free(struct search *search)
{
    if (search == NULL)
        return;
    search_every_fini(&search->every);
    tournament_fini(&search->tournament);
    consolidate_fini(&search->consolidate);
    demands_fini(&search->demands);
    explain_fini(&search->explain);
    stagnation_fini(&search->stagnation);
    seek_fini(&search->seek);
    recall_fini(&search->recall);
    survey_fini(&search->survey);
    frame_fini(&search->frame);
    given_fini(&search->given);
    box_fini(&search->requested);
    box_fini(&search->result);
    g_free(search);
}

bool search_request(const struct search *search, struct search_request *request)
{
    if (search->phase == SEARCH_PHASE_DONE)
        return false;
    *request = search->request;
    return true;
}

const struct search_step *search_last_step(const struct search *search)
{
    assert(search->step > 0);
    return &search->last;
}
