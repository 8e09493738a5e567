#include "monitor/feed/problem.h"

#include <inttypes.h>

// Below these nothing needs doing: every busy network loses a packet now and then, and a late batch
// is handed out twice to gain time.
static const double LOST_SHARE_MIN = 0.02;
static const double RELEASED_SHARE_MIN = 0.05;
static const double COUNT_MIN = 5; // fewer show nothing
// A worker with nothing to do for so many messages (seconds) in a row is idle.
enum { IDLE_MESSAGES = 3 };

static void __attribute__((format(printf, 4, 5)))
add(GArray *problems, enum problem_kind kind, uint64_t run, const char *format, ...)
{
    struct problem problem = {.kind = kind, .run = run};
    va_list arguments;
    va_start(arguments, format);
    g_vsnprintf(problem.text, sizeof problem.text, format, arguments);
    va_end(arguments);
    g_array_append_val(problems, problem);
}

static double silent_s(int64_t heard_ns, int64_t now_ns)
{
    return (double)((now_ns - heard_ns) / INT64_C(1000000000));
}

// ---- Runs ----

static void coordinator_silent(GArray *problems, const struct feed_run *run, int64_t now_ns)
{
    add(problems, PROBLEM_COORDINATOR_SILENT, run->id,
        "%s: its coordinator is silent since %.0f s: it was killed, its machine sleeps, or the "
        "network between is broken",
        run->name, silent_s(run->heard_ns, now_ns));
}

static void run_counts(GArray *problems, const struct feed_run *run)
{
    if (run->state == RUN_STATE_WAITING)
        add(problems, PROBLEM_NO_WORKERS, run->id,
            "%s waits for workers: start sobox-worker with the same --url", run->name);
    if (run->workers_refused > 0)
        add(problems, PROBLEM_WORKERS_REFUSED, run->id,
            "%s: %" PRIu32 " worker%s refused, because their sobox computes with another kernel "
            "than the coordinator's: install the same version everywhere",
            run->name, run->workers_refused, run->workers_refused == 1 ? " is" : "s are");
    const double handed_out = run->recent.received + run->recent.released;
    if (run->recent.released >= COUNT_MIN && run->recent.released > RELEASED_SHARE_MIN * handed_out)
        add(problems, PROBLEM_BATCHES_RELEASED, run->id,
            "%s: %.0f %% of the batches are handed out again: workers are gone or overloaded, or "
            "messages are lost",
            run->name, 100 * run->recent.released / handed_out);
    const double lost = feed_recent_lost_share(&run->recent);
    if (run->recent.lost >= COUNT_MIN && lost > LOST_SHARE_MIN)
        add(problems, PROBLEM_MESSAGES_LOST, run->id,
            "%s: %.0f %% of the messages to its coordinator are lost: raise net.core.rmem_max on "
            "its machine",
            run->name, 100 * lost);
}

static bool about_runs(GArray *problems, const struct feed *feed, int64_t now_ns)
{
    bool running = false;
    for (guint i = 0; i < feed->runs.entries->len; i++) {
        const struct feed_run *run = feed_run_at(feed, i);
        if (!feed_run_active(run))
            continue;
        if (now_ns - run->heard_ns > FEED_SILENCE_NS) {
            coordinator_silent(problems, run, now_ns);
        } else {
            run_counts(problems, run);
            running |= run->state == RUN_STATE_RUNNING;
        }
    }
    return running;
}

// ---- Workers ----

static void worker_silent(GArray *problems, const struct feed_worker *worker, int64_t now_ns)
{
    const double seconds = silent_s(worker->heard_ns, now_ns);
    if (worker->queue == 0)
        add(problems, PROBLEM_WORKER_SILENT, 0, "worker %s is silent since %.0f s", worker->name,
            seconds);
    else
        add(problems, PROBLEM_WORKER_SILENT, 0,
            "worker %s is silent since %.0f s: the batches it held (%" PRIu32 ") are handed out "
            "again",
            worker->name, seconds, worker->queue);
}

static void worker_dropped(GArray *problems, const struct feed_worker *worker)
{
    add(problems, PROBLEM_DATAGRAMS_DROPPED, 0,
        "worker %s: %.0f %% of the messages to it are lost, its receive buffer of %" PRIu32
        " KiB is too small: raise net.core.rmem_max there",
        worker->name, 100 * feed_recent_lost_share(&worker->recent), worker->buffer_size / 1024);
}

static void worker_lost(GArray *problems, const struct feed_worker *worker)
{
    add(problems, PROBLEM_MESSAGES_LOST, 0,
        "worker %s: %.0f %% of the messages to it are lost: raise net.core.rmem_max there, or look "
        "at the network between",
        worker->name, 100 * feed_recent_lost_share(&worker->recent));
}

struct count {
    guint silent, lossy, idle;
    uint64_t waiting; // batches at workers that have more than their threads work on
};

static void about_worker(GArray *problems, const struct feed_worker *worker, int64_t now_ns,
                         struct count *count)
{
    if (worker->left)
        return;
    if (now_ns - worker->heard_ns > worker->silence_ns) {
        if (count->silent++ < PROBLEM_NAMED_MAX)
            worker_silent(problems, worker, now_ns);
        return;
    }
    count->idle += worker->idle >= IDLE_MESSAGES;
    if (worker->queue > worker->threads)
        count->waiting += worker->queue - worker->threads;
    if (worker->recent.lost < COUNT_MIN ||
        feed_recent_lost_share(&worker->recent) <= LOST_SHARE_MIN)
        return;
    if (count->lossy++ >= PROBLEM_NAMED_MAX)
        return;
    if (worker->dropped > 0)
        worker_dropped(problems, worker);
    else
        worker_lost(problems, worker);
}

static void about_workers(GArray *problems, const struct feed *feed, int64_t now_ns, bool running)
{
    struct count count = {0};
    for (guint i = 0; i < feed->workers.entries->len; i++)
        about_worker(problems, feed_worker_at(feed, i), now_ns, &count);
    if (count.silent > PROBLEM_NAMED_MAX)
        add(problems, PROBLEM_WORKER_SILENT, 0, "%u more workers are silent",
            count.silent - PROBLEM_NAMED_MAX);
    if (count.lossy > PROBLEM_NAMED_MAX)
        add(problems, PROBLEM_MESSAGES_LOST, 0, "%u more workers lose messages",
            count.lossy - PROBLEM_NAMED_MAX);
    if (running && count.idle > 0 && count.waiting > 0)
        add(problems, PROBLEM_WORKERS_IDLE, 0,
            "%u %s idle while %" PRIu64 " batches wait at others: are they refused, or deaf to the "
            "coordinator?",
            count.idle, count.idle == 1 ? "worker is" : "workers are", count.waiting);
}

static void about_monitor(GArray *problems, const struct feed *feed)
{
    const double lost = feed_recent_lost_share(&feed->own_recent);
    if (feed->own_recent.lost >= COUNT_MIN && lost > LOST_SHARE_MIN)
        add(problems, PROBLEM_MONITOR_DEAF, 0,
            "this monitor misses %.0f %% of the messages, what it shows may lag: raise "
            "net.core.rmem_max on its machine",
            100 * lost);
    if (feed->own.foreign > 0)
        add(problems, PROBLEM_FOREIGN_PROTOCOL, 0,
            "%" PRIu64 " messages are of another version of sobox and are not shown",
            feed->own.foreign);
    if (feed->own.unopened > 0)
        add(problems, PROBLEM_OTHER_KEY, 0,
            "%" PRIu64 " messages are sealed with another key than this monitor's, or with none, "
            "and are not shown: see --key-file",
            feed->own.unopened);
}

GArray *problem_list(const struct feed *feed, int64_t now_ns)
{
    GArray *problems = g_array_new(FALSE, FALSE, sizeof(struct problem));
    const bool running = about_runs(problems, feed, now_ns);
    about_workers(problems, feed, now_ns, running);
    about_monitor(problems, feed);
    return problems;
}

const char *problem_name(enum problem_kind kind)
{
    static const char *const names[] = {
#define PROBLEM_NAME(name, text) text,
        PROBLEM_LIST(PROBLEM_NAME)
#undef PROBLEM_NAME
    };
    return names[kind];
}
