#include "coordinator/search/demands.h"

#include "common/numeric/rounding.h"

#include <assert.h>
#include <glib.h>
#include <math.h>

static double *pick(const double *values, const uint32_t *variables, uint32_t count)
{
    if (values == NULL)
        return NULL;
    double *picked = g_new(double, count + 1);
    for (uint32_t v = 0; v < count; v++)
        picked[v] = values[variables[v]];
    return picked;
}

static bool *pick_held(const struct scenario_hold *hold, const uint32_t *variables, uint32_t count)
{
    if (hold->lower == NULL && hold->upper == NULL)
        return NULL;
    bool *held = g_new0(bool, 2 * (size_t)count + 1);
    for (uint32_t v = 0; v < count; v++) {
        held[2 * v] = hold->lower != NULL && !isnan(hold->lower[variables[v]]);
        held[2 * v + 1] = hold->upper != NULL && !isnan(hold->upper[variables[v]]);
    }
    return held;
}

// Variables that share have the same design space and held bounds: all of them are free, or none.
static uint32_t *pick_tie(const uint32_t *tie, const uint32_t *variables, uint32_t count)
{
    if (tie == NULL)
        return NULL;
    uint32_t *picked = g_new(uint32_t, count + 1);
    for (uint32_t v = 0; v < count; v++) {
        picked[v] = v;
        while (variables[picked[v]] != tie[variables[v]]) {
            assert(picked[v] > 0);
            picked[v]--;
        }
    }
    return picked;
}

// What variables have in common, or cover together, becomes the interval of each.
static void share(const uint32_t *tie, struct box *box, bool common)
{
    for (uint32_t v = 0; v < box->count; v++) {
        const uint32_t first = tie[v];
        const bool in =
            common ? box->lower[v] > box->lower[first] : box->lower[v] < box->lower[first];
        const bool out =
            common ? box->upper[v] < box->upper[first] : box->upper[v] > box->upper[first];
        box->lower[first] = in ? box->lower[v] : box->lower[first];
        box->upper[first] = out ? box->upper[v] : box->upper[first];
    }
}

static void share_mean(const uint32_t *tie, struct box *box)
{
    for (uint32_t first = 0; first < box->count; first++) {
        double lower = 0;
        double upper = 0;
        uint32_t count = 0;
        for (uint32_t v = first; v < box->count; v++) {
            if (tie[v] != first)
                continue;
            // Differences: of equal bounds the mean is that very bound.
            lower += box->lower[v] - box->lower[first];
            upper += box->upper[v] - box->upper[first];
            count++;
        }
        if (count > 1) {
            box->lower[first] += lower / count;
            box->upper[first] += upper / count;
        }
    }
}

static void copy_to_followers(const uint32_t *tie, struct box *box)
{
    for (uint32_t v = 0; v < box->count; v++) {
        box->lower[v] = box->lower[tie[v]];
        box->upper[v] = box->upper[tie[v]];
    }
}

void demands_init(struct demands *demands, const struct scenario_search *settings,
                  const uint32_t *variables, const struct box *space)
{
    const uint32_t count = space->count;
    *demands = (struct demands){
        .space = space,
        .held = pick_held(&settings->hold, variables, count),
        .reference = pick(settings->reference, variables, count),
        .minimum_widths = pick(settings->minimum_widths, variables, count),
        .weights = pick(settings->weights, variables, count),
        .tie = pick_tie(settings->tie, variables, count),
    };
    demands->any = demands->held != NULL || demands->reference != NULL ||
                   demands->minimum_widths != NULL || demands->tie != NULL;
    box_init(&demands->around, count);
    if (demands->reference == NULL)
        return;
    for (uint32_t v = 0; v < count; v++)
        demands->around.lower[v] = demands->around.upper[v] = demands->reference[v];
    if (demands->tie != NULL) {
        share(demands->tie, &demands->around, false);
        copy_to_followers(demands->tie, &demands->around);
    }
}

void demands_fini(struct demands *demands)
{
    g_free(demands->held);
    g_free(demands->reference);
    g_free(demands->minimum_widths);
    g_free(demands->weights);
    g_free(demands->tie);
    box_fini(&demands->around);
    *demands = (struct demands){0};
}

// Widens an interval about its middle, away from a bound that is held or that of the space.
static void widen_to(const struct demands *demands, struct box *box, uint32_t v)
{
    const double width = demands->minimum_widths[v];
    const double lack = width - (box->upper[v] - box->lower[v]);
    if (!(lack > 0))
        return;
    const double least = demands->space->lower[v];
    const double most = demands->space->upper[v];
    double lower = box->lower[v] - lack / 2;
    lower = lower > least ? lower : least;
    if (lower + width > most || (demands->held != NULL && demands->held[2 * v + 1]))
        lower = most - width > least ? most - width : least;
    if (demands->held != NULL && demands->held[2 * v])
        lower = least;
    double upper = lower + width;
    // Rounding may leave it a hair too narrow.
    while (upper - lower < width)
        upper = nextafter(upper, INFINITY);
    box->lower[v] = lower;
    box->upper[v] = upper < most ? upper : most;
}

static void meet_alone(const struct demands *demands, struct box *box, uint32_t v)
{
    const struct box *space = demands->space;
    if (demands->held != NULL && demands->held[2 * v])
        box->lower[v] = space->lower[v];
    if (demands->held != NULL && demands->held[2 * v + 1])
        box->upper[v] = space->upper[v];
    if (demands->reference != NULL) {
        const double least = demands->around.lower[v];
        const double most = demands->around.upper[v];
        box->lower[v] = box->lower[v] < least ? box->lower[v] : least;
        box->upper[v] = box->upper[v] > most ? box->upper[v] : most;
    }
    if (demands->minimum_widths != NULL)
        widen_to(demands, box, v);
}

static bool has_common(const struct box *box)
{
    for (uint32_t v = 0; v < box->count; v++) {
        if (!(box->lower[v] < box->upper[v]))
            return false;
    }
    return true;
}

static bool meet_tie(const struct demands *demands, struct box *box, enum demands_tie tie)
{
    if (tie == DEMANDS_TIE_MEAN) {
        share_mean(demands->tie, box);
        copy_to_followers(demands->tie, box);
        return true;
    }
    struct box shared;
    box_init(&shared, box->count);
    box_assign(&shared, box);
    share(demands->tie, &shared, tie == DEMANDS_TIE_INSIDE);
    copy_to_followers(demands->tie, &shared);
    const bool met = tie == DEMANDS_TIE_AROUND || has_common(&shared);
    if (met)
        box_assign(box, &shared);
    box_fini(&shared);
    return met;
}

bool demands_meet(const struct demands *demands, struct box *box, enum demands_tie tie)
{
    if (demands == NULL || !demands->any)
        return true;
    if (demands->tie != NULL && !meet_tie(demands, box, tie))
        return false;
    for (uint32_t v = 0; v < box->count; v++)
        meet_alone(demands, box, v);
    return true;
}

// Whether a part of an interval is as good as the interval to those who ask.
static bool may_shrink_to(const struct demands *demands, uint32_t v, double lower, double upper)
{
    return (demands->reference == NULL ||
            (lower <= demands->around.lower[v] && upper >= demands->around.upper[v])) &&
           (demands->minimum_widths == NULL || upper - lower >= demands->minimum_widths[v]);
}

void demands_round(const struct demands *demands, double step, struct box *box)
{
    for (uint32_t v = 0; v < box->count; v++) {
        double lower = box->lower[v], upper = box->upper[v];
        if (!rounding_inwards(step, &lower, &upper))
            continue;
        lower = demands->held != NULL && demands->held[2 * v] ? box->lower[v] : lower;
        upper = demands->held != NULL && demands->held[2 * v + 1] ? box->upper[v] : upper;
        if (!may_shrink_to(demands, v, lower, upper))
            continue;
        box->lower[v] = lower;
        box->upper[v] = upper;
    }
}

struct volume demands_volume(const struct demands *demands, const struct box *box,
                             const struct box *space)
{
    if (demands == NULL || demands->weights == NULL)
        return volume_of(box, space);
    return volume_weighted(box, space, demands->weights);
}
