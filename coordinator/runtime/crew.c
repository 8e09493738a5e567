#include "coordinator/runtime/crew.h"

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
    TEXT_PIECES_MAX = 64, // answered to one request; the worker asks on from there
    // A signal to the whole process group (Ctrl-C, scancel, systemctl stop) may end the local
    // workers before it reaches the coordinator, which then is interrupted and not abandoned. One
    // process hears it some milliseconds after another; on a busy machine it may be a hundred.
    ABANDONED_WAIT_MS = 1000,
};

// Nobody has answered for so long: say what is being waited for.
static const int64_t WAIT_NOTE_NS = CLOCK_SECOND_NS;
// The same text is not sent again within this time: what one worker asked for, all hear.
static const int64_t TEXT_REPEAT_NS = 20 * CLOCK_MILLISECOND_NS;

struct crew {
    struct wire *wire;
    uint64_t run;
    const struct coordinator_settings *settings;
    const struct crew_calls *calls;
    void *user;
    struct digest fingerprint;
    struct schedule *schedule;
    struct schedule_effects effects;
    struct texts *texts;
    GArray *finished; // steps (search, step) that wait to be told of
    GMainLoop *loop;
    struct deadline *wake; // of the schedule
    int64_t waiting_ns;    // since when no worker is there; 0 while there is one
    bool wait_said;
    guint abandoned;       // a timer, once all local workers have ended; 0 before
    const char *directory; // of the run, for messages
    bool stopped;
    enum status status; // why the loop ended
    struct error *error;
};

struct step {
    uint32_t search;
    uint32_t step;
};

void crew_stop(struct crew *crew, enum status status)
{
    if (crew->status == STATUS_OK)
        crew->status = status;
    crew->stopped = true;
    g_main_loop_quit(crew->loop);
}

// ---- The schedule ----

static void carry_out(struct crew *crew)
{
    const struct schedule_effects *effects = &crew->effects;
    for (size_t i = 0; i < effects->count; i++) {
        const struct schedule_effect *effect = &effects->items[i];
        switch (effect->kind) {
        case SCHEDULE_EFFECT_SEND:
            crew->calls->send(crew->user, effect->send.worker, &effect->send.batch);
            break;
        case SCHEDULE_EFFECT_COUNT:
            crew->calls->count(crew->user, &effect->count.batch);
            break;
        case SCHEDULE_EFFECT_STEP: {
            const struct step step = {effect->step.search, effect->step.step};
            g_array_append_val(crew->finished, step);
            break;
        }
        case SCHEDULE_EFFECT_NOTE:
            log_note("%s", effect->note);
            break;
        }
    }
    deadline_set(crew->wake, effects->wake_ns);
}

static void schedule_take(struct crew *crew, struct schedule_event *event)
{
    event->now_ns = clock_monotonic_ns();
    schedule_step(crew->schedule, event, &crew->effects);
    carry_out(crew);
}

// Only after the effects are carried out, because who is told will most likely ask for more.
static void tell_finished(struct crew *crew)
{
    for (guint i = 0; i < crew->finished->len; i++) {
        const struct step step = g_array_index(crew->finished, struct step, i);
        crew->calls->finished(crew->user, step.search, step.step);
    }
    g_array_set_size(crew->finished, 0);
}

void crew_step(struct crew *crew, uint32_t search, uint32_t step, uint32_t samples,
               enum verdict_detail detail)
{
    schedule_take(
        crew, &(struct schedule_event){
                  .kind = SCHEDULE_EVENT_STEP,
                  .step = {.search = search, .step = step, .samples = samples, .detail = detail}});
}

void crew_outcome(struct crew *crew, uint64_t worker, const struct batch_identity *batch,
                  uint32_t queue, int64_t service_ns)
{
    schedule_take(crew, &(struct schedule_event){.kind = SCHEDULE_EVENT_OUTCOME,
                                                 .outcome = {.worker = worker,
                                                             .batch = *batch,
                                                             .queue = queue,
                                                             .service_ns = service_ns}});
    tell_finished(crew);
}

void crew_counters(const struct crew *crew, struct schedule_counters *counters)
{
    schedule_counters(crew->schedule, counters);
}

struct texts *crew_texts(struct crew *crew)
{
    return crew->texts;
}

// ---- What is heard ----

static void heard_worker(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct crew *crew = user;
    const sobox_worker_status_t *message = bytes;
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_WORKER,
        .worker = {
            .id = (uint64_t)message->header.sender,
            .threads = (uint32_t)message->threads,
            .queue = (uint32_t)message->queue,
            .leaving = message->leaving != 0,
            .acceptable = memcmp(message->fingerprint, crew->fingerprint.bytes, DIGEST_SIZE) == 0,
        }};
    g_snprintf(event.worker.name, sizeof event.worker.name, "%.63s/%d", (const char *)message->host,
               message->process);
    schedule_take(crew, &event);
    if (crew->calls->room != NULL)
        crew->calls->room(crew->user);
}

static void heard_text_request(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct crew *crew = user;
    const sobox_text_request_t *message = bytes;
    if ((uint64_t)message->header.run != crew->run)
        return;
    struct digest digest;
    memcpy(digest.bytes, message->digest, DIGEST_SIZE);
    size_t total = 0, offset = (size_t)message->offset;
    const uint8_t *text =
        texts_ask(crew->texts, &digest, offset, clock_monotonic_ns(), TEXT_REPEAT_NS, &total);
    if (text == NULL)
        return;
    const size_t piece_max = wire_payload_max(crew->wire, WIRE_TEXT);
    for (int piece = 0; piece < TEXT_PIECES_MAX && offset < total; piece++) {
        const size_t size = MIN(piece_max, total - offset);
        sobox_text_t answer = {
            .header.run = message->header.run,
            .total_size = (int32_t)total,
            .offset = (int32_t)offset,
            .piece_size = (int32_t)size,
            .piece = (uint8_t *)text + offset,
        };
        memcpy(answer.digest, digest.bytes, DIGEST_SIZE);
        (void)!wire_publish(crew->wire, WIRE_TEXT, &answer);
        offset += size;
    }
}

// ---- Timers and signals ----

static void woken(void *user)
{
    schedule_take(user, &(struct schedule_event){.kind = SCHEDULE_EVENT_TICK});
}

// Says for what it waits when no worker is there, once per wait.
static void look_for_workers(struct crew *crew, uint32_t workers)
{
    const int64_t now_ns = clock_monotonic_ns();
    if (workers > 0) {
        crew->waiting_ns = 0;
        crew->wait_said = false;
        return;
    }
    if (crew->waiting_ns == 0)
        crew->waiting_ns = now_ns;
    if (crew->wait_said || now_ns - crew->waiting_ns < WAIT_NOTE_NS)
        return;
    crew->wait_said = true;
    if (crew->settings->open)
        log_note("waiting for a worker: start one on this or another machine with "
                 "'sobox-worker --url \"%s\"'",
                 crew->settings->url);
    else
        log_note("waiting for the local workers to answer");
}

static gboolean tell_status(gpointer user)
{
    struct crew *crew = user;
    struct schedule_counters counters;
    schedule_counters(crew->schedule, &counters);
    look_for_workers(crew, counters.workers);
    crew->calls->status(crew->user, &counters, counters.workers == 0);
    return G_SOURCE_CONTINUE;
}

static void end(struct crew *crew, enum status status, const char *why)
{
    if (crew->status == STATUS_OK)
        crew_stop(crew, error_set(crew->error, status,
                                  "%s; continue with 'sobox-coordinator --resume %s'", why,
                                  crew->directory));
}

static gboolean interrupted(gpointer user)
{
    end(user, STATUS_INTERRUPTED, "interrupted");
    return G_SOURCE_CONTINUE;
}

static gboolean give_up(gpointer user)
{
    struct crew *crew = user;
    crew->abandoned = 0;
    end(crew, STATUS_FAILED, "all local workers have ended");
    return G_SOURCE_REMOVE;
}

static void child_ended(void *user, uint32_t alive)
{
    struct crew *crew = user;
    if (alive == 0 && !crew->settings->open && crew->abandoned == 0)
        crew->abandoned = g_timeout_add(ABANDONED_WAIT_MS, give_up, crew);
}

// ---- Life ----

static enum status subscribe(struct crew *crew, struct error *error)
{
    enum status status =
        wire_subscribe(crew->wire, WIRE_TEXT_REQUEST, heard_text_request, crew, error);
    if (status == STATUS_OK)
        status = wire_subscribe(crew->wire, WIRE_WORKER_STATUS, heard_worker, crew, error);
    wire_source_attach(crew->wire);
    return status;
}

enum status crew_create(struct crew **created, struct wire *wire, uint64_t run,
                        const struct coordinator_settings *settings,
                        const struct schedule_settings *schedule, const struct crew_calls *calls,
                        void *user, struct error *error)
{
    struct crew *crew = g_new0(struct crew, 1);
    *crew = (struct crew){
        .wire = wire,
        .run = run,
        .settings = settings,
        .calls = calls,
        .user = user,
        .fingerprint = fingerprint_compute(),
        .schedule = schedule_create(schedule),
        .texts = texts_create(),
        .finished = g_array_new(FALSE, FALSE, sizeof(struct step)),
        .loop = g_main_loop_new(NULL, FALSE),
    };
    crew->wake = deadline_create(woken, crew);
    assert(crew->wake != NULL);
    if (settings->children != NULL)
        children_watch(settings->children, child_ended, crew);
    const enum status status = subscribe(crew, error);
    if (status != STATUS_OK) {
        crew_free(crew);
        crew = NULL;
    }
    *created = crew;
    return status;
}

void crew_free(struct crew *crew)
{
    if (crew == NULL)
        return;
    wire_source_detach(crew->wire);
    g_main_loop_unref(crew->loop);
    g_array_unref(crew->finished);
    deadline_free(crew->wake);
    schedule_effects_fini(&crew->effects);
    schedule_free(crew->schedule);
    texts_free(crew->texts);
    g_free(crew);
}

enum status crew_run(struct crew *crew, const char *directory, struct error *error)
{
    crew->directory = directory;
    crew->error = error;
    const guint sources[] = {
        g_timeout_add(STATUS_INTERVAL_MS, tell_status, crew),
        g_unix_signal_add(SIGINT, interrupted, crew),
        g_unix_signal_add(SIGTERM, interrupted, crew),
    };
    struct schedule_counters counters;
    schedule_counters(crew->schedule, &counters);
    crew->calls->status(crew->user, &counters, false);
    if (!crew->stopped)
        g_main_loop_run(crew->loop);
    if (crew->abandoned != 0)
        g_source_remove(crew->abandoned);
    for (size_t i = 0; i < G_N_ELEMENTS(sources); i++)
        g_source_remove(sources[i]);
    return crew->status;
}
