#include "coordinator/search/explore.h"

#include <assert.h>
#include <math.h>

const double explore_gain = 0.16;

// A grown box with more good samples than this still has far to go.
static const double explore_share_grown = 0.9;

static void prepare(struct explore *explore)
{
    if (explore->balancing) {
        explore->rate = 0;
        box_assign(&explore->sampled, &explore->box);
    } else {
        explore->rate = explore->growth.rate;
        growth_apply(&explore->growth, &explore->box, explore->space, &explore->sampled);
    }
}

void explore_init(struct explore *explore, const struct box *space, const double *start,
                  size_t stride)
{
    *explore = (struct explore){.space = space};
    box_init(&explore->box, space->count);
    box_init(&explore->sampled, space->count);
    for (uint32_t v = 0; v < space->count; v++)
        explore->box.lower[v] = explore->box.upper[v] = start[v * stride];
    growth_init(&explore->growth);
    balance_init(&explore->balance, space->count);
    prepare(explore);
}

void explore_demand(struct explore *explore, const struct demands *demands)
{
    explore->demands = demands;
    demands_meet(demands, &explore->box, DEMANDS_TIE_AROUND);
    prepare(explore);
}

void explore_begin(struct explore *explore, const struct box *box)
{
    box_assign(&explore->box, box);
    demands_meet(explore->demands, &explore->box, DEMANDS_TIE_AROUND);
    if (volume_of(&explore->box, explore->space).mantissa > 0)
        growth_calm(&explore->growth);
    prepare(explore);
}

void explore_fini(struct explore *explore)
{
    box_fini(&explore->box);
    box_fini(&explore->sampled);
    balance_fini(&explore->balance);
    *explore = (struct explore){0};
}

// Trims the sampled box into the box. Without a good sample in it the box stays what it was.
static void cut(struct explore *explore, const struct explore_step *step)
{
    struct trim_options options = trim_options_default();
    options.threads = step->threads;
    options.keep = explore->demands != NULL ? explore->demands->reference : NULL;
    struct box trimmed;
    box_init(&trimmed, explore->box.count);
    if (trim(&explore->sampled, &explore->box, step->good, step->bad, &options, &trimmed) &&
        demands_meet(explore->demands, &trimmed, DEMANDS_TIE_INSIDE))
        box_assign(&explore->box, &trimmed);
    box_fini(&trimmed);
}

static void remember_yield(struct explore *explore, double share)
{
    struct volume yield = demands_volume(explore->demands, &explore->sampled, explore->space);
    int shift;
    yield.mantissa = frexp(yield.mantissa * share, &shift);
    yield.exponent += shift;
    explore->yield[explore->steps % EXPLORE_MEMORY] = yield;
}

void explore_complete(struct explore *explore, const struct explore_step *step)
{
    const double share = (double)step->good_count / step->samples;
    remember_yield(explore, share);
    explore->steps++;
    const bool few = growth_too_much(share);
    // What is demanded may leave a box no room to be trimmed: only pushed to and fro.
    const bool bound = explore->demands != NULL && explore->demands->any;
    if (explore->balancing && (!few || bound)) {
        const struct balance_step balancing = {
            .samples = step->samples,
            .bad = step->bad,
            .bad_count = step->samples - step->good_count,
            .bad_share = step->bad_share,
            .gain = step->gain,
            .volume_gain = step->volume_gain,
            .volume_eager_max = step->volume_eager_max,
            .weights = explore->demands != NULL ? explore->demands->weights : NULL,
            .threads = step->threads};
        balance_move(&explore->balance, &explore->box, explore->space, &balancing);
        demands_meet(explore->demands, &explore->box, DEMANDS_TIE_MEAN);
    } else if (!few || explore->balancing || growth_exhausted(&explore->growth)) {
        cut(explore, step);
        explore->grown = explore->grown || share < explore_share_grown;
    }
    if (!explore->balancing)
        growth_steer(&explore->growth, share);
    if (volume_of(&explore->box, explore->space).mantissa > 0) {
        growth_calm(&explore->growth);
        explore->grown = explore->grown || (few && bound);
    }
    prepare(explore);
}

void explore_settle(struct explore *explore)
{
    explore->balancing = true;
    prepare(explore);
}

void explore_move(struct explore *explore, const struct box *box)
{
    box_assign(&explore->box, box);
    demands_meet(explore->demands, &explore->box, DEMANDS_TIE_MEAN);
    prepare(explore);
}

bool explore_whole(const struct explore *explore)
{
    return box_equal(&explore->box, explore->space);
}

// Product of the yields of the last `count` steps.
static struct volume recent_yield(const struct explore *explore, uint32_t count)
{
    struct volume product = {.mantissa = 0.5, .exponent = 1};
    for (uint32_t back = 1; back <= count; back++) {
        const struct volume *yield = &explore->yield[(explore->steps - back) % EXPLORE_MEMORY];
        int shift;
        product.mantissa = frexp(product.mantissa * yield->mantissa, &shift);
        product.exponent += yield->exponent + shift;
    }
    return product;
}

bool explore_ahead(const struct explore *a, const struct explore *b)
{
    uint32_t count = a->steps < b->steps ? a->steps : b->steps;
    count = count < EXPLORE_MEMORY ? count : EXPLORE_MEMORY;
    // A step that found nothing good makes the product zero, which says little when both have one.
    for (; count > 0; count--) {
        const struct volume yields[2] = {recent_yield(a, count), recent_yield(b, count)};
        if (volume_above(yields[0], yields[1]))
            return true;
        if (volume_above(yields[1], yields[0]))
            return false;
    }
    return false;
}
