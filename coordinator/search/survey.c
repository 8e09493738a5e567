#include "coordinator/search/survey.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

void survey_init(struct survey *survey, const struct box *space)
{
    *survey = (struct survey){.space = space};
    cloud_init(&survey->bad, space->count);
}

void survey_fini(struct survey *survey)
{
    cloud_fini(&survey->bad);
    g_free(survey->steps);
    g_free(survey->bounds);
    *survey = (struct survey){0};
}

// Forgets the oldest steps when there is no room for `more` bad samples: a quarter of them at once,
// since what is left has to be moved.
static void forget(struct survey *survey, uint32_t more, uint32_t bad_max)
{
    uint64_t left = (uint64_t)survey->bad.count + more;
    uint32_t drop = 0;
    const uint64_t kept_max = left > bad_max ? bad_max - bad_max / 4 : bad_max;
    while (drop < survey->step_count && left > kept_max)
        left -= survey->steps[drop++].bad;
    if (drop == 0)
        return;
    const size_t variables = survey->space->count;
    const uint32_t kept = survey->step_count - drop;
    memmove(survey->steps, survey->steps + drop, kept * sizeof *survey->steps);
    memmove(survey->bounds, survey->bounds + drop * 2 * variables,
            kept * 2 * variables * sizeof *survey->bounds);
    survey->step_count = kept;
    cloud_keep_newest(&survey->bad, (uint32_t)(left - more));
}

static void add_bad(struct survey *survey, const struct cloud *bad)
{
    struct cloud *all = &survey->bad;
    cloud_reserve(all, bad->count);
    for (uint32_t v = 0; v < bad->variables; v++)
        memcpy(all->values + (size_t)v * all->capacity + all->count, cloud_column(bad, v),
               bad->count * sizeof *all->values);
    memcpy(all->violation + all->count, bad->violation, bad->count * sizeof *all->violation);
    all->count += bad->count;
}

void survey_add(struct survey *survey, const struct box *box, uint32_t samples,
                const struct cloud *bad, uint32_t bad_max)
{
    assert(box->count == survey->space->count && bad->variables == box->count);
    const size_t variables = box->count;
    forget(survey, bad->count, bad_max);
    if (survey->step_count == survey->step_capacity) {
        survey->step_capacity = survey->step_capacity + survey->step_capacity / 2 + 64;
        survey->steps = g_renew(struct survey_step, survey->steps, survey->step_capacity);
        survey->bounds = g_renew(double, survey->bounds, survey->step_capacity * 2 * variables + 1);
    }
    double *bounds = survey->bounds + survey->step_count * 2 * variables;
    memcpy(bounds, box->lower, variables * sizeof *bounds);
    memcpy(bounds + variables, box->upper, variables * sizeof *bounds);
    survey->steps[survey->step_count++] = (struct survey_step){
        .volume = volume_of(box, survey->space), .samples = samples, .bad = bad->count};
    if (bad->count > 0)
        add_bad(survey, bad);
}

// How many samples of each step would lie in the region if its box and the region were one.
static double *densities(const struct survey *survey, const struct box *region)
{
    const struct volume whole = volume_of(region, survey->space);
    double *density = g_new(double, survey->step_count + 1);
    for (uint32_t t = 0; t < survey->step_count; t++) {
        const struct survey_step *step = &survey->steps[t];
        // A box without volume looked at one design: it tells of no other.
        density[t] = 0;
        if (step->volume.mantissa > 0) {
            const int64_t shift = whole.exponent - step->volume.exponent;
            density[t] = step->samples * ldexp(whole.mantissa / step->volume.mantissa,
                                               (int)CLAMP(shift, -1000, 1000));
        }
    }
    return density;
}

// Whether a point (point[v * stride]) lies within bounds.
static bool within(const double *bounds, uint32_t variables, const double *point, size_t stride)
{
    for (uint32_t v = 0; v < variables; v++) {
        const double value = point[v * stride];
        if (value < bounds[v] || value > bounds[variables + v])
            return false;
    }
    return true;
}

double *survey_inside(const struct survey *survey, const struct box *region, struct cloud *inside)
{
    const uint32_t first = inside->count;
    const uint32_t variables = region->count;
    cloud_add_inside(inside, &survey->bad, region);
    double *density = densities(survey, region);
    double *mass = g_new(double, inside->count - first + 1);
    for (uint32_t i = first; i < inside->count; i++) {
        double sum = 0;
        for (uint32_t t = 0; t < survey->step_count; t++) {
            if (density[t] > 0 && within(survey->bounds + (size_t)t * 2 * variables, variables,
                                         inside->values + i, inside->capacity))
                sum += density[t];
        }
        mass[i - first] = sum > 0 ? 1 / sum : 0;
    }
    g_free(density);
    return mass;
}

double survey_share(const struct survey *survey, const struct box *box)
{
    struct cloud inside;
    cloud_init(&inside, box->count);
    double *mass = survey_inside(survey, box, &inside);
    double share = 0;
    for (uint32_t i = 0; i < inside.count; i++)
        share += mass[i];
    g_free(mass);
    cloud_fini(&inside);
    return share;
}
