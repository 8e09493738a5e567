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
    uint32_t message =
        step->share_only ? settings->batch_verdicts_max : settings->batch_samples_max;
    uint32_t time =
        count_max(count_of((double)settings->batch_target_ns / sample_ns), worker->threads);
    if (!step->sample_known && !roster->core.measured)
        time = count_min(time, CUT_UNKNOWN_COUNT);
    uint32_t cap = count_min(message, time);
    return cap > CUT_LANES ? cap / CUT_LANES * CUT_LANES : cap;
}

// This worker's part of the step: all of it when there are at least as many open steps as workers.
static uint32_t cut_share(const struct roster *roster, const struct roster_worker *worker,
                          const struct backlog_step *step, uint32_t open_count, double sample_ns)
{
    // A stalled worker is not in the total: it is given a batch only when there is nobody else.
    if (worker->rate == 0)
        return step->samples;
    double fraction = (double)open_count * (double)worker->rate / (double)roster->rate_total;
    uint32_t share = count_of(ceil(fmin(fraction, 1) * step->samples));
    return count_max(share, count_of(ceil(CUT_WORTH_NS / sample_ns)));
}

uint32_t cut_count(const struct schedule_settings *settings, const struct roster *roster,
                   const struct roster_worker *worker, const struct backlog_step *step,
                   uint32_t open_count)
{
    double sample_ns = fmax(step->sample_ns * roster_service(roster, worker), 1e-3);
    uint32_t rest = step->samples - step->cut;
    uint32_t cap = cut_cap(settings, roster, worker, step, sample_ns);
    uint32_t share = count_min(rest, cut_share(roster, worker, step, open_count, sample_ns));
    uint32_t parts = (share - 1) / cap + 1;
    uint32_t count = (share - 1) / parts + 1;
    if (cap >= CUT_LANES)
        count = count_min(cap, (count - 1) / CUT_LANES * CUT_LANES + CUT_LANES);
    if (rest <= cap && rest - count_min(rest, count) <= count / 8)
        return rest;
    return count_min(rest, count);
}
