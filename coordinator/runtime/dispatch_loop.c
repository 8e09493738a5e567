#include "coordinator/runtime/dispatch_loop.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/source.h"
#include "coordinator/runtime/deadline.h"
#include "worker/batch/fingerprint.h"

#include "sobox_text_request_t.h"
#include "sobox_text_t.h"
#include "sobox_worker_status_t.h"

#include <assert.h>
#include <glib-unix.h>
#include <string.h>

enum {
    STATUS_INTERVAL_MS = 1000,
    // A signal to the whole process group (Ctrl-C, scancel, systemctl stop) may end the local
    // workers before it reaches the coordinator, which then is interrupted and not abandoned. One
    // process hears it some milliseconds after another; on a busy machine it may be a hundred.
    ABANDONED_WAIT_MS = 1000,
};

// Nobody has answered for so long: say what is being waited for.
static const int64_t WAIT_NOTE_NS = CLOCK_SECOND_NS;

struct dispatch_loop {
    struct wire *wire;
    uint64_t run;
    const struct coordinator_settings *settings;
    const struct dispatch_loop_calls *calls;
    void *user;
    struct digest fingerprint;
    struct dispatcher *dispatcher;
    GMainLoop *main;
    struct deadline *wake; // of the dispatcher
    int64_t waiting_ns;    // since when no worker is there; 0 while there is one
    bool wait_said;
    guint abandoned;       // a timer, once all local workers have ended; 0 before
    const char *directory; // of the run, for messages
    bool stopped;
    enum status status; // why the loop ended
    struct error *error;
};

void dispatch_loop_stop(struct dispatch_loop *loop, enum status status)
{
    if (loop->status == STATUS_OK)
        loop->status = status;
    loop->stopped = true;
    g_main_loop_quit(loop->main);
}

// ---- What the dispatcher asks ----

static void send(void *user, uint64_t worker, const struct batch_identity *batch)
{
    const struct dispatch_loop *loop = user;
    loop->calls->send(loop->user, worker, batch);
}

static void count(void *user, const struct batch_identity *batch)
{
    const struct dispatch_loop *loop = user;
    loop->calls->count(loop->user, batch);
}

static void finished(void *user, uint32_t search, uint32_t step)
{
    const struct dispatch_loop *loop = user;
    loop->calls->finished(loop->user, search, step);
}

static void publish_piece(void *user, const struct text_piece *piece)
{
    struct dispatch_loop *loop = user;
    sobox_text_t message = {
        .header.run = (int64_t)loop->run,
        .total_size = (int32_t)piece->total,
        .offset = (int32_t)piece->offset,
        .piece_size = (int32_t)piece->size,
        .piece = (uint8_t *)piece->bytes,
    };
    memcpy(message.digest, piece->digest.bytes, DIGEST_SIZE);
    (void)!wire_publish(loop->wire, WIRE_TEXT, &message); // lost: the worker asks again
}

static void note(void *user, const char *text)
{
    (void)user;
    log_note("%s", text);
}

// ---- What the dispatcher hears ----

static void take(struct dispatch_loop *loop, struct schedule_event *event)
{
    event->now_ns = clock_monotonic_ns();
    dispatcher_take(loop->dispatcher, event);
    deadline_set(loop->wake, dispatcher_wake_ns(loop->dispatcher));
}

void dispatch_loop_step(struct dispatch_loop *loop, uint32_t search, uint32_t step,
                        uint32_t samples, enum verdict_detail detail)
{
    take(loop, &(struct schedule_event){
                   .kind = SCHEDULE_EVENT_STEP,
                   .step = {.search = search, .step = step, .samples = samples, .detail = detail}});
}

void dispatch_loop_outcome(struct dispatch_loop *loop, uint64_t worker,
                           const struct batch_identity *batch, uint32_t queue, int64_t service_ns)
{
    take(loop, &(struct schedule_event){.kind = SCHEDULE_EVENT_OUTCOME,
                                        .outcome = {.worker = worker,
                                                    .batch = *batch,
                                                    .queue = queue,
                                                    .service_ns = service_ns}});
}

void dispatch_loop_counters(const struct dispatch_loop *loop, struct schedule_counters *counters)
{
    dispatcher_counters(loop->dispatcher, counters);
}

struct text_server *dispatch_loop_texts(struct dispatch_loop *loop)
{
    return dispatcher_texts(loop->dispatcher);
}

// ---- What is heard ----

static void heard_worker(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct dispatch_loop *loop = user;
    const sobox_worker_status_t *message = bytes;
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_WORKER,
        .worker = {
            .id = (uint64_t)message->header.sender,
            .threads = (uint32_t)message->threads,
            .queue = (uint32_t)message->queue,
            .leaving = message->leaving != 0,
            .acceptable = memcmp(message->fingerprint, loop->fingerprint.bytes, DIGEST_SIZE) == 0,
        }};
    g_snprintf(event.worker.name, sizeof event.worker.name, "%.63s/%d", (const char *)message->host,
               message->process);
    take(loop, &event);
    if (loop->calls->room != NULL)
        loop->calls->room(loop->user);
}

static void heard_text_request(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct dispatch_loop *loop = user;
    const sobox_text_request_t *message = bytes;
    if ((uint64_t)message->header.run != loop->run)
        return;
    struct digest digest;
    memcpy(digest.bytes, message->digest, DIGEST_SIZE);
    dispatcher_request(loop->dispatcher, &digest, (size_t)message->offset, clock_monotonic_ns());
}

// ---- Timers and signals ----

static void woken(void *user)
{
    take(user, &(struct schedule_event){.kind = SCHEDULE_EVENT_TICK});
}

// Says for what it waits when no worker is there, once per wait.
static void look_for_workers(struct dispatch_loop *loop, uint32_t workers)
{
    const int64_t now_ns = clock_monotonic_ns();
    if (workers > 0) {
        loop->waiting_ns = 0;
        loop->wait_said = false;
        return;
    }
    if (loop->waiting_ns == 0)
        loop->waiting_ns = now_ns;
    if (loop->wait_said || now_ns - loop->waiting_ns < WAIT_NOTE_NS)
        return;
    loop->wait_said = true;
    if (loop->settings->open)
        log_note("waiting for a worker: start one on this or another machine with "
                 "'sobox-worker --url \"%s\"'",
                 loop->settings->url);
    else
        log_note("waiting for the local workers to answer");
}

static gboolean tell_status(gpointer user)
{
    struct dispatch_loop *loop = user;
    struct schedule_counters counters;
    dispatcher_counters(loop->dispatcher, &counters);
    look_for_workers(loop, counters.workers);
    loop->calls->status(loop->user, &counters, counters.workers == 0);
    return G_SOURCE_CONTINUE;
}

static void end(struct dispatch_loop *loop, enum status status, const char *why)
{
    if (loop->status == STATUS_OK)
        dispatch_loop_stop(loop, error_set(loop->error, status,
                                           "%s; continue with 'sobox-coordinator --resume %s'", why,
                                           loop->directory));
}

static gboolean interrupted(gpointer user)
{
    end(user, STATUS_INTERRUPTED, "interrupted");
    return G_SOURCE_CONTINUE;
}

static gboolean give_up(gpointer user)
{
    struct dispatch_loop *loop = user;
    loop->abandoned = 0;
    end(loop, STATUS_FAILED, "all local workers have ended");
    return G_SOURCE_REMOVE;
}

static void child_ended(void *user, uint32_t alive)
{
    struct dispatch_loop *loop = user;
    if (alive == 0 && !loop->settings->open && loop->abandoned == 0)
        loop->abandoned = g_timeout_add(ABANDONED_WAIT_MS, give_up, loop);
}

// ---- Life ----

static enum status subscribe(struct dispatch_loop *loop, struct error *error)
{
    enum status status =
        wire_subscribe(loop->wire, WIRE_TEXT_REQUEST, heard_text_request, loop, error);
    if (status == STATUS_OK)
        status = wire_subscribe(loop->wire, WIRE_WORKER_STATUS, heard_worker, loop, error);
    wire_source_attach(loop->wire);
    return status;
}

enum status dispatch_loop_create(struct dispatch_loop **created, struct wire *wire, uint64_t run,
                                 const struct coordinator_settings *settings,
                                 const struct schedule_settings *schedule,
                                 const struct dispatch_loop_calls *calls, void *user,
                                 struct error *error)
{
    static const struct dispatcher_calls dispatcher_calls = {
        .send = send,
        .count = count,
        .finished = finished,
        .piece = publish_piece,
        .note = note,
    };
    struct dispatch_loop *loop = g_new(struct dispatch_loop, 1);
    *loop = (struct dispatch_loop){
        .wire = wire,
        .run = run,
        .settings = settings,
        .calls = calls,
        .user = user,
        .fingerprint = fingerprint_compute(),
        .dispatcher =
            dispatcher_create(schedule, wire_payload_max(wire, WIRE_TEXT), &dispatcher_calls, loop),
        .main = g_main_loop_new(NULL, FALSE),
    };
    loop->wake = deadline_create(woken, loop);
    assert(loop->wake != NULL);
    if (settings->children != NULL)
        children_watch(settings->children, child_ended, loop);
    const enum status status = subscribe(loop, error);
    if (status != STATUS_OK) {
        dispatch_loop_free(loop);
        loop = NULL;
    }
    *created = loop;
    return status;
}

void dispatch_loop_free(struct dispatch_loop *loop)
{
    if (loop == NULL)
        return;
    wire_source_detach(loop->wire);
    g_main_loop_unref(loop->main);
    deadline_free(loop->wake);
    dispatcher_free(loop->dispatcher);
    g_free(loop);
}

enum status dispatch_loop_run(struct dispatch_loop *loop, const char *directory,
                              struct error *error)
{
    loop->directory = directory;
    loop->error = error;
    const guint sources[] = {
        g_timeout_add(STATUS_INTERVAL_MS, tell_status, loop),
        g_unix_signal_add(SIGINT, interrupted, loop),
        g_unix_signal_add(SIGTERM, interrupted, loop),
    };
    struct schedule_counters counters;
    dispatcher_counters(loop->dispatcher, &counters);
    loop->calls->status(loop->user, &counters, false);
    if (!loop->stopped)
        g_main_loop_run(loop->main);
    if (loop->abandoned != 0)
        g_source_remove(loop->abandoned);
    for (size_t i = 0; i < G_N_ELEMENTS(sources); i++)
        g_source_remove(sources[i]);
    return loop->status;
}
