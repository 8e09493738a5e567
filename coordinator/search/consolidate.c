#include "coordinator/search/consolidate.h"

#include "coordinator/search/fit.h"

#include <math.h>

enum {
    CONSOLIDATE_TRIAL_STEPS = 5,
    CONSOLIDATE_TRIAL_BAD = 16384, // known bad samples, the newest, that a box is cut out of
    CONSOLIDATE_FIT_VARIABLES = 3, // with more of them samples are too few to fit a box to
    CONSOLIDATE_FITS = 6,          // evenly over the steps
};

// By how much of its width a fitted box is drawn out at each side to be sampled, divided by the
// number of variables: to see where else its sides could be.
static const double consolidate_fit_reach = 0.1;

// The wanted share is reached after the first of these parts of the steps; from the second on, when
// the box has followed, its boxes are averaged.
static const double consolidate_settle_after = 0.7;
static const double consolidate_average_after = 0.8;

// The gain of the sides falls to a ninth of that of exploration: first the box must follow the
// shape of the good region, then the noise must average out. The volume's gain falls to a fifth:
// few samples are bad, and their number is noise.
static const double consolidate_gain_fall = 8;
static const double consolidate_volume_gain = 0.2;
static const double consolidate_volume_gain_fall = 4;

// With fewer steps than this the volume must follow in fewer, and does so with more noise.
static const double consolidate_steps_calm = 100;
static const double consolidate_hurry_max = 6;

void consolidate_init(struct consolidate *consolidate, const struct box *space)
{
    *consolidate = (struct consolidate){.space = space};
    box_init(&consolidate->explored, space->count);
    box_init(&consolidate->average, space->count);
    box_init(&consolidate->balanced, space->count);
}

void consolidate_fini(struct consolidate *consolidate)
{
    box_fini(&consolidate->explored);
    box_fini(&consolidate->average);
    box_fini(&consolidate->balanced);
    *consolidate = (struct consolidate){0};
}

void consolidate_start(struct consolidate *consolidate, struct explore *explore,
                       uint32_t step_count, double bad_from, double bad_to)
{
    explore_settle(explore);
    box_assign(&consolidate->explored, &explore->box);
    consolidate->steps = 0;
    consolidate->step_count = step_count;
    consolidate->bad_from = bad_from;
    consolidate->bad_to = bad_to;
    consolidate->average_count = 0;
    consolidate->trial_steps = 0;
}

// The bad share to aim at in the next step: its inverse fourth root rises evenly, which is nearly
// an even fall on a logarithmic scale and needs only what every machine rounds the same.
static double bad_share_now(const struct consolidate *consolidate)
{
    const double from = consolidate->bad_from;
    const double to = consolidate->bad_to;
    const double way =
        (consolidate->steps + 1) / (consolidate_settle_after * consolidate->step_count);
    if (way >= 1 || from <= to)
        return to;
    const double root = 1 + way * (sqrt(sqrt(from / to)) - 1);
    return from / (root * root * root * root);
}

// By how much the volume's gain rises for want of steps. A box that is tried again is nearly there.
static double hurry(const struct consolidate *consolidate)
{
    const bool far = consolidate->bad_from > 4 * consolidate->bad_to;
    const double hurry = consolidate_steps_calm / consolidate->step_count;
    if (!far || hurry < 1)
        return 1;
    return hurry < consolidate_hurry_max ? hurry : consolidate_hurry_max;
}

static void balance_once(const struct consolidate *consolidate, struct explore *explore,
                         struct explore_step *step)
{
    const double way = (double)consolidate->steps / consolidate->step_count;
    step->bad_share = bad_share_now(consolidate);
    step->gain = explore_gain / (1 + consolidate_gain_fall * way);
    step->volume_gain =
        consolidate_volume_gain * hurry(consolidate) / (1 + consolidate_volume_gain_fall * way);
    step->volume_eager_max = 1;
    explore_complete(explore, step);
}

// Trims `grown` by all known bad samples; returns whether the result is larger than `best`, which
// it then replaces.
static bool cut_pure(const struct explore *explore, const struct explore_step *step,
                     const struct survey *survey, const struct box *grown, struct box *best)
{
    struct trim_options options = trim_options_default();
    options.anchors = 4;
    options.threads = step->threads;
    options.keep = explore->demands != NULL ? explore->demands->reference : NULL;
    struct box pure;
    box_init(&pure, grown->count);
    const struct cloud bad = cloud_newest(&survey->bad, CONSOLIDATE_TRIAL_BAD);
    bool larger = trim(grown, best, step->good, &bad, &options, &pure);
    larger = larger && demands_meet(explore->demands, &pure, DEMANDS_TIE_INSIDE) &&
             volume_above(demands_volume(explore->demands, &pure, explore->space),
                          demands_volume(explore->demands, best, explore->space));
    if (larger)
        box_assign(best, &pure);
    box_fini(&pure);
    return larger;
}

// Cuts a box without any known bad sample out of what exploration found, and one around the box as
// it stands. If one is larger than that it is put to trial.
static void start_trial(struct consolidate *consolidate, struct explore *explore,
                        const struct explore_step *step, const struct survey *survey)
{
    static const struct growth little = {.rate = 0.05};
    struct box grown;
    struct box best;
    box_init(&grown, explore->box.count);
    box_init(&best, explore->box.count);
    box_assign(&best, &explore->box);
    growth_apply(&little, &explore->box, consolidate->space, &grown);
    bool found = cut_pure(explore, step, survey, &grown, &best);
    found = cut_pure(explore, step, survey, &consolidate->explored, &best) || found;
    if (found) {
        box_assign(&consolidate->balanced, &explore->box);
        explore_move(explore, &best);
        consolidate->trial_steps = CONSOLIDATE_TRIAL_STEPS;
        consolidate->trial_bad = 0;
    }
    box_fini(&best);
    box_fini(&grown);
}

// Counts a step of the trial and decides after the last one.
static void go_on_with_trial(struct consolidate *consolidate, struct explore *explore,
                             const struct explore_step *step)
{
    consolidate->trial_bad += step->samples - step->good_count;
    if (--consolidate->trial_steps > 0)
        return;
    if (consolidate->trial_bad > consolidate->bad_to * step->samples * CONSOLIDATE_TRIAL_STEPS)
        explore_move(explore, &consolidate->balanced);
}

// Takes a box into the average (Polyak and Juditsky, 1992: the average of the last boxes has less
// noise than the last one).
static void take_average(struct consolidate *consolidate, const struct box *box)
{
    struct box *average = &consolidate->average;
    if (consolidate->average_count++ == 0)
        box_assign(average, box);
    for (uint32_t v = 0; v < box->count; v++) {
        average->lower[v] += (box->lower[v] - average->lower[v]) / consolidate->average_count;
        average->upper[v] += (box->upper[v] - average->upper[v]) / consolidate->average_count;
    }
}

// The last steps, in which the box only has to come to rest.
static void settle(struct consolidate *consolidate, struct explore *explore,
                   const struct explore_step *step, const struct survey *survey)
{
    if (consolidate->trial_steps > 0)
        return;
    if (consolidate->steps > consolidate_average_after * consolidate->step_count)
        take_average(consolidate, &explore->box);
    if (consolidate->step_count - consolidate->steps == CONSOLIDATE_TRIAL_STEPS) {
        if (consolidate->average_count > 0)
            explore_move(explore, &consolidate->average);
        start_trial(consolidate, explore, step, survey);
    }
}

// Fits a box to all that is known within what was sampled last.
static void fit_box(const struct consolidate *consolidate, struct explore *explore,
                    const struct explore_step *step, const struct survey *survey)
{
    const struct fit_options options = {
        .good = step->good,
        .keep = explore->demands != NULL ? explore->demands->reference : NULL,
        .bad_share = consolidate->bad_to,
        .threads = step->threads,
    };
    struct box fitted;
    box_init(&fitted, explore->box.count);
    fit(survey, &explore->sampled, &explore->box, &options, &fitted);
    explore_move(explore, &fitted);
    box_fini(&fitted);
}

// A step of few variables. The box is drawn out to be sampled, so that the next fit has a choice.
static void fit_once(const struct consolidate *consolidate, struct explore *explore,
                     const struct explore_step *step, const struct survey *survey)
{
    const struct growth around = {.rate = consolidate_fit_reach / explore->box.count};
    const uint32_t left = consolidate->step_count - consolidate->steps;
    const uint32_t every = (consolidate->step_count + CONSOLIDATE_FITS - 1) / CONSOLIDATE_FITS;
    if (left % every == 0)
        fit_box(consolidate, explore, step, survey);
    if (left > 0)
        growth_apply(&around, &explore->box, explore->space, &explore->sampled);
}

// A step of many variables.
static void balance_or_try(struct consolidate *consolidate, struct explore *explore,
                           struct explore_step *step, const struct survey *survey)
{
    if (consolidate->trial_steps > 0)
        go_on_with_trial(consolidate, explore, step);
    else
        balance_once(consolidate, explore, step);
    consolidate->steps++;
    const uint32_t count = consolidate->step_count;
    const uint32_t settled = (uint32_t)(consolidate_settle_after * count);
    // The first trial is over before the last one starts, or does not take place.
    if (consolidate->steps == settled && count - settled > 2 * CONSOLIDATE_TRIAL_STEPS)
        start_trial(consolidate, explore, step, survey);
    else if (consolidate->steps > settled)
        settle(consolidate, explore, step, survey);
}

// Whether a fitted box can be had. Weights, widths and shared corridors are left to balancing.
static bool fits(const struct explore *explore)
{
    const struct demands *demands = explore->demands;
    return explore->box.count <= CONSOLIDATE_FIT_VARIABLES &&
           (demands == NULL ||
            (demands->tie == NULL && demands->weights == NULL && demands->minimum_widths == NULL));
}

bool consolidate_complete(struct consolidate *consolidate, struct explore *explore,
                          struct explore_step step, const struct survey *survey)
{
    if (fits(explore)) {
        consolidate->steps++;
        fit_once(consolidate, explore, &step, survey);
    } else {
        balance_or_try(consolidate, explore, &step, survey);
    }
    return consolidate->steps == consolidate->step_count;
}

bool consolidate_resting(const struct consolidate *consolidate)
{
    return consolidate->trial_steps == 0 &&
           consolidate->steps > consolidate_settle_after * consolidate->step_count;
}

void consolidate_hasten(struct consolidate *consolidate)
{
    // One more step takes the box into the average and begins the trial.
    const uint32_t last = consolidate->steps + 1 + CONSOLIDATE_TRIAL_STEPS;
    if (consolidate_resting(consolidate) && last < consolidate->step_count)
        consolidate->step_count = last;
}
