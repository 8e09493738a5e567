#include "monitor/feed/feed.h"

#include <string.h>

static void search_free(gpointer user)
{
    struct feed_search *search = user;
    g_array_free(search->bounds, TRUE);
    g_free(search);
}

void feed_init(struct feed *feed)
{
    feed->runs = g_ptr_array_new_with_free_func(g_free);
    feed->searches = g_ptr_array_new_with_free_func(search_free);
    feed->workers = g_ptr_array_new_with_free_func(g_free);
}

void feed_fini(struct feed *feed)
{
    g_ptr_array_free(feed->runs, TRUE);
    g_ptr_array_free(feed->searches, TRUE);
    g_ptr_array_free(feed->workers, TRUE);
}

// A byte field as text: it is NUL-terminated by the wire's check, and shown as it is only where it
// cannot move the cursor of a terminal.
static void text_copy(char *to, size_t size, const uint8_t *from)
{
    g_strlcpy(to, (const char *)from, size);
    for (char *c = to; *c != '\0'; c++) {
        if ((unsigned char)*c < ' ' || *c == 0x7f)
            *c = '?';
    }
}

// What changed per second between two messages, or `before` when no time lies between.
static double rate_between(uint64_t now, uint64_t then, int64_t since_ns, double before)
{
    if (since_ns <= 0 || now < then)
        return before;
    return (double)(now - then) * 1e9 / (double)since_ns;
}

static struct feed_run *run_entry(struct feed *feed, uint64_t id)
{
    guint oldest = 0;
    for (guint i = 0; i < feed->runs->len; i++) {
        struct feed_run *run = feed->runs->pdata[i];
        if (run->id == id)
            return run;
        if (run->heard_ns < ((struct feed_run *)feed->runs->pdata[oldest])->heard_ns)
            oldest = i;
    }
    if (feed->runs->len == FEED_RUN_MAX)
        g_ptr_array_remove_index(feed->runs, oldest);
    struct feed_run *run = g_new0(struct feed_run, 1);
    run->id = id;
    g_ptr_array_add(feed->runs, run);
    return run;
}

void feed_run_heard(struct feed *feed, const sobox_run_status_t *message, int64_t now_ns)
{
    struct feed_run *run = run_entry(feed, (uint64_t)message->header.run);
    // A message of the past, come late, would turn the picture back.
    if (message->elapsed_ns < run->elapsed_ns)
        return;
    run->rate = rate_between((uint64_t)message->samples, run->samples,
                             message->elapsed_ns - run->elapsed_ns, run->rate);
    text_copy(run->name, sizeof run->name, message->name);
    run->state = message->state;
    run->searches = (uint32_t)message->searches;
    run->searches_done = (uint32_t)message->searches_done;
    run->workers = (uint32_t)message->workers;
    run->workers_refused = (uint32_t)message->workers_refused;
    run->samples = (uint64_t)message->samples;
    run->batches = (uint64_t)message->batches;
    run->released = (uint64_t)message->released;
    run->duplicates = (uint64_t)message->duplicates;
    run->rejected = (uint64_t)message->rejected;
    run->lost = (uint64_t)message->lost;
    run->elapsed_ns = message->elapsed_ns;
    run->heard_ns = now_ns;
}

const struct feed_search *feed_search_find(const struct feed *feed, uint64_t run, uint32_t index)
{
    for (guint i = 0; i < feed->searches->len; i++) {
        const struct feed_search *search = feed->searches->pdata[i];
        if (search->run == run && search->index == index)
            return search;
    }
    return NULL;
}

static struct feed_search *search_entry(struct feed *feed, uint64_t run, uint32_t index)
{
    struct feed_search *search = (struct feed_search *)feed_search_find(feed, run, index);
    if (search != NULL)
        return search;
    if (feed->searches->len == FEED_SEARCH_MAX) {
        guint oldest = 0;
        for (guint i = 1; i < feed->searches->len; i++) {
            const struct feed_search *old = feed->searches->pdata[oldest];
            const struct feed_search *entry = feed->searches->pdata[i];
            if (entry->heard_ns < old->heard_ns)
                oldest = i;
        }
        g_ptr_array_remove_index(feed->searches, oldest);
    }
    search = g_new0(struct feed_search, 1);
    search->run = run;
    search->index = index;
    search->bounds = g_array_new(FALSE, FALSE, sizeof(double));
    g_ptr_array_add(feed->searches, search);
    return search;
}

void feed_search_heard(struct feed *feed, const sobox_search_status_t *message, int64_t now_ns)
{
    struct feed_search *search =
        search_entry(feed, (uint64_t)message->header.run, (uint32_t)message->search);
    if ((uint32_t)message->step < search->step)
        return;
    search->phase = message->phase;
    search->status = message->status;
    search->step = (uint32_t)message->step;
    search->step_count = (uint32_t)message->step_count;
    search->evaluations = (uint64_t)message->evaluations;
    search->good_share = message->good_share;
    search->log_volume = message->log_volume;
    search->purity_lower95 = message->purity_lower95;
    g_array_set_size(search->bounds, 0);
    g_array_append_vals(search->bounds, message->bounds, (guint)message->bound_count);
    search->heard_ns = now_ns;
}

static struct feed_worker *worker_entry(struct feed *feed, uint64_t id)
{
    guint oldest = 0;
    for (guint i = 0; i < feed->workers->len; i++) {
        struct feed_worker *worker = feed->workers->pdata[i];
        if (worker->id == id)
            return worker;
        if (worker->heard_ns < ((struct feed_worker *)feed->workers->pdata[oldest])->heard_ns)
            oldest = i;
    }
    if (feed->workers->len == FEED_WORKER_MAX)
        g_ptr_array_remove_index(feed->workers, oldest);
    struct feed_worker *worker = g_new0(struct feed_worker, 1);
    worker->id = id;
    g_ptr_array_add(feed->workers, worker);
    return worker;
}

void feed_worker_heard(struct feed *feed, const sobox_worker_status_t *message, int64_t now_ns)
{
    struct feed_worker *worker = worker_entry(feed, (uint64_t)message->header.sender);
    if (message->uptime_ns < worker->uptime_ns)
        return;
    const int64_t since_ns = message->uptime_ns - worker->uptime_ns;
    worker->rate =
        rate_between((uint64_t)message->samples, worker->samples, since_ns, worker->rate);
    worker->busy = rate_between((uint64_t)message->busy_ns, (uint64_t)worker->busy_ns, since_ns,
                                worker->busy * 1e9) /
                   1e9;
    char host[64];
    text_copy(host, sizeof host, message->host);
    g_snprintf(worker->name, sizeof worker->name, "%s/%d", host, message->process);
    worker->threads = (uint32_t)message->threads;
    worker->queue = (uint32_t)message->queue;
    worker->batches = (uint64_t)message->batches;
    worker->samples = (uint64_t)message->samples;
    worker->busy_ns = message->busy_ns;
    worker->uptime_ns = message->uptime_ns;
    worker->lost = (uint64_t)message->lost;
    worker->dropped = (uint64_t)message->dropped;
    worker->left = message->leaving != 0;
    worker->heard_ns = now_ns;
}
