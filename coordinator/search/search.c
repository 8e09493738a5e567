#include "coordinator/search/search.h"

#include "coordinator/search/certificate.h"
#include "coordinator/search/consolidate.h"
#include "coordinator/search/demands.h"
#include "coordinator/search/explain.h"
#include "coordinator/search/seek.h"
#include "coordinator/search/stagnation.h"
#include "coordinator/search/tournament.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

enum {
    SEARCH_SEEK_CHOICE = 4, // good designs sought for each start: a choice, lest a region be missed
    SEARCH_CHUNK = 1024,    // samples made at once when a step is gone through
    SEARCH_GOOD_KEPT = 512, // good samples of a step that the trim may anchor on
    SEARCH_BAD_KEPT = 2048, // bad samples of a step that are looked at: more would not tell more
    SEARCH_ARCHIVE = 1 << 20,     // numbers of bad samples that are remembered, and
    SEARCH_ARCHIVE_BAD = 1 << 14, // bad samples at least
};

// The bad share that exploration aims at: enough bad samples to shape the box by.
static const double search_explore_bad = 0.3;

// How fast the volume follows the good share while exploring: it has far to go.
static const double search_explore_volume_gain = 1.2;
static const double search_explore_volume_eager = 4; // at most, times as fast

// The bad share to consolidate to, as a part of what the next certificate allows: so far below it
// that the certificate passes with near certainty, and not further.
static const double search_share_wanted = 0.5;

// A budget that cuts steps short leaves no room for a second certificate, and the box follows less
// closely: with hardly any step left it is this part of that part.
static const double search_share_short = 0.4;

// What was given to begin with is looked at first.
enum given {
    GIVEN_REFERENCE, // is it good?
    GIVEN_START,     // is the start, or anything in the start box, good?
    GIVEN_NONE,      // nothing is left to look at
};

// What the digest covers beside the box.
struct counted {
    uint32_t step;
    uint64_t evaluations;
    uint64_t non_finite;
    enum search_status status;
};

struct search {
    const struct scenario *scenario; // borrowed
    uint64_t seed;
    int threads;

    // The free variables, in which everything below is expressed.
    uint32_t *variables; // (space.count) index among all variables
    struct box space;    // what is not held of the design space
    struct box frame;    // all variables: the design space, variables held to a value without width
    struct demands demands;

    // Where the search stands.
    enum search_phase phase;
    enum search_status status;
    struct search_request request;
    struct box requested; // all variables; request.box points here
    struct search_step last;
    uint32_t step; // steps finished
    uint64_t evaluations;
    uint64_t non_finite;

    // Seek.
    enum given given;
    struct box begin; // what was given, with a good design in it; count 0: none
    struct seek seek;
    uint64_t blocked[256]; // bad samples of the seek by worst constraint

    struct tournament tournament;
    struct consolidate consolidate;
    uint32_t samples;             // a step of consolidation
    uint32_t exploration_steps;   // what the budget leaves of the scenario's
    uint32_t consolidation_steps; // likewise
    struct stagnation stagnation; // of the box that is left, then of the one at rest

    struct certificate certificate;

    // Explain.
    struct explain explain;
    uint32_t explained;         // bounds, of explain.step_count
    uint32_t explain_samples;   // a bound
    uint64_t non_finite_beside; // in samples of which nothing in the box depends
    struct counted counted;     // before it

    // The samples of the step that is being completed.
    struct cloud good;
    struct cloud bad;
    struct survey survey; // the steps since exploration began, the newest
    uint32_t good_count;
    uint32_t looked_at; // samples of the step, the first ones, whose bad ones are all in `bad`
    double *chunk;      // (all variables x SEARCH_CHUNK)

    struct box result; // all variables
};

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
    return explore == NULL ? &search->seek.box : &explore->box;
}

// Puts a box of the free variables into one of all variables.
static void widen(const struct search *search, const struct box *box, struct box *all)
{
    box_assign(all, &search->frame);
    for (uint32_t v = 0; v < box->count; v++) {
        all->lower[search->variables[v]] = box->lower[v];
        all->upper[search->variables[v]] = box->upper[v];
    }
}

// ---- what to sample next

static void ask_requested(struct search *search, uint32_t samples, enum sampling_method method,
                          enum verdict_detail detail)
{
    search->request = (struct search_request){
        .sampling = {.seed = search->seed,
                     .step = search->step,
                     .samples = samples,
                     .method = method},
        .phase = search->phase,
        .detail = detail,
        .box = &search->requested,
    };
}

static void ask(struct search *search, const struct box *box, uint32_t samples,
                enum sampling_method method, enum verdict_detail detail)
{
    widen(search, box, &search->requested);
    ask_requested(search, samples, method, detail);
}

// Just outside the next bound.
static void ask_slab(struct search *search)
{
    box_assign(&search->requested, explain_slab(&search->explain, search->explained));
    ask_requested(search, search->explain_samples, SAMPLING_METHOD_UNIFORM, VERDICT_DETAIL_FULL);
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
    switch (search->phase) {
    case SEARCH_PHASE_SEEK:
        ask(search, &search->seek.box, is_design(&search->seek.box) ? 1 : settings->samples,
            SAMPLING_METHOD_LATIN_HYPERCUBE, VERDICT_DETAIL_FULL);
        break;
    case SEARCH_PHASE_EXPLORE:
        ask(search, &current(search)->sampled, settings->samples, settings->sampling,
            VERDICT_DETAIL_FULL);
        break;
    case SEARCH_PHASE_CONSOLIDATE:
        ask(search, &current(search)->sampled, search->samples, settings->sampling,
            VERDICT_DETAIL_FULL);
        break;
    case SEARCH_PHASE_CERTIFY:
        // Clopper-Pearson holds for independent samples only.
        ask(search, &current(search)->box, settings->certificate_samples, SAMPLING_METHOD_UNIFORM,
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

// Makes chosen samples of the step again and adds them to a cloud.
static void remake(struct search *search, const uint32_t *chosen, uint32_t count,
                   const struct verdict *verdicts, struct cloud *cloud)
{
    sampling_pick(&search->request.sampling, &search->requested, chosen, count, search->chunk,
                  SEARCH_CHUNK);
    cloud_reserve(cloud, count);
    for (uint32_t v = 0; v < cloud->variables; v++)
        memcpy(cloud->values + (size_t)v * cloud->capacity + cloud->count,
               search->chunk + (size_t)search->variables[v] * SEARCH_CHUNK,
               count * sizeof *cloud->values);
    // How badly a certificate's samples violate is known only when the box is to be explained, and
    // no box may depend on that.
    const bool known = search->phase != SEARCH_PHASE_CERTIFY;
    for (uint32_t i = 0; i < count; i++)
        cloud->violation[cloud->count + i] = known ? verdicts[chosen[i]].violation : 1;
    cloud->count += count;
}

// Makes those samples of the step again that are good, or bad, until there are `most`; returns how
// many of the step had to be looked at.
static uint32_t remake_first(struct search *search, const struct verdict *verdicts, bool good,
                             uint32_t most, struct cloud *cloud)
{
    const uint32_t samples = search->request.sampling.samples;
    uint32_t chosen[SEARCH_CHUNK];
    uint32_t count = 0;
    uint32_t at = 0;
    cloud_clear(cloud);
    for (; at < samples && cloud->count + count < most; at++) {
        if ((verdicts[at].violation == VERDICT_GOOD) != good)
            continue;
        chosen[count++] = at;
        if (count == SEARCH_CHUNK) {
            remake(search, chosen, count, verdicts, cloud);
            count = 0;
        }
    }
    if (count > 0)
        remake(search, chosen, count, verdicts, cloud);
    return at;
}

// Makes the samples of the step again that tell something, good and bad. In a step of many samples
// the first ones are as good a choice as any: each is drawn from the same box.
static void recall(struct search *search, const struct verdict *verdicts)
{
    search->good_count = verdict_good_count(verdicts, search->request.sampling.samples);
    if (search->phase == SEARCH_PHASE_EXPLAIN)
        return; // it makes its own again
    remake_first(search, verdicts, true, SEARCH_GOOD_KEPT, &search->good);
    // Where nothing is good yet, the least violating sample is sought among all.
    const uint32_t most = search->good_count > 0 ? SEARCH_BAD_KEPT : UINT32_MAX;
    search->looked_at = remake_first(search, verdicts, false, most, &search->bad);
}

// Keeps the bad samples for good, as far as there is room.
static void remember(struct search *search)
{
    const struct box *sampled =
        search->phase == SEARCH_PHASE_SEEK ? &search->seek.box : &current(search)->sampled;
    const uint32_t most = SEARCH_ARCHIVE / search->space.count;
    survey_add(&search->survey, sampled, search->looked_at, &search->bad,
               most > SEARCH_ARCHIVE_BAD ? most : SEARCH_ARCHIVE_BAD);
}

static void count_verdicts(struct search *search, const struct verdict *verdicts)
{
    const uint32_t samples = search->request.sampling.samples;
    search->evaluations += samples;
    if (search->request.detail != VERDICT_DETAIL_FULL)
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

// ---- what is left to spend

// How many steps of `samples` the budget has room for beside a certificate and an explanation.
static uint64_t steps_affordable(const struct search *search, uint32_t samples)
{
    const struct scenario_search *settings = &search->scenario->search;
    if (settings->evaluations == 0)
        return UINT64_MAX;
    const uint64_t spoken_for =
        search->evaluations + settings->certificate_samples + explain_reserve(search->scenario);
    return spoken_for < settings->evaluations ? (settings->evaluations - spoken_for) / samples : 0;
}

// Shares what is left between exploration and consolidation as the scenario does.
static void plan_steps(struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    const uint64_t wanted = (uint64_t)settings->exploration_steps + settings->consolidation_steps;
    const uint64_t affordable = steps_affordable(search, settings->samples);
    search->exploration_steps = settings->exploration_steps;
    search->consolidation_steps = settings->consolidation_steps;
    if (affordable >= wanted)
        return;
    search->exploration_steps = (uint32_t)(affordable * settings->exploration_steps / wanted);
    search->consolidation_steps = (uint32_t)affordable - search->exploration_steps;
}

// How many boxes are to grow. Where something was given to begin with, no others are sought unless
// asked for. Each needs two steps at least.
static uint32_t starts_wanted(const struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    const bool given =
        settings->start != NULL || settings->start_box.count > 0 || settings->reference != NULL;
    const uint32_t most = search->exploration_steps / 2 > 1 ? search->exploration_steps / 2 : 1;
    uint32_t count = settings->starts;
    if (count == 0)
        count = given ? 1 : tournament_starts(search->exploration_steps);
    return settings->starts > 0 && count > most ? most : count;
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

// There is a box, and it is final: what is left to do is to say what holds it.
static void finish_box(struct search *search, enum search_status status)
{
    finish(search, status);
    if (search->scenario->search.explain_samples == 0)
        return;
    widen(search, standing(search), &search->result);
    explain_init(&search->explain, search->scenario, &search->result);
    search->explain_samples =
        explain_samples(&search->scenario->search, search->explain.step_count, search->evaluations);
    if (search->explain_samples == 0)
        return;
    search->phase = SEARCH_PHASE_EXPLAIN;
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
    if (has_volume(&current(search)->box, &search->space))
        search->phase = SEARCH_PHASE_CERTIFY;
    else
        finish(search, SEARCH_STATUS_NO_GOOD_DESIGN);
}

static double bad_share_wanted(const struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    const int64_t most = certificate_bad_max(&search->certificate, settings->certificate_samples,
                                             settings->target_purity);
    // With (sqrt(m + 1) - 0.82)^2 bad samples expected, more than m come in 5 % of cases; where m
    // is large the box's own uncertainty counts for more.
    const double root = most >= 0 ? sqrt((double)most + 1) - 0.82 : 0;
    const double sure = root * root / settings->certificate_samples;
    double share = search_share_wanted * (double)most / settings->certificate_samples;
    share = share < sure ? share : sure;
    // A certificate that allows no bad sample says little about what it would take.
    if (most <= 0)
        share = (1 - settings->target_purity) / 4;
    if (search->consolidation_steps < settings->consolidation_steps)
        share *= search_share_short + (1 - search_share_short) * search->consolidation_steps /
                                          settings->consolidation_steps;
    // Each miss shows that the box comes out worse than it was meant to.
    for (uint32_t look = 0; look < search->certificate.looks; look++)
        share *= 0.9;
    return share;
}

// The tournament is over before it starts: `box` has won.
static void award(struct search *search, const struct box *box)
{
    search->tournament.demands = &search->demands;
    tournament_award(&search->tournament, &search->space, box);
}

static void start_consolidate(struct search *search, uint32_t steps, double bad_from)
{
    search->phase = SEARCH_PHASE_CONSOLIDATE;
    stagnation_reset(&search->stagnation);
    consolidate_start(&search->consolidate, current(search), steps, bad_from,
                      bad_share_wanted(search));
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
    box_init(&cut, search->space.count);
    trim(&search->space, NULL, &search->seek.good, &search->survey.bad, &options, &cut);
    tournament_fini(&search->tournament);
    award(search, &cut);
    box_fini(&cut);
}

static void end_explore(struct search *search)
{
    if (!has_volume(&current(search)->box, &search->space))
        cut_from_space(search);
    start_consolidate(search, search->consolidation_steps, search_explore_bad);
}

// Lines up what was given, then what was found.
static void start_explore(struct search *search)
{
    plan_steps(search);
    uint32_t count = starts_wanted(search);
    struct cloud starts;
    cloud_init(&starts, search->space.count);
    const bool begun = search->begin.count > 0;
    if (begun) {
        cloud_add(&starts, search->begin.lower, 1, 0);
        count--;
    }
    seek_starts(&search->seek, count, &starts);
    search->tournament.demands = &search->demands;
    tournament_start(&search->tournament, &search->space, &starts, search->exploration_steps);
    if (begun)
        explore_begin(&search->tournament.explores[0], &search->begin);
    cloud_fini(&starts);
    search->phase = SEARCH_PHASE_EXPLORE;
    if (search->exploration_steps == 0)
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
    award(search, &search->space);
    start_certify(search);
}

// No good design: what remains to be said is which design violates least.
static void give_up(struct search *search)
{
    const struct cloud *elite = &search->seek.elite;
    for (uint32_t v = 0; v < search->space.count; v++)
        search->seek.box.lower[v] = search->seek.box.upper[v] = cloud_column(elite, v)[0];
    finish(search, SEARCH_STATUS_NO_GOOD_DESIGN);
}

// Has nothing more to look for: explores what there is.
static void end_seek(struct search *search)
{
    if (search->begin.count > 0 || search->seek.good.count > 0)
        start_explore(search);
    else
        give_up(search);
}

static void keep_as_begin(struct search *search, const struct box *box)
{
    if (search->begin.count == 0)
        box_init(&search->begin, search->space.count);
    box_assign(&search->begin, box);
}

// Puts the free variables of a design, or of a box's bounds, into the box that is looked at next.
static void look_at(struct search *search, const double *lower, const double *upper)
{
    for (uint32_t v = 0; v < search->space.count; v++) {
        search->seek.box.lower[v] = lower[search->variables[v]];
        search->seek.box.upper[v] = upper[search->variables[v]];
    }
}

// Goes on with the next thing given that is to be looked at, or with the whole design space.
static void look_on(struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    if (search->given == GIVEN_REFERENCE) {
        if (settings->reference != NULL) {
            look_at(search, settings->reference, settings->reference);
            return;
        }
        search->given = GIVEN_START;
    }
    if (search->given == GIVEN_START) {
        if (settings->start != NULL) {
            look_at(search, settings->start, settings->start);
            return;
        }
        if (settings->start_box.count > 0) {
            look_at(search, settings->start_box.lower, settings->start_box.upper);
            return;
        }
        search->given = GIVEN_NONE;
    }
    box_assign(&search->seek.box, &search->space);
}

// No good box contains a bad reference, whatever the share of good designs about it: a design that
// must stay inside is one that must be good.
static void refuse_reference(struct search *search)
{
    finish(search, SEARCH_STATUS_NO_GOOD_DESIGN);
}

static void complete_given(struct search *search)
{
    const bool any_good = search->good_count > 0;
    if (search->given == GIVEN_REFERENCE && !any_good) {
        refuse_reference(search);
        return;
    }
    if (any_good)
        keep_as_begin(search, &search->seek.box);
    seek_note(&search->seek, &search->good, &search->bad, search->request.sampling.samples);
    search->given = search->given == GIVEN_REFERENCE ? GIVEN_START : GIVEN_NONE;
    look_on(search);
    const bool enough = search->begin.count > 0 && starts_wanted(search) == 1;
    if (search->given == GIVEN_NONE &&
        (enough || steps_affordable(search, search->scenario->search.samples) == 0))
        end_seek(search);
}

static void complete_seek(struct search *search)
{
    if (search->given != GIVEN_NONE) {
        complete_given(search);
        return;
    }
    const bool whole = box_equal(&search->seek.box, &search->space);
    seek_complete(&search->seek, &search->good, &search->bad, search->request.sampling.samples);
    // With something to begin with, others are welcome but not needed.
    const bool begun = search->begin.count > 0 && search->seek.round >= SEEK_WHOLE_ROUNDS;
    if (whole && all_good(search))
        take_whole_space(search);
    else if (search->seek.state != SEEK_LOOKING || begun ||
             steps_affordable(search, search->scenario->search.samples) == 0)
        end_seek(search);
}

// What the finished step showed.
static struct explore_step shown(const struct search *search)
{
    return (struct explore_step){
        .good = &search->good,
        .bad = &search->bad,
        .samples = search->request.sampling.samples,
        .good_count = search->good_count,
        .threads = search->threads,
    };
}

static bool stagnates(struct search *search)
{
    const struct box *box = &current(search)->box;
    return stagnation_note(&search->stagnation,
                           demands_volume(&search->demands, box, &search->space));
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

static void complete_certify(struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    struct certificate *certificate = &search->certificate;
    const double bad_before = bad_share_wanted(search);
    certificate_look(certificate, search->request.sampling.samples,
                     search->request.sampling.samples - search->good_count);
    if (certificate->lower95 >= settings->target_purity) {
        finish_box(search, SEARCH_STATUS_DONE);
        return;
    }
    const bool hopeless = certificate->looks == CERTIFICATE_LOOKS ||
                          certificate_bad_max(certificate, settings->certificate_samples,
                                              settings->target_purity) < 0;
    if (hopeless) {
        finish_box(search, SEARCH_STATUS_PURITY_MISSED);
        return;
    }
    search->samples = search->samples > UINT32_MAX / 2 ? search->samples : 2 * search->samples;
    const uint64_t affordable = steps_affordable(search, search->samples);
    uint32_t steps = settings->consolidation_steps / 4;
    steps = steps > 0 ? steps : 1;
    steps = steps < affordable ? steps : (uint32_t)affordable;
    if (steps == 0)
        finish_box(search, SEARCH_STATUS_PURITY_MISSED);
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
        .log_volume = box_log_volume(&search->result, &search->frame),
    };
}

void search_complete(struct search *search, const struct verdict *verdicts)
{
    assert(search->phase != SEARCH_PHASE_DONE);
    const enum search_phase phase = search->phase;
    const double growth = phase == SEARCH_PHASE_EXPLORE ? current(search)->rate : 0;
    count_verdicts(search, verdicts);
    recall(search, verdicts);
    if (phase != SEARCH_PHASE_EXPLAIN)
        remember(search);
    search->step++;
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
    widen(search, standing(search), &search->result);
    note_step(search, phase, growth);
    ask_next(search);
}

// ---- making and asking

// The design space, narrowed to the bounds that are held.
static void hold_bounds(const struct scenario *scenario, struct box *held)
{
    const struct scenario_hold *hold = &scenario->search.hold;
    box_assign(held, &scenario->design_space);
    for (uint32_t v = 0; v < held->count; v++) {
        if (hold->lower != NULL && !isnan(hold->lower[v]))
            held->lower[v] = hold->lower[v];
        if (hold->upper != NULL && !isnan(hold->upper[v]))
            held->upper[v] = hold->upper[v];
    }
}

static void find_free_variables(struct search *search)
{
    const struct scenario *scenario = search->scenario;
    const uint32_t all = scenario->design_space.count;
    struct box held;
    box_init(&held, all);
    hold_bounds(scenario, &held);
    box_init(&search->frame, all);
    box_assign(&search->frame, &scenario->design_space);
    box_init(&search->space, box_free_count(&held));
    search->variables = g_new(uint32_t, all + 1);
    uint32_t count = 0;
    for (uint32_t v = 0; v < all; v++) {
        if (!(held.upper[v] > held.lower[v])) {
            search->frame.lower[v] = search->frame.upper[v] = held.lower[v];
            continue;
        }
        search->space.lower[count] = held.lower[v];
        search->space.upper[count] = held.upper[v];
        search->variables[count++] = v;
    }
    box_fini(&held);
}

struct search *search_create(const struct scenario *scenario, uint64_t seed, int threads)
{
    assert(threads > 0);
    struct search *search = g_new0(struct search, 1);
    search->scenario = scenario;
    search->seed = seed;
    search->threads = threads;
    find_free_variables(search);
    const uint32_t all = scenario->design_space.count;
    box_init(&search->requested, all);
    box_init(&search->result, all);
    box_assign(&search->result, &search->frame);
    demands_init(&search->demands, &scenario->search, search->variables, &search->space);
    cloud_init(&search->good, search->space.count);
    cloud_init(&search->bad, search->space.count);
    survey_init(&search->survey, &search->space);
    search->chunk = g_new(double, (size_t)all *SEARCH_CHUNK);
    search->samples = scenario->search.samples;
    plan_steps(search);
    stagnation_init(&search->stagnation, scenario->search.stagnation);
    seek_init(&search->seek, &search->space, SEARCH_SEEK_CHOICE * starts_wanted(search));
    look_on(search);
    consolidate_init(&search->consolidate, &search->space);
    search->phase = SEARCH_PHASE_SEEK;
    ask_next(search);
    return search;
}

void search_free(struct search *search)
{
    if (search == NULL)
        return;
    tournament_fini(&search->tournament);
    consolidate_fini(&search->consolidate);
    demands_fini(&search->demands);
    explain_fini(&search->explain);
    stagnation_fini(&search->stagnation);
    seek_fini(&search->seek);
    cloud_fini(&search->good);
    cloud_fini(&search->bad);
    survey_fini(&search->survey);
    box_fini(&search->space);
    box_fini(&search->frame);
    box_fini(&search->begin);
    box_fini(&search->requested);
    box_fini(&search->result);
    g_free(search->variables);
    g_free(search->chunk);
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

// Steps still to come if everything goes as it should.
static uint32_t steps_left(const struct search *search)
{
    uint32_t left = 0;
    // It is not known before it begins which bounds lie on the edge of the design space.
    if (search->scenario->search.explain_samples > 0 && search->phase < SEARCH_PHASE_EXPLAIN)
        left += explain_steps_most(search->scenario);
    switch (search->phase) {
    case SEARCH_PHASE_SEEK:
        left += 1 + search->exploration_steps + search->consolidation_steps + 1;
        break;
    case SEARCH_PHASE_EXPLORE:
        left +=
            search->exploration_steps - search->tournament.steps + search->consolidation_steps + 1;
        break;
    case SEARCH_PHASE_CONSOLIDATE:
        left += search->consolidate.step_count - search->consolidate.steps + 1;
        break;
    case SEARCH_PHASE_CERTIFY:
        left += 1;
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
        .log_volume = box_log_volume(&search->result, &search->frame),
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
    return digest_end(&state);
}

void search_result(const struct search *search, struct search_result *result)
{
    const struct certificate *certificate = &search->certificate;
    *result = (struct search_result){
        .status = search->status,
        .box = &search->result,
        .log_volume = box_log_volume(&search->result, &search->frame),
        .evaluations = search->evaluations,
        .non_finite = search->non_finite + search->non_finite_beside,
        .steps = search->step,
        .blocking_constraint = blocking_constraint(search),
        .digest = result_digest(search),
    };
    result->purity.samples = certificate->samples;
    result->purity.bad = certificate->bad;
    result->purity.lower95 = certificate->lower95;
    if (certificate->samples > 0)
        result->purity.estimate =
            (double)(certificate->samples - certificate->bad) / (double)certificate->samples;
}
