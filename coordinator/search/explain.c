#include "coordinator/search/explain.h"

#include "coordinator/search/gain.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

enum { EXPLAIN_CHUNK = 1024 }; // samples made at once when a step is gone through

// A slab's thickness in widths of the corridor: thin enough to be just outside, thick enough for
// bad samples and for what relaxing a constraint by 1 % is worth.
static const double explain_thickness = 0.1;

// A bound so near to the edge of the design space, in parts of the space, lies on it.
static const double explain_edge = 1e-6;

const char *explain_holder_name(enum explain_holder holder)
{
    static const char *const names[] = {
        [EXPLAIN_UNKNOWN] = "unknown",           [EXPLAIN_CONSTRAINT] = "constraint",
        [EXPLAIN_NOTHING] = "nothing",           [EXPLAIN_HELD] = "held",
        [EXPLAIN_DESIGN_SPACE] = "design_space", [EXPLAIN_FIXED] = "fixed",
    };
    return names[holder];
}

// ---- how much to spend

// Of a box that is certified as it is, every bound is looked at: none of them has to stay.
static const struct scenario_hold *held_bounds(const struct scenario *scenario)
{
    static const struct scenario_hold none;
    return scenario_is_box(scenario) ? &none : &scenario->search.hold;
}

static bool is_held(const double *held, uint32_t variable)
{
    return held != NULL && !isnan(held[variable]);
}

uint32_t explain_steps_most(const struct scenario *scenario)
{
    const struct box *space = &scenario->design_space;
    const struct scenario_hold *hold = held_bounds(scenario);
    uint32_t count = 0;
    for (uint32_t v = 0; v < space->count; v++) {
        if (space->lower[v] < space->upper[v])
            count += 2 - is_held(hold->lower, v) - is_held(hold->upper, v);
    }
    return count;
}

uint32_t explain_samples(const struct scenario_search *settings, uint32_t steps, uint64_t spent)
{
    uint64_t samples = settings->explain_samples;
    if (steps == 0)
        return 0;
    if (samples == SCENARIO_EXPLAIN_AUTO) {
        const uint64_t share = spent / EXPLAIN_SHARE / steps;
        samples = CLAMP(share, EXPLAIN_SAMPLES_LEAST, EXPLAIN_SAMPLES);
    }
    if (settings->evaluations == 0)
        return (uint32_t)samples;
    const uint64_t left = settings->evaluations > spent ? settings->evaluations - spent : 0;
    samples = MIN(samples, left / steps);
    return samples < EXPLAIN_BUDGET_LEAST ? 0 : (uint32_t)samples;
}

uint64_t explain_reserve(const struct scenario *scenario)
{
    const struct scenario_search *settings = &scenario->search;
    const uint64_t steps = explain_steps_most(scenario);
    const uint64_t wanted = settings->explain_samples == SCENARIO_EXPLAIN_AUTO
                                ? EXPLAIN_SAMPLES
                                : settings->explain_samples;
    const uint64_t most = settings->evaluations / EXPLAIN_BUDGET_SHARE;
    const uint64_t reserve = MIN(wanted * steps, most);
    return reserve < EXPLAIN_BUDGET_LEAST * steps ? 0 : reserve;
}

// ---- which bounds, and where their slabs lie

// What holds a bound without looking at any sample; EXPLAIN_UNKNOWN: samples will tell.
static enum explain_holder holder_by_itself(const struct explain *explain, uint32_t v, bool upper)
{
    const struct box *space = &explain->scenario->design_space;
    const struct scenario_hold *hold = held_bounds(explain->scenario);
    const double whole = space->upper[v] - space->lower[v];
    if (!(explain->box.lower[v] < explain->box.upper[v]))
        return whole > 0 ? EXPLAIN_HELD : EXPLAIN_FIXED;
    if (is_held(upper ? hold->upper : hold->lower, v))
        return EXPLAIN_HELD;
    const double gap =
        upper ? space->upper[v] - explain->box.upper[v] : explain->box.lower[v] - space->lower[v];
    return gap <= explain_edge * whole ? EXPLAIN_DESIGN_SPACE : EXPLAIN_UNKNOWN;
}

static void place_slab(const struct explain *explain, struct explain_bound *bound)
{
    const struct box *space = &explain->scenario->design_space;
    const uint32_t v = bound->variable;
    const double lower = explain->box.lower[v];
    const double upper = explain->box.upper[v];
    const double thickness = explain_thickness * (upper - lower);
    bound->from = bound->upper ? upper : fmax(lower - thickness, space->lower[v]);
    bound->to = bound->upper ? fmin(upper + thickness, space->upper[v]) : lower;
}

static void look_at_demands(const struct explain *explain, struct explain_bound *bound)
{
    const struct scenario_search *search = &explain->scenario->search;
    const uint32_t v = bound->variable;
    const double lower = explain->box.lower[v];
    const double upper = explain->box.upper[v];
    // Widening a corridor to its least width rounds.
    bound->at_minimum_width = search->minimum_widths != NULL && search->minimum_widths[v] > 0 &&
                              upper - lower <= search->minimum_widths[v] * (1 + 1e-9);
    bound->at_reference =
        search->reference != NULL && search->reference[v] == (bound->upper ? upper : lower);
}

void explain_init(struct explain *explain, const struct scenario *scenario, const struct box *box)
{
    assert(box->count == scenario->design_space.count);
    const uint32_t sides = 2 * box->count;
    const uint32_t constraints = SCENARIO_CONSTRAINT_MAX + 1;
    *explain = (struct explain){.scenario = scenario};
    box_init(&explain->box, box->count);
    box_assign(&explain->box, box);
    box_init(&explain->slab, box->count);
    explain->bounds = g_new0(struct explain_bound, sides);
    explain->steps = g_new(uint32_t, sides);
    explain->worst = g_new0(uint64_t, (size_t)sides * constraints);
    explain->gains = g_new0(struct explain_gain, constraints);
    for (uint32_t i = 0; i < sides; i++) {
        struct explain_bound *bound = &explain->bounds[i];
        bound->variable = i / 2;
        bound->upper = i % 2 == 1;
        bound->holder = holder_by_itself(explain, bound->variable, bound->upper);
        look_at_demands(explain, bound);
        if (bound->holder != EXPLAIN_UNKNOWN)
            continue;
        place_slab(explain, bound);
        explain->steps[explain->step_count++] = i;
    }
}

void explain_fini(struct explain *explain)
{
    box_fini(&explain->box);
    box_fini(&explain->slab);
    g_free(explain->bounds);
    g_free(explain->steps);
    g_free(explain->bad);
    g_free(explain->worst);
    g_free(explain->inside);
    g_free(explain->gains);
    *explain = (struct explain){0};
}

const struct box *explain_slab(struct explain *explain, uint32_t step)
{
    assert(step < explain->step_count);
    const struct explain_bound *bound = &explain->bounds[explain->steps[step]];
    box_assign(&explain->slab, &explain->box);
    explain->slab.lower[bound->variable] = bound->from;
    explain->slab.upper[bound->variable] = bound->to;
    return &explain->slab;
}

// ---- what samples say

static uint64_t *worst_of(const struct explain *explain, uint32_t bound)
{
    return explain->worst + (size_t)bound * (SCENARIO_CONSTRAINT_MAX + 1);
}

static void keep(struct explain *explain, const struct explain_bad *bad)
{
    if (explain->bad_count == explain->bad_room) {
        explain->bad_room = 2 * explain->bad_room + 1024;
        explain->bad = g_renew(struct explain_bad, explain->bad, explain->bad_room);
    }
    explain->bad[explain->bad_count++] = *bad;
}

// Takes the samples first .. first + count - 1, of which the variable's values are given.
static void take_some(struct explain *explain, uint32_t index, const double *values,
                      const struct verdict *verdicts, uint32_t count)
{
    struct explain_bound *bound = &explain->bounds[index];
    const uint32_t v = bound->variable;
    const double edge = bound->upper ? bound->from : bound->to;
    const double width = explain->box.upper[v] - explain->box.lower[v];
    for (uint32_t i = 0; i < count; i++) {
        if (verdicts[i].violation == VERDICT_GOOD) {
            bound->good++;
            continue;
        }
        worst_of(explain, index)[verdicts[i].constraint]++;
        keep(explain,
             &(struct explain_bad){.bound = index,
                                   .distance = (float)(fabs(values[i] - edge) / width),
                                   .violation = (float)verdict_relative(verdicts[i].violation),
                                   .constraint = verdicts[i].constraint});
    }
}

static bool verdicts_fit(const struct explain *explain, const struct verdict *verdicts,
                         uint32_t samples)
{
    for (uint32_t i = 0; i < samples; i++) {
        if (verdicts[i].violation != VERDICT_GOOD &&
            verdicts[i].constraint >= explain->scenario->constraint_count)
            return false;
    }
    return true;
}

bool explain_take(struct explain *explain, const struct sampling *sampling, const struct box *box,
                  const struct verdict *verdicts)
{
    if (explain->taken == explain->step_count ||
        !box_equal(explain_slab(explain, explain->taken), box) ||
        !verdicts_fit(explain, verdicts, sampling->samples))
        return false;
    const uint32_t index = explain->steps[explain->taken++];
    struct explain_bound *bound = &explain->bounds[index];
    bound->drawn = sampling->samples;
    bound->samples = sampling->samples;
    double *chunk = g_new(double, (size_t)box->count *EXPLAIN_CHUNK);
    for (uint32_t first = 0; first < sampling->samples; first += EXPLAIN_CHUNK) {
        const uint32_t count = MIN(sampling->samples - first, EXPLAIN_CHUNK);
        sampling_fill(sampling, box, first, count, chunk, EXPLAIN_CHUNK);
        take_some(explain, index, chunk + (size_t)bound->variable * EXPLAIN_CHUNK, verdicts + first,
                  count);
    }
    g_free(chunk);
    return true;
}

void explain_take_inside(struct explain *explain, const struct verdict *verdicts, uint32_t samples)
{
    explain->inside_samples = samples;
    explain->inside_bad = 0;
    explain->inside = g_renew(struct explain_bad, explain->inside,
                              samples - verdict_good_count(verdicts, samples) + 1);
    for (uint32_t i = 0; i < samples; i++) {
        if (verdicts[i].violation != VERDICT_GOOD)
            explain->inside[explain->inside_bad++] =
                (struct explain_bad){.violation = (float)verdict_relative(verdicts[i].violation),
                                     .constraint = verdicts[i].constraint};
    }
}

// ---- what follows from them

// The bounds of a shared corridor are one, and so are the samples outside it.
static void share_samples(struct explain *explain)
{
    const uint32_t *tie = explain->scenario->search.tie;
    if (tie == NULL)
        return;
    for (uint32_t i = 0; i < 2 * explain->box.count; i++) {
        const uint32_t first = 2 * tie[i / 2] + i % 2;
        if (first == i)
            continue;
        explain->bounds[first].samples += explain->bounds[i].samples;
        explain->bounds[first].good += explain->bounds[i].good;
        for (uint32_t c = 0; c <= SCENARIO_CONSTRAINT_MAX; c++)
            worst_of(explain, first)[c] += worst_of(explain, i)[c];
    }
    for (uint32_t i = 0; i < 2 * explain->box.count; i++) {
        const uint32_t first = 2 * tie[i / 2] + i % 2;
        explain->bounds[i].samples = explain->bounds[first].samples;
        explain->bounds[i].good = explain->bounds[first].good;
        memcpy(worst_of(explain, i), worst_of(explain, first),
               (SCENARIO_CONSTRAINT_MAX + 1) * sizeof(uint64_t));
    }
}

// Whether the samples just outside are no worse than those inside.
static bool is_free(const struct explain *explain, const struct explain_bound *bound)
{
    const double bad = (double)(bound->samples - bound->good);
    return bad * (double)explain->inside_samples <=
           (double)explain->inside_bad * (double)bound->samples;
}

static bool reaches_edge(const struct explain *explain, const struct explain_bound *bound)
{
    const struct box *space = &explain->scenario->design_space;
    return bound->upper ? bound->to == space->upper[bound->variable]
                        : bound->from == space->lower[bound->variable];
}

static void find_holder(const struct explain *explain, uint32_t index)
{
    struct explain_bound *bound = &explain->bounds[index];
    if (bound->holder != EXPLAIN_UNKNOWN || bound->drawn == 0)
        return;
    const uint64_t *worst = worst_of(explain, index);
    for (uint32_t c = 0; c < explain->scenario->constraint_count; c++) {
        if (worst[c] > bound->violated) {
            bound->violated = worst[c];
            bound->constraint = c;
        }
    }
    if (bound->violated == 0 || (explain->inside_samples > 0 && is_free(explain, bound)))
        bound->holder = reaches_edge(explain, bound) ? EXPLAIN_DESIGN_SPACE : EXPLAIN_NOTHING;
    else
        bound->holder = EXPLAIN_CONSTRAINT;
}

void explain_take_known(struct explain *explain, const uint8_t *holders, const double *gains)
{
    const uint32_t constraints = explain->scenario->constraint_count;
    for (uint32_t i = 0; i < 2 * explain->box.count; i++) {
        struct explain_bound *bound = &explain->bounds[i];
        if (bound->holder != EXPLAIN_UNKNOWN)
            continue;
        bound->holder = holders[i] < constraints ? EXPLAIN_CONSTRAINT : EXPLAIN_NOTHING;
        bound->constraint = holders[i] < constraints ? holders[i] : 0;
    }
    for (uint32_t c = 0; c < constraints; c++)
        explain->gains[c] = (struct explain_gain){.amount = gain_relaxation *
                                                            explain->scenario->constraints[c].scale,
                                                  .log_volume = gains[c]};
    explain->taken = explain->step_count;
    explain->known = true;
}

void explain_conclude(struct explain *explain)
{
    if (explain->known)
        return;
    for (uint32_t c = 0; c < explain->scenario->constraint_count; c++)
        explain->gains[c] = gain_of(explain, c);
    share_samples(explain);
    for (uint32_t i = 0; i < 2 * explain->box.count; i++)
        find_holder(explain, i);
}
