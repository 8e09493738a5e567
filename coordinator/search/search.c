#include "coordinator/search/search.h"

#include "coordinator/search/certificate.h"
#include "coordinator/search/explore.h"
#include "coordinator/search/seek.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

enum {
    SEARCH_STARTS = 4,        // boxes that are grown at first, one from each start
    SEARCH_START_STEPS = 25,  // of exploration for each start beyond the first
    SEARCH_CHUNK = 1024,      // samples made at once when a step is gone through
    SEARCH_GOOD_KEPT = 512,   // good samples of a step that the trim may anchor on
    SEARCH_ARCHIVE = 1 << 23, // numbers of bad samples that are remembered: 64 MB
    SEARCH_TRIAL_STEPS = 5,   // that a box cut out of the known bad samples is put to
    SEARCH_GROW_STEPS = 5,    // of each box between two decisions of the tournament
};

// The good share that exploration aims at, as a bad share.
static const double search_explore_bad = 0.3;

// How fast sides move against each other while exploring. The gain falls to a ninth of this while
// consolidating: first the box must follow the shape of the good region, then the noise must
// average out.
static const double search_gain = 0.16;
static const double search_gain_fall = 8;

// How fast the volume follows the good share: in exploration it has far to go; in consolidation the
// few bad samples of a step are noise, and the gain falls to a fifth.
static const double search_explore_volume_gain = 1.2;
static const double search_volume_gain = 0.2;
static const double search_volume_gain_fall = 4;

// The consolidation reaches its final share after the first of these parts of its steps; from the
// second on, when the box has followed, its boxes are averaged.
static const double search_settle_after = 0.7;
static const double search_average_after = 0.8;

// The bad share to consolidate to, as a part of what the next certificate allows: so far below it
// that the certificate passes with near certainty, and not further.
static const double search_share_wanted = 0.5;

struct search {
    const struct scenario *scenario; // borrowed
    uint32_t index;
    uint64_t seed;
    int threads;

    // The free variables, in which everything below is expressed.
    uint32_t *variables; // (space.count) index among all variables
    struct box space;

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
    struct seek seek;
    uint64_t blocked[256]; // bad samples of the seek by worst constraint

    // Explore: a tournament. Each box left grows for a number of steps, then the better half goes
    // on, until one is left.
    struct explore explores[SEARCH_STARTS];
    uint32_t left[SEARCH_STARTS]; // indexes of the boxes that are in the tournament
    uint32_t left_count;
    uint32_t turn;       // place in `left` of the box whose step it is
    uint32_t turn_steps; // steps it has left in this round
    uint32_t explore_steps;
    uint32_t growing_steps; // of all boxes together; then those that have grown are balanced

    // Consolidate.
    uint32_t consolidate_steps; // of this consolidation, finished
    uint32_t consolidate_count; // of this consolidation, in all
    double bad_from;            // bad share it starts from
    double bad_to;              // and ends at
    struct box explored;        // what exploration ended with: about 70 % good
    struct box average;         // of the boxes since it settled
    uint32_t average_count;     // of those boxes
    uint32_t trial_steps;       // left of the trial of a box without known bad samples
    uint64_t trial_bad;         // bad samples in it so far
    struct box balanced;        // to go back to when it fails
    uint32_t samples;           // a step

    struct certificate certificate;

    // The samples of the step that is being completed.
    struct cloud good;
    struct cloud bad;
    struct cloud archive; // bad samples of all steps since exploration began, the newest
    uint32_t good_count;
    double *chunk; // (all variables x SEARCH_CHUNK)

    struct box result; // all variables
};

const char *search_phase_name(enum search_phase phase)
{
    static const char *const names[] = {
        [SEARCH_PHASE_SEEK] = "seek",
        [SEARCH_PHASE_EXPLORE] = "explore",
        [SEARCH_PHASE_CONSOLIDATE] = "consolidate",
        [SEARCH_PHASE_CERTIFY] = "certify",
        [SEARCH_PHASE_DONE] = "done",
    };
    return names[phase];
}

const char *search_status_name(enum search_status status)
{
    static const char *const names[] = {
        [SEARCH_STATUS_RUNNING] = "running",
        [SEARCH_STATUS_DONE] = "done",
        [SEARCH_STATUS_PURITY_MISSED] = "purity_missed",
        [SEARCH_STATUS_NO_GOOD_DESIGN] = "no_good_design",
    };
    return names[status];
}

// The box that is being worked on.
static struct explore *current(struct search *search)
{
    return &search->explores[search->left[search->turn]];
}

// The box of the free variables that stands for the search as it is: until there is one, what is
// being sampled; if there will be none, the least violating design alone.
static const struct box *standing(const struct search *search)
{
    return search->left_count == 0 ? &search->seek.box
                                   : &search->explores[search->left[search->turn]].box;
}

// Puts a box of the free variables into one of all variables.
static void widen(const struct search *search, const struct box *box, struct box *all)
{
    box_assign(all, &search->scenario->design_space);
    for (uint32_t v = 0; v < box->count; v++) {
        all->lower[search->variables[v]] = box->lower[v];
        all->upper[search->variables[v]] = box->upper[v];
    }
}

// ---- what to sample next

static void ask(struct search *search, const struct box *box, uint32_t samples,
                enum scenario_sampling method, enum verdict_detail detail)
{
    widen(search, box, &search->requested);
    search->request = (struct search_request){
        .sampling = {.seed = search->seed,
                     .search = search->index,
                     .step = search->step,
                     .samples = samples,
                     .method = method},
        .phase = search->phase,
        .detail = detail,
        .box = &search->requested,
    };
}

static void ask_next(struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    switch (search->phase) {
    case SEARCH_PHASE_SEEK:
        ask(search, &search->seek.box, settings->samples, SCENARIO_SAMPLING_LATIN_HYPERCUBE,
            VERDICT_DETAIL_FULL);
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
        ask(search, &current(search)->box, settings->certificate_samples, SCENARIO_SAMPLING_UNIFORM,
            VERDICT_DETAIL_SHARE);
        break;
    case SEARCH_PHASE_DONE:
        break;
    }
}

// ---- the samples of the finished step

// Adds samples of a chunk, chosen by index, to a cloud.
static void gather(const struct search *search, struct cloud *cloud, const uint32_t *chosen,
                   uint32_t count, const struct verdict *verdicts)
{
    cloud_reserve(cloud, count);
    for (uint32_t v = 0; v < cloud->variables; v++) {
        const double *from = search->chunk + (size_t)search->variables[v] * SEARCH_CHUNK;
        double *column = cloud->values + (size_t)v * cloud->capacity + cloud->count;
        for (uint32_t i = 0; i < count; i++)
            column[i] = from[chosen[i]];
    }
    for (uint32_t i = 0; i < count; i++)
        cloud->violation[cloud->count + i] = verdicts[chosen[i]].violation;
    cloud->count += count;
}

// Makes the samples of the step again and sorts them into good and bad.
static void recall(struct search *search, const struct verdict *verdicts)
{
    const struct sampling *sampling = &search->request.sampling;
    cloud_clear(&search->good);
    cloud_clear(&search->bad);
    search->good_count = verdict_good_count(verdicts, sampling->samples);
    for (uint32_t first = 0; first < sampling->samples; first += SEARCH_CHUNK) {
        uint32_t count = sampling->samples - first;
        count = count < SEARCH_CHUNK ? count : SEARCH_CHUNK;
        sampling_fill(sampling, &search->requested, first, count, search->chunk, SEARCH_CHUNK);
        uint32_t good[SEARCH_CHUNK];
        uint32_t bad[SEARCH_CHUNK];
        uint32_t good_count = 0;
        uint32_t bad_count = 0;
        const uint32_t room = SEARCH_GOOD_KEPT - search->good.count;
        for (uint32_t i = 0; i < count; i++) {
            if (verdicts[first + i].violation != VERDICT_GOOD)
                bad[bad_count++] = i;
            else if (good_count < room)
                good[good_count++] = i;
        }
        gather(search, &search->good, good, good_count, verdicts + first);
        gather(search, &search->bad, bad, bad_count, verdicts + first);
    }
}

// Keeps the bad samples for good, as far as there is room.
static void remember(struct search *search)
{
    for (uint32_t i = 0; i < search->bad.count; i++)
        cloud_add(&search->archive, search->bad.values + i, search->bad.capacity,
                  search->bad.violation[i]);
    const uint32_t variables = search->space.count;
    cloud_keep_newest(&search->archive, SEARCH_ARCHIVE / variables);
}

static void count_verdicts(struct search *search, const struct verdict *verdicts)
{
    const uint32_t samples = search->request.sampling.samples;
    search->evaluations += samples;
    if (search->request.detail != VERDICT_DETAIL_FULL)
        return;
    for (uint32_t i = 0; i < samples; i++) {
        search->non_finite += verdicts[i].violation == VERDICT_NON_FINITE;
        if (search->phase == SEARCH_PHASE_SEEK && verdicts[i].violation != VERDICT_GOOD)
            search->blocked[verdicts[i].constraint]++;
    }
}

// ---- from phase to phase

static void finish(struct search *search, enum search_status status)
{
    search->phase = SEARCH_PHASE_DONE;
    search->status = status;
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
    // Each miss shows that the box comes out worse than it was meant to.
    for (uint32_t look = 0; look < search->certificate.looks; look++)
        share *= 0.9;
    return share;
}

// Trims `grown` by all known bad samples; returns whether the result is larger than `best`, which
// it then replaces.
static bool cut_pure(struct search *search, const struct box *grown, struct box *best)
{
    struct trim_options options = trim_options_default();
    options.anchors = 4;
    options.threads = search->threads;
    struct box pure;
    box_init(&pure, grown->count);
    bool larger =
        trim(grown, &current(search)->box, &search->good, &search->archive, &options, &pure);
    larger =
        larger && volume_above(volume_of(&pure, &search->space), volume_of(best, &search->space));
    if (larger)
        box_assign(best, &pure);
    box_fini(&pure);
    return larger;
}

// Cuts a box without any known bad sample out of what exploration found, and one around the box as
// it stands. If one is larger than that it is put to trial. Where bad designs fill a corner
// to the brim one cut is worth more than sides in balance, and in few dimensions the known bad
// samples say exactly how far a side can go. In many dimensions such a box finds the gaps between
// the samples, which the trial's fresh ones show.
static void start_trial(struct search *search)
{
    static const struct growth little = {.rate = 0.05};
    struct explore *explore = current(search);
    struct box grown;
    struct box best;
    box_init(&grown, search->space.count);
    box_init(&best, search->space.count);
    box_assign(&best, &explore->box);
    growth_apply(&little, &explore->box, &search->space, &grown);
    bool found = cut_pure(search, &grown, &best);
    found = cut_pure(search, &search->explored, &best) || found;
    if (found) {
        box_assign(&search->balanced, &explore->box);
        explore_move(explore, &best);
        search->trial_steps = SEARCH_TRIAL_STEPS;
        search->trial_bad = 0;
    }
    box_fini(&best);
    box_fini(&grown);
}

// Counts a step of the trial and decides after the last one.
static void go_on_with_trial(struct search *search)
{
    const uint32_t samples = search->request.sampling.samples;
    search->trial_bad += samples - search->good_count;
    if (--search->trial_steps > 0)
        return;
    const double expected = search->bad_to * samples * SEARCH_TRIAL_STEPS;
    if (search->trial_bad > expected)
        explore_move(current(search), &search->balanced);
}

static void start_consolidate(struct search *search, uint32_t steps, double bad_from)
{
    search->phase = SEARCH_PHASE_CONSOLIDATE;
    search->consolidate_steps = 0;
    search->trial_steps = 0;
    search->average_count = 0;
    search->consolidate_count = steps;
    search->bad_from = bad_from;
    search->bad_to = bad_share_wanted(search);
    explore_settle(current(search));
    box_assign(&search->explored, &current(search)->box);
    if (steps == 0)
        start_certify(search);
}

// The bad share to aim at in the next step: its inverse fourth root rises evenly, which is nearly
// an even fall on a logarithmic scale and needs only what every machine rounds the same.
static double bad_share_now(const struct search *search)
{
    const double way =
        (search->consolidate_steps + 1) / (search_settle_after * search->consolidate_count);
    if (way >= 1 || search->bad_from <= search->bad_to)
        return search->bad_to;
    const double root = 1 + way * (sqrt(sqrt(search->bad_from / search->bad_to)) - 1);
    return search->bad_from / (root * root * root * root);
}

// The number of steps that each box in the tournament grows until the next decision.
static uint32_t round_steps(const struct search *search)
{
    const uint32_t most = search->scenario->search.exploration_steps;
    const uint32_t fair = most / (4 * search->left_count);
    // The last decision, between two, is taken after they have begun to balance.
    const uint32_t wanted = search->left_count == 2 ? 2 * SEARCH_GROW_STEPS : SEARCH_GROW_STEPS;
    return fair < 1 ? 1 : fair < wanted ? fair : wanted;
}

// More starts where there are steps to spend on them, but never the middle of the good designs
// alone: it may be bad.
static uint32_t start_count(const struct search *search)
{
    const uint32_t count = 1 + search->scenario->search.exploration_steps / SEARCH_START_STEPS;
    return count < 2 ? 2 : count < SEARCH_STARTS ? count : SEARCH_STARTS;
}

static void start_explore(struct search *search)
{
    struct cloud starts;
    cloud_init(&starts, search->space.count);
    seek_starts(&search->seek, start_count(search), &starts);
    search->left_count = starts.count;
    for (uint32_t i = 0; i < starts.count; i++) {
        search->left[i] = i;
        explore_init(&search->explores[i], &search->space, starts.values + i, starts.capacity);
    }
    cloud_fini(&starts);
    search->phase = SEARCH_PHASE_EXPLORE;
    search->turn = 0;
    search->turn_steps = round_steps(search);
    search->growing_steps = search->left_count * search->turn_steps;
}

// Whether the whole design space turned out good when it was last sampled.
static bool all_good(const struct search *search)
{
    return search->good_count == search->request.sampling.samples;
}

// Sampled the whole design space and found it good: there is nothing to search for.
static void take_whole_space(struct search *search)
{
    search->left_count = 1;
    search->left[0] = 0;
    explore_init(&search->explores[0], &search->space, search->space.lower, 1);
    box_assign(&search->explores[0].box, &search->space);
    explore_settle(&search->explores[0]);
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

static void complete_seek(struct search *search)
{
    const bool whole = box_equal(&search->seek.box, &search->space);
    seek_complete(&search->seek, &search->good, &search->bad, search->request.sampling.samples);
    if (whole && all_good(search))
        take_whole_space(search);
    else if (search->seek.state == SEEK_FOUND)
        start_explore(search);
    else if (search->seek.state == SEEK_FAILED)
        give_up(search);
}

// `goal` says where the step leads: bad share and gains.
static void explore_once(struct search *search, struct explore_step goal)
{
    goal.good = &search->good;
    goal.bad = &search->bad;
    goal.samples = search->request.sampling.samples;
    goal.good_count = search->good_count;
    goal.threads = search->threads;
    explore_complete(current(search), &goal);
}

// Keeps the better half of the boxes in the tournament.
static void halve(struct search *search)
{
    for (uint32_t i = 1; i < search->left_count; i++) {
        for (uint32_t j = i; j > 0; j--) {
            uint32_t *one = &search->left[j - 1];
            uint32_t *two = &search->left[j];
            if (!explore_ahead(&search->explores[*two], &search->explores[*one]))
                break;
            const uint32_t swap = *one;
            *one = *two;
            *two = swap;
        }
    }
    search->left_count = (search->left_count + 1) / 2;
}

// Gives the turn to the next box in the tournament; after the last one the better half stays. After
// the first round boxes balance their sides once they have grown: trimming on would only nibble.
static void go_on(struct search *search)
{
    if (search->turn_steps > 1) {
        search->turn_steps--;
    } else if (search->left_count > 1) {
        if (++search->turn == search->left_count) {
            halve(search);
            search->turn = 0;
        }
        search->turn_steps = round_steps(search);
    }
    if (search->explore_steps >= search->growing_steps && current(search)->grown)
        explore_settle(current(search));
}

static void complete_explore(struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    explore_once(search, (struct explore_step){.bad_share = search_explore_bad,
                                               .gain = search_gain,
                                               .volume_gain = search_explore_volume_gain});
    search->explore_steps++;
    if (all_good(search) && explore_whole(current(search))) {
        start_certify(search);
        return;
    }
    go_on(search);
    if (search->explore_steps < settings->exploration_steps)
        return;
    while (search->left_count > 1)
        halve(search);
    search->turn = 0;
    search->samples = settings->samples;
    start_consolidate(search, settings->consolidation_steps, search_explore_bad);
}

static void balance_once(struct search *search)
{
    const double way = (double)search->consolidate_steps / search->consolidate_count;
    explore_once(search,
                 (struct explore_step){
                     .bad_share = bad_share_now(search),
                     .gain = search_gain / (1 + search_gain_fall * way),
                     .volume_gain = search_volume_gain / (1 + search_volume_gain_fall * way),
                 });
}

// Takes the box as it stands into the average (Polyak and Juditsky, 1992: the average of the last
// boxes has less noise than the last one).
static void take_average(struct search *search)
{
    const struct box *box = &current(search)->box;
    struct box *average = &search->average;
    if (search->average_count++ == 0)
        box_assign(average, box);
    for (uint32_t v = 0; v < box->count; v++) {
        average->lower[v] += (box->lower[v] - average->lower[v]) / search->average_count;
        average->upper[v] += (box->upper[v] - average->upper[v]) / search->average_count;
    }
}

// The last steps of a consolidation, in which the box only has to come to rest.
static void settle(struct search *search)
{
    const double way = (double)search->consolidate_steps / search->consolidate_count;
    if (search->trial_steps == 0 && way > search_average_after)
        take_average(search);
    const uint32_t left = search->consolidate_count - search->consolidate_steps;
    if (left == SEARCH_TRIAL_STEPS && search->trial_steps == 0) {
        if (search->average_count > 0)
            explore_move(current(search), &search->average);
        start_trial(search);
    } else if (left == 0) {
        start_certify(search);
    }
}

static void complete_consolidate(struct search *search)
{
    if (search->trial_steps > 0)
        go_on_with_trial(search);
    else
        balance_once(search);
    search->consolidate_steps++;
    const uint32_t count = search->consolidate_count;
    const uint32_t settled = (uint32_t)(search_settle_after * count);
    // The first trial is over before the last one starts, or does not take place.
    if (search->consolidate_steps == settled && count - settled > 2 * SEARCH_TRIAL_STEPS)
        start_trial(search);
    else if (search->consolidate_steps > settled)
        settle(search);
}

static void complete_certify(struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    struct certificate *certificate = &search->certificate;
    const double bad_before = bad_share_wanted(search);
    certificate_look(certificate, search->request.sampling.samples, search->bad.count);
    if (certificate->lower95 >= settings->target_purity) {
        finish(search, SEARCH_STATUS_DONE);
        return;
    }
    const bool hopeless = certificate->looks == CERTIFICATE_LOOKS ||
                          certificate_bad_max(certificate, settings->certificate_samples,
                                              settings->target_purity) < 0;
    if (hopeless) {
        finish(search, SEARCH_STATUS_PURITY_MISSED);
        return;
    }
    search->samples = search->samples > UINT32_MAX / 2 ? search->samples : 2 * search->samples;
    const uint32_t steps = settings->consolidation_steps / 4;
    start_consolidate(search, steps > 0 ? steps : 1, bad_before);
}

static void note_step(struct search *search, enum search_phase phase, double growth)
{
    search->last = (struct search_step){
        .step = search->request.sampling.step,
        .phase = phase,
        .samples = search->request.sampling.samples,
        .good = search->good_count,
        .growth = growth,
        .log_volume = box_log_volume(standing(search), &search->space),
    };
}

void search_complete(struct search *search, const struct verdict *verdicts)
{
    assert(search->phase != SEARCH_PHASE_DONE);
    const enum search_phase phase = search->phase;
    const double growth = phase == SEARCH_PHASE_EXPLORE ? current(search)->rate : 0;
    count_verdicts(search, verdicts);
    recall(search, verdicts);
    if (phase != SEARCH_PHASE_SEEK)
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
    case SEARCH_PHASE_DONE:
        break;
    }
    note_step(search, phase, growth);
    widen(search, standing(search), &search->result);
    ask_next(search);
}

// ---- making and asking

static void find_free_variables(struct search *search)
{
    const struct box *space = &search->scenario->design_space;
    box_init(&search->space, box_free_count(space));
    search->variables = g_new(uint32_t, space->count + 1);
    uint32_t count = 0;
    for (uint32_t v = 0; v < space->count; v++) {
        if (!(space->upper[v] > space->lower[v]))
            continue;
        search->space.lower[count] = space->lower[v];
        search->space.upper[count] = space->upper[v];
        search->variables[count++] = v;
    }
}

struct search *search_create(const struct scenario *scenario, uint32_t index, uint64_t seed,
                             int threads)
{
    assert(threads > 0);
    struct search *search = g_new0(struct search, 1);
    search->scenario = scenario;
    search->index = index;
    search->seed = seed;
    search->threads = threads;
    find_free_variables(search);
    const uint32_t all = scenario->design_space.count;
    box_init(&search->requested, all);
    box_init(&search->result, all);
    box_assign(&search->result, &scenario->design_space);
    cloud_init(&search->good, search->space.count);
    cloud_init(&search->bad, search->space.count);
    cloud_init(&search->archive, search->space.count);
    box_init(&search->explored, search->space.count);
    box_init(&search->balanced, search->space.count);
    box_init(&search->average, search->space.count);
    search->chunk = g_new(double, (size_t)all *SEARCH_CHUNK);
    search->samples = scenario->search.samples;
    seek_init(&search->seek, &search->space, SEARCH_STARTS);
    search->phase = SEARCH_PHASE_SEEK;
    ask_next(search);
    return search;
}

void search_free(struct search *search)
{
    if (search == NULL)
        return;
    for (uint32_t i = 0; i < SEARCH_STARTS; i++)
        explore_fini(&search->explores[i]);
    seek_fini(&search->seek);
    cloud_fini(&search->good);
    cloud_fini(&search->bad);
    cloud_fini(&search->archive);
    box_fini(&search->explored);
    box_fini(&search->balanced);
    box_fini(&search->average);
    box_fini(&search->space);
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
    const struct scenario_search *settings = &search->scenario->search;
    uint32_t left = 0;
    switch (search->phase) {
    case SEARCH_PHASE_SEEK:
        left += 1 + settings->exploration_steps + settings->consolidation_steps + 1;
        break;
    case SEARCH_PHASE_EXPLORE:
        left +=
            settings->exploration_steps - search->explore_steps + settings->consolidation_steps + 1;
        break;
    case SEARCH_PHASE_CONSOLIDATE:
        left += search->consolidate_count - search->consolidate_steps + 1;
        break;
    case SEARCH_PHASE_CERTIFY:
        left += 1;
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
        .log_volume = box_log_volume(standing(search), &search->space),
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
    digest_u64(&state, search->status);
    digest_u64(&state, search->step);
    digest_u64(&state, search->evaluations);
    digest_u64(&state, search->non_finite);
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
        .log_volume = box_log_volume(&search->result, &search->scenario->design_space),
        .evaluations = search->evaluations,
        .non_finite = search->non_finite,
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
