#include "monitor/terminal/lines.h"

#include "monitor/feed/problem.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>

// No box that is one is smaller: 4,096 variables, each a thousand million million times.
#define VOLUME_KNOWN_MIN (-1e18)

static void print_search(const struct feed_search *search, FILE *out)
{
    fprintf(out, " | %s, step %u of about %u | %.0f %% good | ln(volume) ",
            protocol_phase_name(search->phase), search->step, search->step_count,
            100 * search->good_share);
    if (search->log_volume > VOLUME_KNOWN_MIN)
        fprintf(out, "%.2f", search->log_volume);
    else
        fputc('-', out); // while there is no box yet
    if (search->purity_lower95 > 0)
        fprintf(out, " | purity >= %.4f", search->purity_lower95);
}

static void print_run(const struct feed *feed, const struct feed_run *run, FILE *out)
{
    fprintf(out, "%s: %s", run->name, protocol_run_state_name(run->state));
    if (run->searches > 1) {
        fprintf(out, " | %u of %u searches done", run->searches_done, run->searches);
    } else {
        const struct feed_search *search = feed_search_find(feed, run->id, 0);
        if (search != NULL)
            print_search(search, out);
    }
    fprintf(out, " | %" PRIu64 " designs, %.0f/s | %u worker%s", run->samples, run->rate,
            run->workers, run->workers == 1 ? "" : "s");
    if (run->released > 0)
        fprintf(out, " | %" PRIu64 " batches handed out again", run->released);
    if (run->lost > 0)
        fprintf(out, " | %" PRIu64 " messages lost", run->lost);
    fputc('\n', out);
}

static void print_problems(const struct feed *feed, int64_t now_ns, FILE *out)
{
    GArray *problems = problem_list(feed, now_ns);
    for (guint i = 0; i < problems->len; i++)
        fprintf(out, "  %s\n", g_array_index(problems, struct problem, i).text);
    g_array_free(problems, TRUE);
}

unsigned lines_print(const struct feed *feed, int64_t since_ns, int64_t now_ns, FILE *out)
{
    unsigned count = 0;
    for (guint i = 0; i < feed->runs.entries->len; i++) {
        const struct feed_run *run = feed_run_at(feed, i);
        if (run->heard_ns < since_ns)
            continue;
        print_run(feed, run, out);
        count++;
    }
    if (count > 0)
        print_problems(feed, now_ns, out);
    return count;
}

// The network may bring any double; JSON knows finite ones only.
static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *search_json(const struct feed *feed, const struct feed_search *search)
{
    return json_pack(
        "{s:I, s:s*, s:s, s:s, s:I, s:I, s:I, s:o, s:o, s:o}", "search", (json_int_t)search->index,
        "case", feed_case_name(feed, search->run, search->index), "phase",
        protocol_phase_name(search->phase), "status", feed_search_word(search), "step",
        (json_int_t)search->step, "step_count", (json_int_t)search->step_count, "evaluations",
        (json_int_t)search->evaluations, "good_share", number(search->good_share), "log_volume",
        number(search->log_volume), "purity_lower95", number(search->purity_lower95));
}

static json_t *run_json(const struct feed *feed, const struct feed_run *run)
{
    json_t *searches = json_array();
    for (guint i = 0; i < feed->searches.entries->len; i++) {
        const struct feed_search *search = feed_search_at(feed, i);
        if (search->run == run->id)
            json_array_append_new(searches, search_json(feed, search));
    }
    return json_pack("{s:s, s:s, s:I, s:I, s:I, s:I, s:o, s:I, s:I, s:o, s:o}", "name", run->name,
                     "state", protocol_run_state_name(run->state), "samples",
                     (json_int_t)run->samples, "workers", (json_int_t)run->workers,
                     "workers_refused", (json_int_t)run->workers_refused, "released",
                     (json_int_t)run->released, "rate", number(run->rate), "lost",
                     (json_int_t)run->lost, "searches_done", (json_int_t)run->searches_done,
                     "elapsed_s", number((double)run->elapsed_ns / 1e9), "searches", searches);
}

static json_t *worker_json(const struct feed_worker *worker, int64_t now_ns)
{
    return json_pack("{s:s, s:I, s:I, s:I, s:o, s:o, s:I, s:I, s:b, s:o}", "name", worker->name,
                     "threads", (json_int_t)worker->threads, "queue", (json_int_t)worker->queue,
                     "samples", (json_int_t)worker->samples, "rate", number(worker->rate), "busy",
                     number(worker->busy), "lost", (json_int_t)worker->lost, "dropped",
                     (json_int_t)worker->dropped, "left", worker->left, "heard_s_ago",
                     number((double)(now_ns - worker->heard_ns) / 1e9));
}

static json_t *problems_json(const struct feed *feed, int64_t now_ns)
{
    GArray *problems = problem_list(feed, now_ns);
    json_t *array = json_array();
    for (guint i = 0; i < problems->len; i++) {
        const struct problem *problem = &g_array_index(problems, struct problem, i);
        json_array_append_new(array, json_pack("{s:s, s:s}", "kind", problem_name(problem->kind),
                                               "text", problem->text));
    }
    g_array_free(problems, TRUE);
    return array;
}

void lines_print_json(const struct feed *feed, int64_t now_ns, double time_s, FILE *out)
{
    json_t *runs = json_array();
    for (guint i = 0; i < feed->runs.entries->len; i++)
        json_array_append_new(runs, run_json(feed, feed_run_at(feed, i)));
    json_t *workers = json_array();
    for (guint i = 0; i < feed->workers.entries->len; i++)
        json_array_append_new(workers, worker_json(feed_worker_at(feed, i), now_ns));
    json_t *object = json_pack("{s:o, s:o, s:o, s:o}", "time", number(time_s), "runs", runs,
                               "workers", workers, "problems", problems_json(feed, now_ns));
    // Twelve digits: the time in seconds since 1970 has ten before its point.
    json_dumpf(object, out, JSON_COMPACT | JSON_REAL_PRECISION(12));
    fputc('\n', out);
    json_decref(object);
}
