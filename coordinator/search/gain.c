#include "coordinator/search/gain.h"

#include <glib.h>
#include <math.h>

const double gain_relaxation = 0.01;

// Where the first of the two boxes that are compared ends: at this bad sample, or earlier where
// there are few, so that the second one is likely to end among them too.
enum { GAIN_FIRST_EVENT = 8, GAIN_FIRST_PART = 4 };

// So many bad samples of the box tell how many designs relaxing makes good, or half of all there
// are.
enum { GAIN_INSIDE_SAMPLES = 20 };

// A slab thinner than this, in widths of the corridor, says too little: the design space ends.
static const double gain_thickness_least = 0.05;

// Beyond the slabs their outer half goes on as it is, but no further than so many times as wide.
static const double gain_reach = 3;

// The bounds that are moved, and how far the samples reach.
struct pool {
    bool *in;           // (2 x variables)
    uint32_t variables; // of which at least one bound is in
    double reach;       // [widths of the corridor] of the samples
};

// A bad sample comes in when a corridor is widened by `at` widths.
struct event {
    double at;
    double mass;    // of bad designs that come in with it, as a share of the box
    bool made_good; // by relaxing
};

static uint64_t worst(const struct explain *explain, uint32_t bound, uint32_t constraint)
{
    return explain->worst[(size_t)bound * (SCENARIO_CONSTRAINT_MAX + 1) + constraint];
}

static double thickness(const struct explain *explain, uint32_t index)
{
    const struct explain_bound *bound = &explain->bounds[index];
    const uint32_t v = bound->variable;
    return (bound->to - bound->from) / (explain->box.upper[v] - explain->box.lower[v]);
}

static uint64_t bad_of(const struct explain *explain, uint32_t bound)
{
    uint64_t sum = 0;
    for (uint32_t c = 0; c < explain->scenario->constraint_count; c++)
        sum += worst(explain, bound, c);
    return sum;
}

// Whether a bound is held by the constraint, and, if wanted, not notably by another.
static bool holds(const struct explain *explain, uint32_t index, uint32_t constraint, bool alone)
{
    if (explain->bounds[index].drawn == 0 || thickness(explain, index) < gain_thickness_least)
        return false;
    const uint64_t own = worst(explain, index, constraint);
    const uint64_t all = bad_of(explain, index);
    return own > 0 && (!alone || all - own <= 1 + all / 4);
}

static uint32_t bounds_in(const struct pool *pool, uint32_t variable)
{
    return (uint32_t)pool->in[2 * variable] + pool->in[2 * variable + 1];
}

static void fill_pool(const struct explain *explain, uint32_t constraint, bool alone,
                      struct pool *pool)
{
    pool->variables = 0;
    pool->reach = INFINITY;
    for (uint32_t i = 0; i < 2 * explain->box.count; i++)
        pool->in[i] = holds(explain, i, constraint, alone);
    for (uint32_t i = 0; i < 2 * explain->box.count; i++) {
        if (pool->in[i])
            pool->reach = fmin(pool->reach, bounds_in(pool, i / 2) * thickness(explain, i));
    }
    for (uint32_t v = 0; v < explain->box.count; v++)
        pool->variables += bounds_in(pool, v) > 0;
}

static int by_place(const void *a, const void *b)
{
    const struct event *one = a;
    const struct event *two = b;
    return (one->at > two->at) - (one->at < two->at);
}

// The bad samples outside the bounds that are moved, in the order in which they come in.
static GArray *events_of(const struct explain *explain, uint32_t constraint,
                         const struct pool *pool)
{
    GArray *events = g_array_new(FALSE, FALSE, sizeof(struct event));
    for (uint64_t i = 0; i < explain->bad_count; i++) {
        const struct explain_bad *bad = &explain->bad[i];
        if (!pool->in[bad->bound])
            continue;
        const double part = thickness(explain, bad->bound) / explain->bounds[bad->bound].drawn;
        const struct event event = {
            .at = bounds_in(pool, bad->bound / 2) * (double)bad->distance,
            .mass = part / pool->variables,
            .made_good = bad->constraint == constraint && bad->violation <= gain_relaxation,
        };
        if (event.at <= pool->reach)
            g_array_append_val(events, event);
    }
    g_array_sort(events, by_place);
    return events;
}

// How far a corridor can be widened until the bad share is `share`: `bad` is the share in the box
// itself. Returns whether the samples say so; if not, `widened` is as far as they reach.
static bool widen(const GArray *events, bool relaxed, double reach, double bad, double share,
                  double *widened)
{
    double mass = 0;
    double outer = 0; // in the outer half
    for (guint i = 0; i < events->len; i++) {
        const struct event *event = &g_array_index(events, struct event, i);
        if (relaxed && event->made_good)
            continue;
        mass += event->mass;
        if (event->at > reach / 2)
            outer += event->mass;
        *widened = event->at;
        if (bad + mass > share * (1 + event->at))
            return true;
    }
    const double rate = outer / (reach / 2) - share;
    *widened = reach;
    if (rate <= 0)
        return false;
    *widened = reach + (share * (1 + reach) - bad - mass) / rate;
    if (*widened <= gain_reach * reach)
        return true;
    *widened = gain_reach * reach;
    return false;
}

static int by_size(const void *a, const void *b)
{
    const float one = *(const float *)a;
    const float two = *(const float *)b;
    return (one > two) - (one < two);
}

// The share of the box's designs that relaxing makes good. Where fewer samples than
// GAIN_INSIDE_SAMPLES say so, the density of violations among the least ones says it with less
// noise.
static double freed_inside(const struct explain *explain, uint32_t constraint)
{
    float *violations = g_new(float, explain->inside_bad + 1);
    uint64_t count = 0;
    for (uint64_t i = 0; i < explain->inside_bad; i++) {
        if (explain->inside[i].constraint == constraint)
            violations[count++] = explain->inside[i].violation;
    }
    qsort(violations, count, sizeof *violations, by_size);
    uint64_t near = 0;
    while (near < count && violations[near] <= gain_relaxation)
        near++;
    double freed = (double)near;
    const uint64_t few = MIN(GAIN_INSIDE_SAMPLES, (count + 1) / 2);
    if (near < few && isfinite(violations[few - 1]))
        freed = gain_relaxation / violations[few - 1] * (double)few;
    g_free(violations);
    return freed / (double)explain->inside_samples;
}

// Compares two boxes of the same bad share, without relaxing and with it.
static void compare(const struct explain *explain, uint32_t constraint, const struct pool *pool,
                    struct explain_gain *gain)
{
    GArray *events = events_of(explain, constraint, pool);
    if (events->len > 0) {
        const guint place = MIN(GAIN_FIRST_EVENT, events->len / GAIN_FIRST_PART + 1) - 1;
        const struct event *first = &g_array_index(events, struct event, place);
        double mass = 0;
        for (guint i = 0; i < place; i++)
            mass += g_array_index(events, struct event, i).mass;
        const double bad = (double)explain->inside_bad / (double)explain->inside_samples;
        const double freed = freed_inside(explain, constraint);
        const double share = (bad + mass) / (1 + first->at);
        double widened;
        gain->at_least = !widen(events, true, pool->reach, bad - freed, share, &widened);
        gain->log_volume = fmax(0, log((1 + widened) / (1 + first->at)));
    }
    g_array_unref(events);
}

struct explain_gain gain_of(const struct explain *explain, uint32_t constraint)
{
    const uint32_t sides = 2 * explain->box.count;
    struct explain_gain gain = {
        .amount = gain_relaxation * explain->scenario->constraints[constraint].scale,
        .log_volume = NAN,
    };
    if (explain->inside_samples == 0 || explain->taken < explain->step_count)
        return gain;
    gain.log_volume = 0;
    struct pool pool = {.in = g_new0(bool, sides + 1)};
    fill_pool(explain, constraint, true, &pool);
    if (pool.variables == 0)
        fill_pool(explain, constraint, false, &pool);
    if (pool.variables > 0)
        compare(explain, constraint, &pool, &gain);
    g_free(pool.in);
    return gain;
}
