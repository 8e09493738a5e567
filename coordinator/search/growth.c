#include "coordinator/search/growth.h"

#include <assert.h>

static const double growth_rate_first = 5; // of a fiftieth of the design space: a fifth in all
static const double growth_rate_max = 1.0;
static const double growth_rate_calm = 0.3;
static const double growth_rate_min = 1e-4;
static const double growth_width_least = 0.02; // of the design space
static const double growth_share_least = 0.4;  // of good samples

void growth_init(struct growth *growth)
{
    growth->rate = growth_rate_first;
}

void growth_apply(const struct growth *growth, const struct box *box, const struct box *space,
                  struct box *grown)
{
    assert(box->count == space->count);
    for (uint32_t v = 0; v < box->count; v++) {
        const double least = growth_width_least * (space->upper[v] - space->lower[v]);
        const double width = box->upper[v] - box->lower[v];
        const double step = growth->rate * (width > least ? width : least);
        const double lower = box->lower[v] - step;
        const double upper = box->upper[v] + step;
        grown->lower[v] = lower > space->lower[v] ? lower : space->lower[v];
        grown->upper[v] = upper < space->upper[v] ? upper : space->upper[v];
    }
}

bool growth_too_much(double good_share)
{
    return good_share < growth_share_least;
}

void growth_steer(struct growth *growth, double good_share)
{
    // The further from the wanted share, the larger the correction.
    double factor = 1;
    if (growth_too_much(good_share))
        factor = 0.5;
    else if (good_share < 0.6)
        factor = 0.65;
    else if (good_share < 0.7)
        factor = 0.85;
    else if (good_share > 0.9)
        factor = 1.5;
    else if (good_share > 0.8)
        factor = 1.2;
    growth->rate *= factor;
    if (factor > 1 && growth->rate > growth_rate_max)
        growth->rate = growth_rate_max;
    if (growth->rate < growth_rate_min)
        growth->rate = growth_rate_min;
}

void growth_calm(struct growth *growth)
{
    if (growth->rate > growth_rate_calm)
        growth->rate = growth_rate_calm;
}

bool growth_exhausted(const struct growth *growth)
{
    return growth->rate <= growth_rate_min;
}
