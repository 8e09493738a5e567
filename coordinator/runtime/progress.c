#include "coordinator/runtime/progress.h"

#include "common/base/clock.h"
#include "common/base/log.h"

#include <math.h>
#include <stdio.h>

// 12300 as "12.3 k", 4560000 as "4.56 M".
const char *progress_number(double value, char text[16])
{
    if (value < 1e4)
        snprintf(text, 16, "%.0f", value);
    else if (value < 1e6)
        snprintf(text, 16, "%.1f k", value / 1e3);
    else
        snprintf(text, 16, "%.2f M", value / 1e6);
    return text;
}

const char *progress_duration(double seconds, char text[32])
{
    if (seconds < 100)
        snprintf(text, 32, "%.0f s", seconds);
    else if (seconds < 100 * 60)
        snprintf(text, 32, "%.0f min", seconds / 60);
    else if (seconds < 100 * 3600)
        snprintf(text, 32, "%.1f h", seconds / 3600);
    else
        snprintf(text, 32, "%.1f days", seconds / 86400);
    return text;
}

// ", about 12 min left", from the searches that this session has finished; those that are running
// count half. Nothing is said before there is something to go by.
static const char *time_left(const struct run *run, int64_t now_ns, char text[48])
{
    text[0] = '\0';
    if (run->finished_count == 0)
        return text;
    const double done = run->finished_count + 0.5 * run->open_count;
    const double left = run->chosen_count - done;
    const double seconds = (double)(now_ns - run->started_ns) / CLOCK_SECOND_NS * left / done;
    char duration[32];
    snprintf(text, 48, ", about %s left", progress_duration(seconds, duration));
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
        char left[48];
        log_progress("%u of %u searches done, %u running, %u waiting%s | %s designs, %s/s | %s",
                     run->done_count, run->record.search_count, run->open_count,
                     run->chosen_count - run->finished_count - run->open_count,
                     time_left(run, now_ns, left),
                     progress_number((double)counters->samples_counted, designs),
                     progress_number(rate, speed), workers);
        return;
    }
    if (run->open[0] == NULL)
        return;
    struct search_progress search;
    search_progress(run->open[0]->search, &search);
    char volume[16] = "-"; // while there is no box yet
    if (isfinite(search.log_volume))
        snprintf(volume, sizeof volume, "%.2f", search.log_volume);
    log_progress("%s, step %u of about %u | %.0f %% good | ln(volume) %s | %s designs, %s/s | %s",
                 protocol_phase_name(search.phase), search.step, search.step_count,
                 100 * search.good_share, volume,
                 progress_number((double)search.evaluations, designs), progress_number(rate, speed),
                 workers);
}

void progress_end(struct progress *progress)
{
    *progress = (struct progress){0};
    log_progress_end();
}
