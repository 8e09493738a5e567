#include "monitor/feed/feed.h"

#include "common/base/pace.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double RECENT_S = 10;

static void release_run(gpointer user)
{
    struct feed_run *run = user;
    history_fini(&run->pace);
    cases_fini(&run->names);
    g_free(run);
}

static void album_end(struct feed_search *search)
{
    if (search->album == NULL)
        return;
    g_queue_unlink(search->albums, &search->album_link);
    album_fini(search->album);
    g_clear_pointer(&search->album, g_free);
}

static void release_search(gpointer user)
{
    struct feed_search *search = user;
    history_fini(&search->steps);
    g_array_free(search->bounds, TRUE);
    g_array_free(search->parts, TRUE);
    album_end(search);
    g_free(search);
}

void feed_init(struct feed *feed)
{
    *feed = (struct feed){0};
    table_init(&feed->runs, FEED_RUN_MAX, release_run);
    table_init(&feed->searches, FEED_SEARCH_MAX, release_search);
    table_init(&feed->workers, FEED_WORKER_MAX, g_free);
}

void feed_fini(struct feed *feed)
{
    table_fini(&feed->runs);
    table_fini(&feed->searches);
    table_fini(&feed->workers);
}

// ---- What messages have in common ----

// A byte field as text: it is NUL-terminated by the wire's check. It may come from anybody, so what
// could move the cursor of a terminal or is no UTF-8 is shown as a question mark.
static void text_copy(char *to, size_t size, const uint8_t *from)
{
    g_strlcpy(to, (const char *)from, size);
    const char *wrong;
    while (!g_utf8_validate(to, -1, &wrong))
        to[wrong - to] = '?';
    for (char *c = to; *c != '\0'; c = g_utf8_next_char(c)) {
        const gunichar letter = g_utf8_get_char(c);
        if (letter < ' ' || letter == 0x7f)
            *c = '?';
        else if (!g_unichar_isprint(letter))
            memset(c, '?', (size_t)(g_utf8_next_char(c) - c));
    }
}

// Whether a message is older than what is shown, or the same. A new sender is a program started
// anew; the one before it may still be heard for a moment. After a silence anything is news: a
// recording may be played again.
static bool is_late(struct feed_origin *origin, const sobox_header_t *header, int64_t silent_ns)
{
    const uint64_t sender = (uint64_t)header->sender;
    const uint32_t sequence = (uint32_t)header->sequence;
    if (origin->sender != 0 && silent_ns < FEED_SILENCE_NS) {
        if (sender == origin->sender && (int32_t)(sequence - origin->sequence) <= 0)
            return true;
        if (sender != origin->sender && sender == origin->sender_before)
            return true;
    }
    if (sender != origin->sender)
        origin->sender_before = origin->sender;
    origin->sender = sender;
    origin->sequence = sequence;
    return false;
}

// What changed per second between two messages, or `before` when no time lies between.
static double rate_between(uint64_t now, uint64_t then, int64_t since_ns, double before)
{
    if (since_ns <= 0 || now < then)
        return before;
    return (double)(now - then) * 1e9 / (double)since_ns;
}

static double grown(uint64_t now, uint64_t then)
{
    return now > then ? (double)(now - then) : 0;
}

static void recent_add(struct feed_recent *recent, int64_t since_ns, double received, double lost,
                       double released)
{
    const double fading = exp(-(double)MAX(since_ns, 0) / 1e9 / RECENT_S);
    recent->received = recent->received * fading + received;
    recent->lost = recent->lost * fading + lost;
    recent->released = recent->released * fading + released;
}

double feed_recent_lost_share(const struct feed_recent *recent)
{
    const double sent = recent->received + recent->lost;
    return sent > 0 ? recent->lost / sent : 0;
}

// ---- Runs ----

static struct feed_run *run_entry(struct feed *feed, uint64_t id)
{
    struct feed_run *run = table_find(&feed->runs, id, 0);
    if (run != NULL)
        return run;
    run = g_new0(struct feed_run, 1);
    run->id = id;
    history_init(&run->pace, sizeof(struct feed_pace), FEED_PACE_MAX);
    cases_init(&run->names);
    table_add(&feed->runs, &run->entry, id, 0);
    return run;
}

// Adds where the run stands to its course. A coordinator that was started anew may stand before
// what was shown: the course is cut back to there.
static void pace_add(struct feed_run *run)
{
    const struct feed_pace pace = {
        .elapsed_s = (double)run->elapsed_ns / 1e9,
        .rate = run->rate,
        .lost_share = feed_recent_lost_share(&run->recent),
        .released = (double)run->released,
    };
    guint beyond = 0;
    while (beyond < run->pace.points->len) {
        const guint last = run->pace.points->len - 1 - beyond;
        if (g_array_index(run->pace.points, struct feed_pace, last).elapsed_s < pace.elapsed_s)
            break;
        beyond++;
    }
    history_cut(&run->pace, beyond);
    history_add(&run->pace, &pace);
}

void feed_run_read(struct feed *feed, uint64_t id, const sobox_run_status_t *message,
                   int64_t now_ns)
{
    struct feed_run *run = run_entry(feed, id);
    const bool first = run->changed == 0;
    const int64_t since_ns = message->elapsed_ns - run->elapsed_ns;
    // What a monitor that came late has missed is not what happens now.
    if (!first) {
        run->rate = rate_between((uint64_t)message->samples, run->samples, since_ns, run->rate);
        recent_add(&run->recent, since_ns, grown((uint64_t)message->batches, run->batches),
                   grown((uint64_t)message->lost, run->lost),
                   grown((uint64_t)message->released, run->released));
    } else if (message->elapsed_ns > 0) {
        run->rate = (double)message->samples * 1e9 / (double)message->elapsed_ns;
    }
    text_copy(run->name, sizeof run->name, message->name);
    memcpy(run->fingerprint.bytes, message->fingerprint, DIGEST_SIZE);
    run->state = (enum run_state)message->state;
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
    run->service_ns = message->service_ns;
    run->heard_ns = now_ns;
    run->changed = ++feed->version;
    pace_add(run);
    table_touch(&feed->runs, &run->entry);
}

void feed_run_heard(struct feed *feed, const sobox_run_status_t *message, int64_t now_ns)
{
    const uint64_t id = (uint64_t)message->header.run;
    struct feed_run *run = run_entry(feed, id);
    if (!is_late(&run->origin, &message->header, now_ns - run->heard_ns))
        feed_run_read(feed, id, message, now_ns);
}

bool feed_run_active(const struct feed_run *run)
{
    return run->state == RUN_STATE_RUNNING || run->state == RUN_STATE_WAITING;
}

double feed_run_left_s(const struct feed *feed, const struct feed_run *run)
{
    if (run->state != RUN_STATE_RUNNING)
        return -1;
    if (run->searches > 1) {
        if (run->searches_done == 0)
            return -1;
        return (double)run->elapsed_ns / 1e9 * (run->searches - run->searches_done) /
               run->searches_done;
    }
    const struct feed_search *search = feed_search_find(feed, run->id, 0);
    if (search == NULL || search->step == 0 || search->step > search->step_count)
        return -1;
    return (double)run->elapsed_ns / 1e9 * (search->step_count - search->step) / search->step;
}

// ---- Searches ----

static struct feed_search *search_entry(struct feed *feed, uint64_t run, uint32_t index)
{
    struct feed_search *search = table_find(&feed->searches, run, index);
    if (search != NULL)
        return search;
    search = g_new0(struct feed_search, 1);
    search->run = run;
    search->index = index;
    search->bounds = g_array_new(FALSE, FALSE, sizeof(double));
    search->parts = g_array_new(FALSE, FALSE, sizeof(double));
    search->albums = &feed->albums;
    history_init(&search->steps, sizeof(struct feed_step), FEED_STEP_MAX);
    table_add(&feed->searches, &search->entry, run, index);
    return search;
}

// Adds where the search stands to its course: one point a step, the last message of each.
static void step_add(struct feed_search *search)
{
    const struct feed_step step = {
        .step = search->step,
        .phase = search->phase,
        .good_share = search->good_share,
        .log_volume = search->log_volume,
    };
    GArray *points = search->steps.points;
    guint beyond = 0;
    while (beyond < points->len &&
           g_array_index(points, struct feed_step, points->len - 1 - beyond).step > step.step)
        beyond++;
    history_cut(&search->steps, beyond);
    if (points->len > 0 &&
        g_array_index(points, struct feed_step, points->len - 1).step == step.step)
        history_replace(&search->steps, &step);
    else
        history_add(&search->steps, &step);
}

// The box as far as it is heard. One that fits a message is complete at once.
static void bounds_take(struct feed_search *search, const sobox_search_status_t *message)
{
    const guint variables = (guint)message->variables, first = (guint)message->first_variable;
    const guint count = (guint)message->bound_count / 2;
    if (search->parts->len != 2 * variables) {
        g_array_set_size(search->parts, 2 * variables);
        for (guint i = 0; i < search->parts->len; i++)
            g_array_index(search->parts, double, i) = NAN;
        g_array_set_size(search->bounds, 0);
    }
    if (count == 0 || first + count > variables)
        return;
    double *parts = (double *)(void *)search->parts->data;
    memcpy(parts + first, message->bounds, count * sizeof *parts);
    memcpy(parts + variables + first, message->bounds + count, count * sizeof *parts);
    for (guint i = 0; i < variables && count < variables; i++) {
        if (isnan(parts[i]))
            return;
    }
    g_array_set_size(search->bounds, 0);
    g_array_append_vals(search->bounds, parts, 2 * variables);
}

// A search that is over is told of again and again: that is no news.
static bool is_retold(const struct feed_search *before, const struct feed_search *now)
{
    return before->changed != 0 && before->standing == SEARCH_STANDING_DONE &&
           now->standing == SEARCH_STANDING_DONE && before->status == now->status &&
           before->step == now->step && before->evaluations == now->evaluations &&
           digest_equal(&before->scenario, &now->scenario);
}

// Takes over all of a message but its box, which comes before.
static void search_take(struct feed *feed, struct feed_search *search,
                        const sobox_search_status_t *message, guint known, int64_t now_ns)
{
    const struct feed_search before = *search;
    memcpy(search->scenario.bytes, message->scenario, DIGEST_SIZE);
    search->standing = (enum search_standing)message->standing;
    search->phase = (enum search_phase)message->phase;
    search->status = (enum search_status)message->status;
    search->step = (uint32_t)message->step;
    search->step_count = (uint32_t)message->step_count;
    search->evaluations = (uint64_t)message->evaluations;
    search->good_share = message->good_share;
    search->log_volume = message->log_volume;
    search->purity_lower95 = message->purity_lower95;
    search->heard_ns = now_ns;
    table_touch(&feed->searches, &search->entry);
    if (is_retold(&before, search) && known == search->bounds->len)
        return;
    search->changed = ++feed->version;
    step_add(search);
}

void feed_search_heard(struct feed *feed, const sobox_search_status_t *message, int64_t now_ns)
{
    struct feed_search *search =
        search_entry(feed, (uint64_t)message->header.run, (uint32_t)message->search);
    if (is_late(&search->origin, &message->header, now_ns - search->heard_ns))
        return;
    const guint known = search->bounds->len;
    bounds_take(search, message);
    search_take(feed, search, message, known, now_ns);
}

void feed_search_read(struct feed *feed, uint64_t run, const sobox_search_status_t *message,
                      const struct box *box, int64_t now_ns)
{
    struct feed_search *search = search_entry(feed, run, (uint32_t)message->search);
    const guint known = search->bounds->len;
    g_array_set_size(search->bounds, 0);
    g_array_append_vals(search->bounds, box->lower, box->count);
    g_array_append_vals(search->bounds, box->upper, box->count);
    search_take(feed, search, message, known, now_ns);
}

// Samples are kept of the searches heard of last.
static struct album *album_of(struct feed *feed, struct feed_search *search)
{
    if (search->album != NULL) {
        g_queue_unlink(&feed->albums, &search->album_link);
    } else {
        if (feed->albums.length >= FEED_ALBUM_MAX)
            album_end(feed->albums.head->data);
        search->album = g_new(struct album, 1);
        album_init(search->album);
        search->album_link.data = search;
    }
    g_queue_push_tail_link(&feed->albums, &search->album_link);
    return search->album;
}

// What a step tells of a search that nothing else has told of yet: a short one may be over before
// its status is due.
static void search_begin(struct feed_search *search, const sobox_step_status_t *message,
                         int64_t now_ns)
{
    memcpy(search->scenario.bytes, message->scenario, DIGEST_SIZE);
    search->standing = SEARCH_STANDING_OPEN;
    search->phase = (enum search_phase)message->phase;
    search->step = (uint32_t)message->step;
    search->log_volume = -DBL_MAX;
    search->heard_ns = now_ns;
}

void feed_step_heard(struct feed *feed, const sobox_step_status_t *message, int64_t now_ns)
{
    struct feed_search *search =
        search_entry(feed, (uint64_t)message->header.run, (uint32_t)message->search);
    if (is_late(&search->album_origin, &message->header, now_ns - search->album_heard_ns))
        return;
    if (search->origin.sender == 0)
        search_begin(search, message, now_ns);
    search->album_heard_ns = now_ns;
    if (album_hear(album_of(feed, search), message))
        search->album_changed = search->changed = ++feed->version;
}

void feed_step_read(struct feed *feed, uint64_t run, uint32_t index, struct album_picture *picture,
                    int64_t now_ns)
{
    struct feed_search *search = search_entry(feed, run, index);
    search->album_heard_ns = now_ns;
    album_add(album_of(feed, search), picture);
    search->album_changed = search->changed = ++feed->version;
}

void feed_cases_heard(struct feed *feed, const sobox_cases_t *message, int64_t now_ns)
{
    (void)now_ns;
    struct feed_run *run = table_find(&feed->runs, (uint64_t)message->header.run, 0);
    if (run != NULL && cases_hear(&run->names, message, feed->version + 1))
        run->changed = ++feed->version;
}

void feed_case_read(struct feed *feed, uint64_t id, int32_t index, char *const *texts)
{
    struct feed_run *run = table_find(&feed->runs, id, 0);
    if (run != NULL && cases_put(&run->names, index, texts, feed->version + 1))
        run->changed = ++feed->version;
}

// ---- Workers ----

static struct feed_worker *worker_entry(struct feed *feed, uint64_t id)
{
    struct feed_worker *worker = table_find(&feed->workers, id, 0);
    if (worker != NULL)
        return worker;
    worker = g_new0(struct feed_worker, 1);
    table_add(&feed->workers, &worker->entry, id, 0);
    return worker;
}

static void worker_measure(struct feed_worker *worker, const sobox_worker_status_t *message)
{
    const int64_t since_ns = message->uptime_ns - worker->uptime_ns;
    worker->rate =
        rate_between((uint64_t)message->samples, worker->samples, since_ns, worker->rate);
    worker->busy = rate_between((uint64_t)message->busy_ns, (uint64_t)worker->busy_ns, since_ns,
                                worker->busy * 1e9) /
                   1e9;
    if (worker->changed == 0)
        return;
    recent_add(&worker->recent, since_ns, grown((uint64_t)message->batches, worker->batches),
               grown((uint64_t)message->lost, worker->lost), 0);
    const bool idle = message->queue == 0 && (uint64_t)message->batches == worker->batches;
    worker->idle = idle ? worker->idle + 1 : 0;
}

void feed_worker_heard(struct feed *feed, const sobox_worker_status_t *message, int64_t now_ns)
{
    struct feed_worker *worker = worker_entry(feed, (uint64_t)message->header.sender);
    if (is_late(&worker->origin, &message->header, now_ns - worker->heard_ns))
        return;
    worker_measure(worker, message);
    char host[64];
    text_copy(host, sizeof host, message->host);
    g_snprintf(worker->name, sizeof worker->name, "%s/%d", host, message->process);
    memcpy(worker->fingerprint.bytes, message->fingerprint, DIGEST_SIZE);
    worker->threads = (uint32_t)message->threads;
    worker->queue = (uint32_t)message->queue;
    worker->batches = (uint64_t)message->batches;
    worker->samples = (uint64_t)message->samples;
    worker->busy_ns = message->busy_ns;
    worker->uptime_ns = message->uptime_ns;
    worker->lost = (uint64_t)message->lost;
    worker->dropped = (uint64_t)message->dropped;
    worker->buffer_size = (uint32_t)message->buffer_size;
    worker->left = message->leaving != 0;
    worker->heard_ns = now_ns;
    worker->silence_ns = FEED_SILENCE_NS * pace_most(feed->workers.entries->len);
    worker->changed = ++feed->version;
    table_touch(&feed->workers, &worker->entry);
}

void feed_tick(struct feed *feed, int64_t now_ns)
{
    for (guint i = feed->workers.entries->len; i-- > 0;) {
        struct feed_worker *worker = feed->workers.entries->pdata[i];
        const int64_t silent_ns = now_ns - worker->heard_ns;
        if (silent_ns > FEED_FORGET_NS || (worker->left && silent_ns > FEED_LEFT_NS)) {
            table_remove(&feed->workers, &worker->entry);
            feed->version++;
        }
    }
}

void feed_own_counted(struct feed *feed, const struct feed_own *own, int64_t now_ns)
{
    if (feed->own_ns != 0)
        recent_add(&feed->own_recent, now_ns - feed->own_ns,
                   grown(own->received, feed->own.received), grown(own->lost, feed->own.lost), 0);
    feed->own = *own;
    feed->own_ns = now_ns;
}

// ---- Reading ----

const struct feed_run *feed_run_find(const struct feed *feed, uint64_t run)
{
    return table_find(&feed->runs, run, 0);
}

const struct feed_search *feed_search_find(const struct feed *feed, uint64_t run, uint32_t index)
{
    return table_find(&feed->searches, run, index);
}

const struct feed_run *feed_run_at(const struct feed *feed, guint i)
{
    return feed->runs.entries->pdata[i];
}

const struct feed_search *feed_search_at(const struct feed *feed, guint i)
{
    return feed->searches.entries->pdata[i];
}

const struct feed_worker *feed_worker_at(const struct feed *feed, guint i)
{
    return feed->workers.entries->pdata[i];
}

const char *feed_search_word(const struct feed_search *search)
{
    switch (search->standing) {
    case SEARCH_STANDING_WAITING:
        return "waiting";
    case SEARCH_STANDING_FAILED:
        return "failed";
    default:
        return protocol_status_name(search->status);
    }
}

const char *feed_case_name(const struct feed *feed, uint64_t run, uint32_t search)
{
    const struct feed_run *found = feed_run_find(feed, run);
    char *const *texts = found != NULL ? cases_find(&found->names, search) : NULL;
    return texts != NULL ? texts[0] : NULL;
}
