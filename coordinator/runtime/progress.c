#include "coordinator/runtime/progress.h"

#include "common/base/clock.h"
#include "common/base/log.h"

#include <stdio.h>

// 12300 as "12.3 k", 4560000 as "4.56 M".
static const char *short_number(double value, char text[16])
{
    if (value < 1e4)
        snprintf(text, 16, "%.0f", value);
    else if (value < 1e6)
        snprintf(text, 16, "%.1f k", value / 1e3);
    else
        snprintf(text, 16, "%.2f M", value / 1e6);
    return text;
}

void progress_show(struct progress *progress, const struct run *run,
                   const struct schedule_counters *counters, int64_t now_ns)
{
    const int64_t since_ns = now_ns - (progress->shown_ns ? progress->shown_ns : run->started_ns);
    const uint64_t since_samples = counters->samples_counted - progress->shown_samples;
    const double rate =
        since_ns > 0 ? (double)since_samples * CLOCK_SECOND_NS / (double)since_ns : 0;
    progress->shown_ns = now_ns;
    progress->shown_samples = counters->samples_counted;

    char designs[16], speed[16], workers[48];
    if (counters->workers == 0)
        snprintf(workers, sizeof workers, "waiting for a worker");
    else
        snprintf(workers, sizeof workers, "%u worker%s", counters->workers,
                 counters->workers == 1 ? "" : "s");
    if (run->record.search_count > 1) {
        log_progress("%u of %u searches done | %s designs, %s/s | %s", run->done_count,
                     run->record.search_count,
                     short_number((double)counters->samples_counted, designs),
                     short_number(rate, speed), workers);
        return;
    }
    struct search_progress search;
    search_progress(run->searches[0].search, &search);
    log_progress("%s, step %u of about %u | %.0f %% good | ln(volume) %.2f | %s designs, %s/s | %s",
                 search_phase_name(search.phase), search.step, search.step_count,
                 100 * search.good_share, search.log_volume,
                 short_number((double)search.evaluations, designs), short_number(rate, speed),
                 workers);
}

void progress_end(struct progress *progress)
{
    *progress = (struct progress){0};
    log_progress_end();
}
