#include "monitor/http/metrics.h"

#include "common/table/decimal.h"
#include "monitor/feed/problem.h"

#include <inttypes.h>
#include <math.h>

// ---- The format ----

static void family(GString *out, const char *name, const char *type, const char *help)
{
    g_string_append_printf(out, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

static void append_value(GString *out, double value)
{
    char number[DECIMAL_SIZE];
    const char *text = isnan(value)   ? "NaN"
                       : isinf(value) ? (value > 0 ? "+Inf" : "-Inf")
                                      : decimal_text(value, number);
    g_string_append_printf(out, " %s\n", text);
}

// Names come from the network: what would end a label is escaped.
static void append_label(GString *out, const char *name, const char *value)
{
    g_string_append_printf(out, "%s=\"", name);
    for (const char *c = value; *c != '\0'; c++) {
        if (*c == '\\' || *c == '"')
            g_string_append_c(out, '\\');
        g_string_append_c(out, *c);
    }
    g_string_append_c(out, '"');
}

// ---- Runs ----

static void append_run(GString *out, const char *name, const struct feed_run *run)
{
    g_string_append_printf(out, "%s{run=\"%016" PRIx64 "\"", name, run->id);
}

// One family: its value of every run.
static void of_runs(GString *out, const struct feed *feed, const char *name, const char *type,
                    const char *help, double (*value)(const struct feed_run *))
{
    family(out, name, type, help);
    for (guint i = 0; i < feed->runs.entries->len; i++) {
        const struct feed_run *run = feed_run_at(feed, i);
        append_run(out, name, run);
        g_string_append_c(out, '}');
        append_value(out, value(run));
    }
}

#define RUN_VALUE(name, expression)                      \
    static double run_##name(const struct feed_run *run) \
    {                                                    \
        return (double)(expression);                     \
    }
RUN_VALUE(samples, run->samples)
RUN_VALUE(batches, run->batches)
RUN_VALUE(released, run->released)
RUN_VALUE(duplicates, run->duplicates)
RUN_VALUE(rejected, run->rejected)
RUN_VALUE(lost, run->lost)
RUN_VALUE(elapsed, run->elapsed_ns / 1e9)
RUN_VALUE(service, run->service_ns / 1e9)
RUN_VALUE(searches, run->searches)
RUN_VALUE(searches_done, run->searches_done)
RUN_VALUE(workers, run->workers)
RUN_VALUE(workers_refused, run->workers_refused)

static void write_run_names(GString *out, const struct feed *feed)
{
    family(out, "sobox_run_info", "gauge", "Name of the run, always 1.");
    for (guint i = 0; i < feed->runs.entries->len; i++) {
        const struct feed_run *run = feed_run_at(feed, i);
        append_run(out, "sobox_run_info", run);
        g_string_append_c(out, ',');
        append_label(out, "name", run->name);
        g_string_append(out, "} 1\n");
    }
    family(out, "sobox_run_state", "gauge", "1 for the state that the run is in, 0 for others.");
    for (guint i = 0; i < feed->runs.entries->len; i++) {
        const struct feed_run *run = feed_run_at(feed, i);
        for (enum run_state state = 0; state <= RUN_STATE_FAILED; state++) {
            append_run(out, "sobox_run_state", run);
            g_string_append_c(out, ',');
            append_label(out, "state", protocol_run_state_name(state));
            g_string_append_printf(out, "} %d\n", run->state == state);
        }
    }
}

static void write_runs(GString *out, const struct feed *feed)
{
    write_run_names(out, feed);
    of_runs(out, feed, "sobox_samples_total", "counter", "Designs evaluated and counted.",
            run_samples);
    of_runs(out, feed, "sobox_batches_total", "counter", "Batches counted.", run_batches);
    of_runs(out, feed, "sobox_batches_released_total", "counter",
            "Batches handed out again because their lease lapsed.", run_released);
    of_runs(out, feed, "sobox_outcomes_duplicate_total", "counter",
            "Outcomes that came a second time.", run_duplicates);
    of_runs(out, feed, "sobox_packets_rejected_total", "counter",
            "Packets to the coordinator that failed a check.", run_rejected);
    of_runs(out, feed, "sobox_messages_lost_total", "counter",
            "Messages to the coordinator that were lost.", run_lost);
    of_runs(out, feed, "sobox_evaluation_seconds_total", "counter",
            "Time that workers evaluated counted batches.", run_service);
    of_runs(out, feed, "sobox_run_elapsed_seconds", "gauge", "Running time of the run.",
            run_elapsed);
    of_runs(out, feed, "sobox_run_searches", "gauge", "Searches of the run.", run_searches);
    of_runs(out, feed, "sobox_run_searches_done", "gauge", "Searches that are done.",
            run_searches_done);
    of_runs(out, feed, "sobox_run_workers", "gauge", "Workers that may hold batches.", run_workers);
    of_runs(out, feed, "sobox_run_workers_refused", "gauge", "Workers that are refused.",
            run_workers_refused);
}

// ---- Searches ----

static GPtrArray *searches_running(const struct feed *feed)
{
    GPtrArray *running = g_ptr_array_new();
    for (guint i = feed->searches.entries->len; i-- > 0 && running->len < METRICS_SEARCH_MAX;) {
        const struct feed_search *search = feed_search_at(feed, i);
        const struct feed_run *run = feed_run_find(feed, search->run);
        if (search->status == SEARCH_STATUS_RUNNING && (run == NULL || feed_run_active(run)))
            g_ptr_array_add(running, (gpointer)search);
    }
    return running;
}

static void of_searches(GString *out, const GPtrArray *searches, const char *name, const char *help,
                        double (*value)(const struct feed_search *))
{
    family(out, name, "gauge", help);
    for (guint i = 0; i < searches->len; i++) {
        const struct feed_search *search = searches->pdata[i];
        g_string_append_printf(out, "%s{run=\"%016" PRIx64 "\",search=\"%" PRIu32 "\"}", name,
                               search->run, search->index);
        append_value(out, value(search));
    }
}

static double search_step(const struct feed_search *search)
{
    return search->step;
}

static double search_good(const struct feed_search *search)
{
    return search->good_share;
}

static double search_volume(const struct feed_search *search)
{
    return search->log_volume;
}

static void write_searches(GString *out, const struct feed *feed)
{
    GPtrArray *searches = searches_running(feed);
    of_searches(out, searches, "sobox_search_steps", "Steps finished of a running search.",
                search_step);
    of_searches(out, searches, "sobox_search_good_ratio",
                "Share of good samples in the last step of a running search.", search_good);
    of_searches(out, searches, "sobox_search_log_volume",
                "Logarithm of the box's volume over the design space's, of a running search.",
                search_volume);
    g_ptr_array_free(searches, TRUE);
}

// ---- Workers ----

static void of_workers(GString *out, const struct feed *feed, const char *name, const char *type,
                       const char *help, double (*value)(const struct feed_worker *, int64_t),
                       int64_t now_ns)
{
    family(out, name, type, help);
    for (guint i = 0; i < feed->workers.entries->len; i++) {
        const struct feed_worker *worker = feed_worker_at(feed, i);
        g_string_append_printf(out, "%s{id=\"%016" PRIx64 "\",", name, worker->entry.key[0]);
        append_label(out, "worker", worker->name);
        g_string_append_c(out, '}');
        append_value(out, value(worker, now_ns));
    }
}

#define WORKER_VALUE(name, expression)                                            \
    static double worker_##name(const struct feed_worker *worker, int64_t now_ns) \
    {                                                                             \
        (void)now_ns;                                                             \
        return (double)(expression);                                              \
    }
WORKER_VALUE(up, !worker->left && now_ns - worker->heard_ns <= worker->silence_ns)
WORKER_VALUE(busy, worker->busy)
WORKER_VALUE(busy_seconds, worker->busy_ns / 1e9)
WORKER_VALUE(samples, worker->samples)
WORKER_VALUE(batches, worker->batches)
WORKER_VALUE(threads, worker->threads)
WORKER_VALUE(queue, worker->queue)
WORKER_VALUE(lost, worker->lost)
WORKER_VALUE(dropped, worker->dropped)
WORKER_VALUE(silence, (now_ns - worker->heard_ns) / 1e9)

static void write_workers(GString *out, const struct feed *feed, int64_t now_ns)
{
    of_workers(out, feed, "sobox_worker_up", "gauge", "1 while the worker is heard.", worker_up,
               now_ns);
    of_workers(out, feed, "sobox_worker_busy_ratio", "gauge",
               "Share of the last second that the worker evaluated.", worker_busy, now_ns);
    of_workers(out, feed, "sobox_worker_busy_seconds_total", "counter",
               "Time that the worker evaluated.", worker_busy_seconds, now_ns);
    of_workers(out, feed, "sobox_worker_samples_total", "counter",
               "Designs that the worker evaluated.", worker_samples, now_ns);
    of_workers(out, feed, "sobox_worker_batches_total", "counter",
               "Batches that the worker evaluated.", worker_batches, now_ns);
    of_workers(out, feed, "sobox_worker_threads", "gauge", "Threads of the worker.", worker_threads,
               now_ns);
    of_workers(out, feed, "sobox_worker_queue_batches", "gauge",
               "Batches that wait or are in work at the worker.", worker_queue, now_ns);
    of_workers(out, feed, "sobox_worker_messages_lost_total", "counter",
               "Messages that the worker knows it missed.", worker_lost, now_ns);
    of_workers(out, feed, "sobox_worker_datagrams_dropped_total", "counter",
               "Datagrams that the worker's kernel dropped.", worker_dropped, now_ns);
    of_workers(out, feed, "sobox_worker_silence_seconds", "gauge",
               "Time since the worker was heard.", worker_silence, now_ns);
}

// ---- The monitor itself ----

static void single(GString *out, const char *name, const char *type, const char *help, double value)
{
    family(out, name, type, help);
    g_string_append(out, name);
    append_value(out, value);
}

static void write_problems(GString *out, const struct feed *feed, int64_t now_ns)
{
    unsigned counts[PROBLEM_KIND_COUNT] = {0};
    GArray *problems = problem_list(feed, now_ns);
    for (guint i = 0; i < problems->len; i++)
        counts[g_array_index(problems, struct problem, i).kind]++;
    g_array_free(problems, TRUE);
    family(out, "sobox_problems", "gauge", "Problems that the monitor sees now.");
    for (int kind = 0; kind < PROBLEM_KIND_COUNT; kind++)
        g_string_append_printf(out, "sobox_problems{kind=\"%s\"} %u\n",
                               problem_name((enum problem_kind)kind), counts[kind]);
}

void metrics_write(const struct feed *feed, int64_t now_ns, GString *out)
{
    family(out, "sobox_monitor_info", "gauge", "Version of the monitor, always 1.");
    g_string_append(out, "sobox_monitor_info{version=\"" SOBOX_VERSION "\"} 1\n");
    single(out, "sobox_monitor_messages_received_total", "counter",
           "Messages that the monitor heard.", (double)feed->own.received);
    single(out, "sobox_monitor_messages_lost_total", "counter",
           "Messages that the monitor knows it missed.", (double)feed->own.lost);
    single(out, "sobox_monitor_packets_rejected_total", "counter",
           "Packets to the monitor that failed a check.", (double)feed->own.rejected);
    write_problems(out, feed, now_ns);
    write_runs(out, feed);
    write_searches(out, feed);
    write_workers(out, feed, now_ns);
}
