#include "coordinator/search/robust.h"

#include <glib.h>

enum {
    ROBUST_ROUNDS = 3,
    ROBUST_REFINED = 3, // sets that are refined, at most
};

static const double robust_share[ROBUST_ROUNDS] = {0.6, 0.2, 0.2}; // of the steps

static void begin_round(struct robust *robust)
{
    const double steps = robust_share[robust->round] * robust->steps / robust->left;
    robust->turns = steps > 1 ? (uint32_t)steps : 1;
    robust->turn = 0;
    robust->current = 0;
}

void robust_init(struct robust *robust, const struct frame *frame, const struct demands *demands,
                 const struct curve_map *curves, uint32_t constraints, uint32_t samples,
                 uint64_t seed, const struct cloud *starts, uint32_t steps)
{
    const uint32_t variables = frame->space.count, count = starts->count + 1;
    // With one start there is nothing to choose from.
    *robust = (struct robust){
        .count = count, .left = count, .steps = steps, .round = count > 1 ? 0 : ROBUST_ROUNDS - 1};
    robust->sets = g_new0(struct cutting_set, count);
    g_autofree double *design = g_new(double, variables + 1);
    struct box box;
    box_init(&box, variables);
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t v = 0; v < variables && i < starts->count; v++)
            design[v] = cloud_column(starts, v)[i];
        if (i < starts->count)
            cutting_set_around(&frame->space, design, &box);
        cutting_set_init(&robust->sets[i], frame, demands, curves, constraints, samples, seed + i,
                         i < starts->count ? &box : &frame->space);
    }
    box_fini(&box);
    begin_round(robust);
}

void robust_init_one(struct robust *robust, const struct frame *frame,
                     const struct demands *demands, const struct curve_map *curves,
                     uint32_t constraints, uint32_t samples, uint64_t seed, const struct box *box)
{
    *robust = (struct robust){.count = 1, .left = 1, .round = ROBUST_ROUNDS - 1};
    robust->sets = g_new0(struct cutting_set, 1);
    cutting_set_init(&robust->sets[0], frame, demands, curves, constraints, samples, seed, box);
}

void robust_fini(struct robust *robust)
{
    for (uint32_t i = 0; i < robust->count; i++)
        cutting_set_fini(&robust->sets[i]);
    g_free(robust->sets);
    *robust = (struct robust){0};
}

struct cutting_set *robust_current(const struct robust *robust)
{
    return &robust->sets[robust->current];
}

// Of the first `count` sets the best first.
static void rank(struct robust *robust, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        const struct cutting_set set = robust->sets[i];
        const double merit = cutting_set_merit(&set);
        uint32_t at = i;
        for (; at > 0 && cutting_set_merit(&robust->sets[at - 1]) < merit; at--)
            robust->sets[at] = robust->sets[at - 1];
        robust->sets[at] = set;
    }
}

// The last one may have come down to where another one stands above it: then that is refined too.
static bool go_on_with_another(struct robust *robust)
{
    if (robust->sets[0].refined || ++robust->refined == ROBUST_REFINED)
        return false;
    begin_round(robust);
    cutting_set_refine(&robust->sets[0]);
    return true;
}

bool robust_complete(struct robust *robust, const struct sampling *sampling,
                     const struct verdict *verdicts)
{
    cutting_set_complete(robust_current(robust), sampling, verdicts, &robust->report);
    const bool last = robust->round + 1 == ROBUST_ROUNDS;
    if (++robust->turn < robust->turns && !(last && cutting_set_resting(robust_current(robust))))
        return false;
    robust->turn = 0;
    if (++robust->current < robust->left)
        return false;
    if (last) {
        rank(robust, robust->count);
        if (go_on_with_another(robust))
            return false;
        robust->current = 0;
        return true;
    }
    rank(robust, robust->left);
    robust->current = 0;
    robust->round++;
    robust->left = robust->round == ROBUST_ROUNDS - 1 ? 1 : (robust->left + 2) / 3;
    begin_round(robust);
    if (robust->left == 1)
        cutting_set_refine(robust_current(robust));
    return false;
}
