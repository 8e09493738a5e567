#include "coordinator/schedule/cut.h"

#include <math.h>

static uint32_t count_min(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static uint32_t count_max(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

// From a count in floating point, which may be anything above 0.
static uint32_t count_of(double count)
{
    return count < 1 ? 1 : count > UINT32_MAX / 2 ? UINT32_MAX / 2 : (uint32_t)count;
}

// The greatest batch for this worker.
static uint32_t cut_cap(const struct schedule_settings *settings, const struct roster *roster,
                        const struct roster_worker *worker, const struct backlog_step *step,
                        double sample_ns)
{
    const uint32_t message = settings->batch_samples_max[step->detail];
    uint32_t time = count_max(count_of((double)roster_target_ns(roster) / sample_ns),
                              CUT_LANES * worker->threads);
    if (!step->sample_known && !roster->core.measured)
        time = count_min(time, CUT_UNKNOWN_COUNT);
    uint32_t cap = count_min(message, time);
    return cap > CUT_LANES ? cap / CUT_LANES * CUT_LANES : cap;
}

// What a part of the step should take this worker at least, for its messages to be worth it [ns].
static double cut_worth_ns(const struct roster *roster, const struct backlog_step *step,
                           uint32_t search_count, double sample_ns)
{
    const double message_ns = (double)roster->settings->message_ns;
    const double most_ns = (double)roster_turn_ns(roster);
    const double best_ns = search_count * sqrt(step->samples * sample_ns * message_ns);
    return fmax(CUT_WORTH_NS, fmin(most_ns, best_ns));
}

// This worker's part of the step: all of it when there are at least as many open steps as workers.
static uint32_t cut_share(const struct roster *roster, const struct roster_worker *worker,
                          const struct backlog_step *step, uint32_t open_count)
{
    // A stalled worker is not in the total: it is given a batch only when there is nobody else.
    if (worker->rate == 0)
        return step->samples;
    double fraction = (double)open_count * (double)worker->rate / (double)roster->rate_total;
    return count_of(ceil(fmin(fraction, 1) * step->samples));
}

uint32_t cut_count(const struct schedule_settings *settings, const struct roster *roster,
                   const struct roster_worker *worker, const struct backlog_step *step,
                   uint32_t open_count, uint32_t search_count)
{
    double sample_ns = fmax(step->sample_ns * roster_service(roster, worker), 1e-3);
    uint32_t rest = step->samples - step->cut;
    uint32_t cap = cut_cap(settings, roster, worker, step, sample_ns);
    uint32_t worth =
        count_of(ceil(cut_worth_ns(roster, step, search_count, sample_ns) / sample_ns));
    uint32_t share = count_min(rest, cut_share(roster, worker, step, open_count));
    // What is left goes in equal parts of about what is worth it: a small one at the end would
    // cost its messages for nothing.
    if (share < worth)
        share = (rest - 1) / count_max(1, (rest + worth / 2) / worth) + 1;
    uint32_t parts = (share - 1) / cap + 1;
    uint32_t count = (share - 1) / parts + 1;
    // Equal parts of a little more than fits are half of what fits: still worth their messages.
    count = count_max(count, count_min(count_min(worth, cap), share));
    if (cap >= CUT_LANES)
        count = count_min(cap, (count - 1) / CUT_LANES * CUT_LANES + CUT_LANES);
    if (rest <= cap && rest - count_min(rest, count) <= count / 8)
        return rest;
    return count_min(rest, count);
}
