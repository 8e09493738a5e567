#include "coordinator/search/cutting_set.h"

#include "common/sampling/sampling.h"
#include "coordinator/search/widest.h"

#include <glib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    CUTTING_SET_CUTS = 600,  // limits kept
    CUTTING_SET_USED = 120,  // of them in one widest box: the tightest
    CUTTING_SET_AGE = 10,    // steps after which a limit has to be tight to be kept
    CUTTING_SET_STILL = 6,   // steps without a gain after which nothing more is expected
    CUTTING_SET_REVIVED = 4, // tight limits a step whose attacks are looked at again, the oldest
};

static const double cutting_set_start_width = 0.05; // of the design space
static const double cutting_set_reach = 0.5;        // at the start, and the greatest
static const double cutting_set_reach_least = 0.01;
static const double cutting_set_reach_better = 1.15;
static const double cutting_set_reach_worse = 0.8;
static const double cutting_set_tolerance = 0.05; // at the start
static const double cutting_set_tolerance_fall = 0.92;
static const double cutting_set_tolerance_refine = 0.8; // when what is left is to be exact
static const double cutting_set_trifle = 1e-4;          // of log-volume, that is no gain
static const double cutting_set_tolerance_least = 3e-4;
static const double cutting_set_tight = 0.05; // slack of a limit that is kept
static const double cutting_set_price = 20;   // the least
static const double cutting_set_price_most = 1e4;
static const double cutting_set_price_factor = 3;      // over what a limit is worth
static const double cutting_set_mend_tolerance = 1e-3; // after a first bad design, and
static const double cutting_set_mend_rise = 1.5;       // times that after each other one
static const double cutting_set_relax_reach = 0.1;
static const double cutting_set_mend_reach = 0.05;
static const double cutting_set_held = 0.02;  // of what a side's place is worth: less is no hold
static const double cutting_set_touch = 1e-3; // of its width from an edge: a side is put on it

struct cut {
    uint64_t name;   // of the attack
    double constant; // margin = constant + slopes . sides
    double *slopes;  // (sides)
    double slack;    // at the centre
    uint8_t *levels; // (variables) of the attack
    uint32_t step;   // when it was measured
    uint8_t target;
};

// ---- boxes

static double *interval(double *sides, uint32_t v)
{
    return sides + 2 * (size_t)v;
}

// A box in units of the design space, as a box of all variables.
static void lay_out(const struct cutting_set *set, const double *sides, struct box *box)
{
    const struct box *space = &set->frame->space;
    struct box free;
    box_init(&free, space->count);
    for (uint32_t v = 0; v < space->count; v++) {
        const double width = space->upper[v] - space->lower[v];
        const double lower = sides[2 * v], upper = sides[2 * v + 1];
        free.lower[v] = lower <= 0 ? space->lower[v] : space->lower[v] + lower * width;
        free.upper[v] = upper >= 1 ? space->upper[v] : space->lower[v] + upper * width;
    }
    frame_widen(set->frame, &free, box);
    box_fini(&free);
}

void cutting_set_centre(const struct cutting_set *set, struct box *box)
{
    const struct box *space = &set->frame->space;
    struct box all;
    box_init(&all, set->frame->all.count);
    // What stands is the trial as well, which units may have changed in the last digit.
    if (set->standing)
        box_assign(&all, &set->box);
    else
        lay_out(set, set->centre, &all);
    for (uint32_t v = 0; v < space->count; v++) {
        box->lower[v] = all.lower[set->frame->variables[v]];
        box->upper[v] = all.upper[set->frame->variables[v]];
    }
    box_fini(&all);
}

static double log_volume(const struct cutting_set *set, const double *sides)
{
    double sum = 0;
    for (uint32_t v = 0; v < set->sides / 2; v++) {
        const double weight = set->demands->weights == NULL ? 1 : set->demands->weights[v];
        sum += weight * log(sides[2 * v + 1] - sides[2 * v]);
    }
    return sum;
}

void cutting_set_around(const struct box *space, const double *design, struct box *box)
{
    for (uint32_t v = 0; v < space->count; v++) {
        const double width = cutting_set_start_width * (space->upper[v] - space->lower[v]);
        double lower = design[v] - width / 2;
        lower = lower > space->upper[v] - width ? space->upper[v] - width : lower;
        box->lower[v] = lower < space->lower[v] ? space->lower[v] : lower;
        box->upper[v] = box->lower[v] + width;
    }
}

void cutting_set_init(struct cutting_set *set, const struct frame *frame,
                      const struct demands *demands, const struct curve_map *curves,
                      uint32_t constraints, uint32_t samples, uint64_t seed,
                      const struct box *start)
{
    *set = (struct cutting_set){
        .frame = frame,
        .demands = demands,
        .sides = 2 * frame->space.count,
        .reach = cutting_set_reach,
        .tolerance = cutting_set_tolerance,
        .least = cutting_set_tolerance_least,
        .fall = cutting_set_tolerance_fall,
        .price = cutting_set_price,
        .centre_margin = -INFINITY,
    };
    set->centre = g_new0(double, set->sides + 1);
    set->trial = g_new(double, set->sides + 1);
    set->kept = g_new0(double, set->sides + 1);
    set->cuts = g_new0(struct cut, CUTTING_SET_CUTS);
    box_init(&set->box, frame->all.count);
    for (uint32_t v = 0; v < frame->space.count; v++) {
        const double width = frame->space.upper[v] - frame->space.lower[v];
        interval(set->centre, v)[0] = (start->lower[v] - frame->space.lower[v]) / width;
        interval(set->centre, v)[1] = (start->upper[v] - frame->space.lower[v]) / width;
    }
    memcpy(set->trial, set->centre, set->sides * sizeof *set->trial);
    frame_widen(frame, start, &set->box); // to the bit, whatever units do to it
    adversary_init(&set->adversary, frame, curves, constraints, samples, seed);
    adversary_begin(&set->adversary);
}

void cutting_set_fini(struct cutting_set *set)
{
    for (uint32_t i = 0; set->cuts != NULL && i < CUTTING_SET_CUTS; i++) {
        g_free(set->cuts[i].slopes);
        g_free(set->cuts[i].levels);
    }
    g_free(set->cuts);
    g_free(set->centre);
    g_free(set->kept);
    g_free(set->trial);
    box_fini(&set->box);
    adversary_fini(&set->adversary);
    *set = (struct cutting_set){0};
}

const struct box *cutting_set_box(const struct cutting_set *set)
{
    return &set->box;
}

// ---- limits

static double at_box(const struct cut *cut, const double *sides, uint32_t count)
{
    double margin = cut->constant;
    for (uint32_t i = 0; i < count; i++)
        margin += cut->slopes[i] * sides[i];
    return margin;
}

// The limit of that name, or room for it: a new one, else that with the most slack.
static struct cut *room_for(struct cutting_set *set, uint64_t name)
{
    struct cut *loosest = &set->cuts[0];
    for (uint32_t i = 0; i < set->cut_count; i++) {
        struct cut *cut = &set->cuts[i];
        if (cut->name == name)
            return cut;
        if (cut->slack > loosest->slack)
            loosest = cut;
    }
    return set->cut_count < CUTTING_SET_CUTS ? &set->cuts[set->cut_count++] : loosest;
}

// Forgets the limit of that name, if there is one.
static void drop(struct cutting_set *set, uint64_t name)
{
    for (uint32_t i = 0; i < set->cut_count; i++) {
        if (set->cuts[i].name != name)
            continue;
        const struct cut dropped = set->cuts[i];
        set->cuts[i] = set->cuts[--set->cut_count];
        set->cuts[set->cut_count] = dropped; // whose memory is used again
        return;
    }
}

// What an attack says of boxes near the trial.
static void cut_by(void *context, const struct attack_view *view)
{
    struct cutting_set *set = context;
    const struct attack *attack = view->attack;
    if (view->former != attack->name || !view->limits)
        drop(set, view->former);
    if (!view->limits)
        return;
    struct cut *cut = room_for(set, attack->name);
    if (cut->slopes == NULL) {
        cut->slopes = g_new(double, set->sides + 1);
        cut->levels = g_new(uint8_t, set->sides / 2 + 1);
    }
    memcpy(cut->levels, attack->levels, set->sides / 2);
    cut->name = attack->name;
    cut->target = attack->target;
    cut->step = set->step;
    cut->constant = attack->margin;
    cut->slack = attack->margin;
    for (uint32_t v = 0; v < set->sides / 2; v++) {
        const double *sides = interval(set->trial, v);
        const double width = sides[1] - sides[0];
        const double part = (double)attack->levels[v] / MOVES_LEVEL_MAX;
        const double slope = view->slopes[v] * MOVES_LEVEL_MAX / width;
        cut->slopes[2 * v] = slope * (1 - part);
        cut->slopes[2 * v + 1] = slope * part;
        cut->constant -= cut->slopes[2 * v] * sides[0] + cut->slopes[2 * v + 1] * sides[1];
    }
}

// Forgets limits that are old and do not hold the centre.
static void forget(struct cutting_set *set)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < set->cut_count; i++) {
        struct cut cut = set->cuts[i];
        cut.slack = at_box(&cut, set->centre, set->sides);
        if (set->step - cut.step > CUTTING_SET_AGE && cut.slack > cutting_set_tight) {
            set->cuts[i].name = 0;
            continue;
        }
        const struct cut other = set->cuts[kept];
        set->cuts[kept++] = cut;
        if (kept - 1 != i)
            set->cuts[i] = other;
    }
    set->cut_count = kept;
}

// Looks again at attacks whose limits hold the centre though they were measured long ago, in
// another box: a limit is linear, the margin is not, and what holds without need would hold for
// good.
static void revive(struct cutting_set *set)
{
    for (uint32_t i = 0; i < CUTTING_SET_REVIVED; i++) {
        struct cut *oldest = NULL;
        for (uint32_t k = 0; k < set->cut_count; k++) {
            struct cut *cut = &set->cuts[k];
            if (cut->slack < cutting_set_tight && cut->step + 1 < set->step &&
                (oldest == NULL || cut->step < oldest->step ||
                 (cut->step == oldest->step && cut->slack < oldest->slack)))
                oldest = cut;
        }
        if (oldest == NULL)
            return;
        oldest->step = set->step; // it is not revived twice
        adversary_add(&set->adversary, oldest->levels, oldest->target, oldest->slack);
    }
}

// ---- trial and centre

// The least margin of the centre: as measured, or as limits found since then have it.
static double centre_margin(const struct cutting_set *set)
{
    double least = set->centre_margin;
    for (uint32_t i = 0; i < set->cut_count; i++) {
        const double margin = at_box(&set->cuts[i], set->centre, set->sides);
        least = margin < least ? margin : least;
    }
    return least;
}

static double merit(const struct cutting_set *set, double volume, double margin)
{
    const double lack = set->tolerance - margin;
    return volume - (lack > 0 ? set->price * lack : 0);
}

double cutting_set_merit(const struct cutting_set *set)
{
    return merit(set, log_volume(set, set->centre), centre_margin(set));
}

// Where the sides of the next trial may be.
static void ranges(const struct cutting_set *set, double *least, double *most)
{
    const struct box *space = &set->frame->space;
    for (uint32_t v = 0; v < set->sides / 2; v++) {
        const double *sides = interval(set->centre, v);
        const double reach = set->reach * (sides[1] - sides[0]);
        for (uint32_t k = 0; k < 2; k++) {
            least[2 * v + k] = sides[k] - reach > 0 ? sides[k] - reach : 0;
            most[2 * v + k] = sides[k] + reach < 1 ? sides[k] + reach : 1;
        }
        if (set->demands->held != NULL && set->demands->held[2 * v])
            least[2 * v] = most[2 * v] = 0;
        if (set->demands->held != NULL && set->demands->held[2 * v + 1])
            least[2 * v + 1] = most[2 * v + 1] = 1;
        if (set->demands->reference == NULL)
            continue;
        const double width = space->upper[v] - space->lower[v];
        const double low = (set->demands->around.lower[v] - space->lower[v]) / width;
        const double high = (set->demands->around.upper[v] - space->lower[v]) / width;
        most[2 * v] = low < most[2 * v] ? low : most[2 * v];
        least[2 * v] = least[2 * v] > most[2 * v] ? most[2 * v] : least[2 * v];
        least[2 * v + 1] = high > least[2 * v + 1] ? high : least[2 * v + 1];
        most[2 * v + 1] = most[2 * v + 1] < least[2 * v + 1] ? least[2 * v + 1] : most[2 * v + 1];
    }
}

static int compare_cuts(const void *a, const void *b)
{
    const struct cut *one = *(const struct cut *const *)a, *other = *(const struct cut *const *)b;
    if (one->slack != other->slack)
        return one->slack < other->slack ? -1 : 1;
    return one->name < other->name ? -1 : one->name > other->name;
}

// Puts sides that all but touch the design space's edge on it.
static void touch_edges(const struct cutting_set *set, double *sides)
{
    for (uint32_t v = 0; v < set->sides / 2; v++) {
        const double near = cutting_set_touch * (sides[2 * v + 1] - sides[2 * v]);
        if (sides[2 * v] < near)
            sides[2 * v] = 0;
        if (sides[2 * v + 1] > 1 - near)
            sides[2 * v + 1] = 1;
    }
}

// The tightest limits, at most CUTTING_SET_USED; returns how many.
static uint32_t tightest(const struct cutting_set *set, const struct cut **used)
{
    const struct cut *all[CUTTING_SET_CUTS];
    for (uint32_t i = 0; i < set->cut_count; i++)
        all[i] = &set->cuts[i];
    qsort(all, set->cut_count, sizeof *all, compare_cuts);
    const uint32_t count = set->cut_count < CUTTING_SET_USED ? set->cut_count : CUTTING_SET_USED;
    memcpy(used, all, count * sizeof *used);
    return count;
}

// The widest box near the centre under some limits.
static void widen(const struct cutting_set *set, const struct cut *const *used, uint32_t count,
                  double tolerance, struct widest_answer *answer)
{
    g_autofree double *least = g_new(double, set->sides + 1);
    g_autofree double *most = g_new(double, set->sides + 1);
    const double *limit[CUTTING_SET_USED];
    double constant[CUTTING_SET_USED];
    ranges(set, least, most);
    for (uint32_t i = 0; i < count; i++) {
        limit[i] = used[i]->slopes;
        constant[i] = used[i]->constant;
    }
    memcpy(answer->sides, set->centre, set->sides * sizeof *answer->sides);
    widest(&(struct widest_problem){.variables = set->sides / 2,
                                    .weights = set->demands->weights,
                                    .least = least,
                                    .most = most,
                                    .limit_count = count,
                                    .limit = limit,
                                    .constant = constant,
                                    .tolerance = tolerance,
                                    .price = set->price},
           answer);
}

static void make_trial(struct cutting_set *set)
{
    const struct cut *used[CUTTING_SET_USED];
    const uint32_t count = tightest(set, used);
    struct widest_answer answer = {.sides = set->trial};
    widen(set, used, count, set->tolerance, &answer);
    set->shadow = answer.shadow;
    const double price = cutting_set_price_factor * answer.shadow;
    set->price = price > 0.9 * set->price ? price : 0.9 * set->price;
    set->price = fmin(fmax(set->price, cutting_set_price), cutting_set_price_most);
    touch_edges(set, set->trial);
    lay_out(set, set->trial, &set->box);
}

void cutting_set_complete(struct cutting_set *set, const struct sampling *sampling,
                          const struct verdict *verdicts, struct adversary_report *report)
{
    adversary_complete(&set->adversary, sampling, &set->box, verdicts, cut_by, set, report);
    if (set->standing) {
        set->centre_margin = fmin(set->centre_margin, report->margin);
        set->centre_clean = set->centre_clean && report->bad == 0;
        set->step++;
        return;
    }
    const double of_trial = merit(set, log_volume(set, set->trial), report->margin);
    const bool first = set->step == 0;
    const double gain = first ? INFINITY : of_trial - cutting_set_merit(set);
    const bool at_least = set->tolerance <= set->least;
    set->still = at_least && !(gain > cutting_set_trifle) ? set->still + 1 : 0;
    if (gain > 0) {
        memcpy(set->centre, set->trial, set->sides * sizeof *set->centre);
        set->centre_margin = report->margin;
        set->centre_clean = report->bad == 0;
        set->reach *= cutting_set_reach_better;
        set->reach = set->reach < cutting_set_reach ? set->reach : cutting_set_reach;
    } else {
        set->reach *= cutting_set_reach_worse;
        set->reach = set->reach > cutting_set_reach_least ? set->reach : cutting_set_reach_least;
    }
    set->tolerance *= set->fall;
    if (set->tolerance < set->least)
        set->tolerance = set->least;
    set->step++;
    forget(set);
    revive(set);
    make_trial(set);
}

void cutting_set_refine(struct cutting_set *set)
{
    set->fall = cutting_set_tolerance_refine;
    set->refined = true;
}

void cutting_set_relax(struct cutting_set *set, double amount)
{
    set->least = set->tolerance = cutting_set_tolerance_least - amount;
    set->still = 0;
    set->standing = false;
    set->reach = fmax(set->reach, cutting_set_relax_reach);
    make_trial(set);
}

void cutting_set_keep(struct cutting_set *set)
{
    const bool first = set->kept[1] == 0; // no box ends there
    if (first || log_volume(set, set->centre) > log_volume(set, set->kept))
        memcpy(set->kept, set->centre, set->sides * sizeof *set->kept);
}

void cutting_set_take_back(struct cutting_set *set)
{
    memcpy(set->centre, set->kept, set->sides * sizeof *set->centre);
}

bool cutting_set_resting(const struct cutting_set *set)
{
    return set->still >= CUTTING_SET_STILL;
}

void cutting_set_stand(struct cutting_set *set)
{
    set->standing = true;
    set->adversary.scouts = set->adversary.most / 2;
    if (memcmp(set->trial, set->centre, set->sides * sizeof *set->trial) == 0)
        return;
    memcpy(set->trial, set->centre, set->sides * sizeof *set->trial);
    lay_out(set, set->trial, &set->box);
}

void cutting_set_place(struct cutting_set *set, const struct box *box)
{
    const struct box *space = &set->frame->space;
    for (uint32_t v = 0; v < space->count; v++) {
        const double width = space->upper[v] - space->lower[v];
        set->centre[2 * v] = (box->lower[v] - space->lower[v]) / width;
        set->centre[2 * v + 1] = (box->upper[v] - space->lower[v]) / width;
    }
    memcpy(set->trial, set->centre, set->sides * sizeof *set->trial);
    frame_widen(set->frame, box, &set->box);
}

void cutting_set_mend(struct cutting_set *set)
{
    set->standing = false;
    set->adversary.scouts = set->adversary.most / ADVERSARY_SCOUT_SHARE;
    set->tolerance = fmax(cutting_set_mend_tolerance, cutting_set_mend_rise * set->mended);
    set->mended = set->tolerance;
    set->reach = fmax(set->reach, cutting_set_mend_reach);
    make_trial(set);
}

void cutting_set_holders(const struct cutting_set *set, uint8_t *holders, double *worth)
{
    const struct cut *used[CUTTING_SET_USED];
    double prices[CUTTING_SET_USED];
    const uint32_t count = tightest(set, used);
    g_autofree double *sides = g_new(double, set->sides + 1);
    widen(set, used, count, set->tolerance,
          &(struct widest_answer){.sides = sides, .prices = prices});
    for (uint32_t i = 0; i < count; i++)
        worth[used[i]->target] += prices[i];
    for (uint32_t side = 0; side < set->sides; side++) {
        double highest = cutting_set_held / (sides[side | 1] - sides[side & ~1u]);
        holders[side] = CUTTING_SET_NOTHING;
        for (uint32_t i = 0; i < count; i++) {
            // An upper bound is held by what falls as it rises, a lower one by what falls with it.
            const double slope = used[i]->slopes[side];
            const double pull = prices[i] * (side % 2 == 1 ? -slope : slope);
            if (pull > highest) {
                highest = pull;
                holders[side] = used[i]->target;
            }
        }
    }
}
