#include "coordinator/runtime/coordinator.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/source.h"
#include "coordinator/runtime/deadline.h"
#include "coordinator/runtime/opening.h"
#include "coordinator/runtime/pool.h"
#include "coordinator/runtime/progress.h"
#include "coordinator/runtime/tell.h"
#include "coordinator/runtime/texts.h"
#include "coordinator/schedule/schedule.h"
#include "worker/batch/fingerprint.h"
#include "worker/batch/intake.h"

#include "sobox_outcome_batch_t.h"
#include "sobox_sample_batch_t.h"
#include "sobox_text_request_t.h"
#include "sobox_text_t.h"
#include "sobox_worker_status_t.h"

#include <assert.h>
#include <glib-unix.h>
#include <glib.h>
#include <string.h>

enum {
    OUTCOME_SAMPLES_MAX = 65536, // of one message, as outcome_batch_t.lcm says
    STATUS_INTERVAL_MS = 1000,
    TEXT_PIECES_MAX = 64, // answered to one request; the worker asks on from there
    // A signal to the whole process group (Ctrl-C, scancel, systemctl stop) may end the local
    // workers before it reaches the coordinator, which then is interrupted and not abandoned. One
    // process hears it some milliseconds after another; on a busy machine it may be a hundred.
    ABANDONED_WAIT_MS = 1000,
};

_Static_assert((int)OPENING_MAX < (int)INTAKE_SCENARIO_MAX, "workers must keep all open scenarios");

// Nobody has answered for so long: say what is being waited for.
static const int64_t WAIT_NOTE_NS = CLOCK_SECOND_NS;
// The same text is not sent again within this time: what one worker asked for, all hear.
static const int64_t TEXT_REPEAT_NS = 20 * CLOCK_MILLISECOND_NS;

struct coordinator {
    struct run *run;
    struct wire *wire;
    uint64_t sender;
    const struct coordinator_settings *settings;
    struct digest fingerprint;
    struct schedule *schedule;
    struct schedule_effects effects;
    struct texts *texts;
    struct verdict *unpacked; // (OUTCOME_SAMPLES_MAX) of the outcome being looked at
    struct progress progress;
    GQueue ready; // indexes of open searches whose step is sampled, or that have just been opened
    struct opening opening;
    struct tell *tell;
    struct pool *trimmer; // NULL in a run of one search, which trims where it stands
    GSource *opener;      // runs once to see whether another search may be opened
    GMainLoop *loop;
    struct deadline *wake; // of the schedule
    int64_t waiting_ns;    // since when no worker is there; 0 while there is one
    bool wait_said;
    guint abandoned;    // a timer, once all local workers have ended; 0 before
    enum status status; // why the loop ended
    struct error *error;
};

// Ends the main loop. The first reason stands.
static void stop(struct coordinator *coordinator, enum status status)
{
    if (coordinator->status == STATUS_OK)
        coordinator->status = status;
    g_main_loop_quit(coordinator->loop);
}

// ---- Effects of the schedule ----

static void send_batch(struct coordinator *coordinator, uint64_t worker,
                       const struct schedule_batch *batch)
{
    const struct run_search *search = coordinator->run->open[batch->search];
    const struct search_request *request = &search->request;
    const uint32_t variables = search->scenario.design_space.count;
    sobox_sample_batch_t message = {
        .header.run = (int64_t)coordinator->run->record.id,
        .holder = (int64_t)worker,
        .seed = (int64_t)request->sampling.seed,
        .search = (int32_t)batch->search,
        .step = (int32_t)batch->step,
        .batch = (int32_t)batch->batch,
        .attempt = (int32_t)batch->attempt,
        .first = (int32_t)batch->first,
        .count = (int32_t)batch->count,
        .step_samples = (int32_t)request->sampling.samples,
        .sampling = (int8_t)request->sampling.method,
        .detail = (int8_t)request->detail,
    };
    memcpy(message.scenario, search->scenario.digest.bytes, DIGEST_SIZE);
    memcpy(message.box, search->box.bytes, DIGEST_SIZE);
    const size_t bounds_size = 2 * (size_t)variables * sizeof(double);
    if (bounds_size <= wire_payload_max(coordinator->wire, WIRE_SAMPLE_BATCH)) {
        message.bound_count = (int32_t)(2 * variables);
        message.bounds = search->bounds;
    }
    // A message that LCM cannot send is a message lost: the lease brings the batch back.
    (void)!wire_publish(coordinator->wire, WIRE_SAMPLE_BATCH, &message);
}

static void carry_out(struct coordinator *coordinator)
{
    const struct schedule_effects *effects = &coordinator->effects;
    for (size_t i = 0; i < effects->count; i++) {
        const struct schedule_effect *effect = &effects->items[i];
        switch (effect->kind) {
        case SCHEDULE_EFFECT_SEND:
            send_batch(coordinator, effect->send.worker, &effect->send.batch);
            break;
        case SCHEDULE_EFFECT_COUNT: {
            const struct schedule_batch *batch = &effect->count.batch;
            memcpy(coordinator->run->open[batch->search]->verdicts + batch->first,
                   coordinator->unpacked, batch->count * sizeof(struct verdict));
            break;
        }
        case SCHEDULE_EFFECT_STEP:
            g_queue_push_tail(&coordinator->ready, GUINT_TO_POINTER(effect->step.search));
            break;
        case SCHEDULE_EFFECT_NOTE:
            log_note("%s", effect->note);
            break;
        }
    }
    deadline_set(coordinator->wake, effects->wake_ns);
}

static void schedule_take(struct coordinator *coordinator, struct schedule_event *event)
{
    event->now_ns = clock_monotonic_ns();
    schedule_step(coordinator->schedule, event, &coordinator->effects);
    carry_out(coordinator);
}

static void tell_run_state(struct coordinator *coordinator, enum tell_state state)
{
    struct schedule_counters counters;
    schedule_counters(coordinator->schedule, &counters);
    tell_run(coordinator->tell, state, &counters);
}

// ---- Searches ----

// The search is done and leaves: what it held is released.
static void leave(struct coordinator *coordinator, uint32_t index)
{
    const struct scenario *scenario = &coordinator->run->open[index]->scenario;
    tell_end(coordinator->tell, coordinator->run->open[index]);
    texts_remove(coordinator->texts, &scenario->digest);
    opening_close(&coordinator->opening, scenario);
    run_close(coordinator->run, index);
    g_source_set_ready_time(coordinator->opener, 0);
}

// Asks a search for its next step and hands that to the schedule.
static enum status go_on(struct coordinator *coordinator, uint32_t index)
{
    struct run *run = coordinator->run;
    const struct run_search *search = run->open[index];
    bool wanted = false;
    enum status status = run_next(run, index, clock_monotonic_ns(), &wanted, coordinator->error);
    if (status != STATUS_OK)
        return status;
    if (!wanted) {
        leave(coordinator, index);
        return STATUS_OK;
    }
    texts_add(coordinator->texts, &search->box, search->bounds,
              2 * (size_t)search->scenario.design_space.count * sizeof(double));
    schedule_take(coordinator, &(struct schedule_event){
                                   .kind = SCHEDULE_EVENT_STEP,
                                   .step = {
                                       .search = index,
                                       .step = search->request.sampling.step,
                                       .samples = search->request.sampling.samples,
                                       .share_only = search->request.detail == VERDICT_DETAIL_SHARE,
                                   }});
    return STATUS_OK;
}

// The step that was trimmed goes into the journal, and then to those who watch.
static enum status record(struct coordinator *coordinator, struct run_search *search)
{
    const enum status status = run_record(coordinator->run, search->index, coordinator->error);
    if (status == STATUS_OK)
        tell_step(coordinator->tell, search, clock_monotonic_ns());
    return status;
}

// Moves every search that can move: those that were just opened ask for their first step, those
// whose step is sampled are trimmed, here or in other threads.
static enum status advance(struct coordinator *coordinator)
{
    struct run *run = coordinator->run;
    while (!g_queue_is_empty(&coordinator->ready)) {
        const uint32_t index = GPOINTER_TO_UINT(g_queue_pop_head(&coordinator->ready));
        struct run_search *search = run->open[index];
        enum status status = STATUS_OK;
        if (search->active) {
            texts_remove(coordinator->texts, &search->box);
            search->active = false;
            if (coordinator->trimmer != NULL) {
                pool_take(coordinator->trimmer, search);
                continue;
            }
            run_trim(search);
            status = record(coordinator, search);
        }
        if (status == STATUS_OK)
            status = go_on(coordinator, index);
        if (status != STATUS_OK)
            return status;
    }
    return STATUS_OK;
}

static void advance_or_stop(struct coordinator *coordinator)
{
    enum status status = advance(coordinator);
    if (status != STATUS_OK || run_finished(coordinator->run))
        stop(coordinator, status);
}

// Steps that other threads have trimmed. They are written as one, and only then go on: what has
// been told to anybody is in the journal.
static enum status take_trimmed(struct coordinator *coordinator, GPtrArray *searches)
{
    struct run *run = coordinator->run;
    enum status status =
        searches->len > 1 ? journal_begin(run->journal, coordinator->error) : STATUS_OK;
    for (guint i = 0; i < searches->len && status == STATUS_OK; i++) {
        status = record(coordinator, searches->pdata[i]);
    }
    struct error uncommitted = {0};
    if (journal_commit(run->journal, &uncommitted) != STATUS_OK && status == STATUS_OK) {
        *coordinator->error = uncommitted;
        status = uncommitted.status;
    }
    for (guint i = 0; i < searches->len && status == STATUS_OK; i++)
        status = go_on(coordinator, ((const struct run_search *)searches->pdata[i])->index);
    return status;
}

static void trim(void *search)
{
    run_trim(search);
}

static void heard_trimmed(void *user, GPtrArray *searches)
{
    struct coordinator *coordinator = user;
    enum status status = take_trimmed(coordinator, searches);
    if (status != STATUS_OK)
        stop(coordinator, status);
    else
        advance_or_stop(coordinator);
    g_source_set_ready_time(coordinator->opener, 0);
}

// Whether another search should be open.
static bool room_for_search(const struct coordinator *coordinator)
{
    struct schedule_counters counters;
    schedule_counters(coordinator->schedule, &counters);
    const double trims =
        coordinator->trimmer != NULL ? pool_load(coordinator->trimmer) : OPENING_TRIMS_MAX;
    return opening_wanted(&coordinator->opening, &counters, trims);
}

// Opens one search at most, so that messages are heard between two of them.
static enum status open_search(struct coordinator *coordinator)
{
    struct run *run = coordinator->run;
    uint32_t index;
    if (!room_for_search(coordinator) || !run_waiting(run, &index))
        return STATUS_OK;
    g_source_set_ready_time(coordinator->opener, 0);
    struct error reason = {0};
    enum status status = run_open(run, index, clock_monotonic_ns(), &reason);
    if (status != STATUS_OK) {
        if (run->record.search_count == 1 || status == STATUS_IO)
            return error_set(coordinator->error, status, "%s", reason.text);
        log_error("%s", reason.text);
        return STATUS_OK;
    }
    const struct scenario *scenario = &run->open[index]->scenario;
    opening_open(&coordinator->opening, scenario);
    texts_add(coordinator->texts, &scenario->digest, scenario->text, scenario->text_size);
    g_queue_push_tail(&coordinator->ready, GUINT_TO_POINTER(index));
    return STATUS_OK;
}

static void open_when_hungry(struct coordinator *coordinator)
{
    uint32_t index;
    if (run_waiting(coordinator->run, &index) && room_for_search(coordinator))
        g_source_set_ready_time(coordinator->opener, 0);
}

static gboolean opening(gpointer user)
{
    struct coordinator *coordinator = user;
    enum status status = open_search(coordinator);
    if (status != STATUS_OK)
        stop(coordinator, status);
    else
        advance_or_stop(coordinator);
    return G_SOURCE_CONTINUE;
}

// ---- Messages ----

static bool ours(const struct coordinator *coordinator, const sobox_header_t *header)
{
    return (uint64_t)header->run == coordinator->run->record.id;
}

static void heard_outcome(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct coordinator *coordinator = user;
    const sobox_outcome_batch_t *message = bytes;
    if (!ours(coordinator, &message->header) || message->search < 0 ||
        (uint32_t)message->search >= coordinator->run->record.search_count ||
        message->count > OUTCOME_SAMPLES_MAX)
        return;
    const struct run_search *search = coordinator->run->open[message->search];
    // Only the step being sampled can count; an outcome of an earlier one is unpacked by no one.
    if (search != NULL && search->active &&
        (uint32_t)message->step == search->request.sampling.step &&
        (message->detail != (int8_t)search->request.detail ||
         !verdict_unpack(coordinator->unpacked, (uint32_t)message->count, search->request.detail,
                         search->scenario.constraint_count, message->packed,
                         (size_t)message->packed_size))) {
        log_debug("an outcome of step %d does not unpack", message->step);
        return;
    }
    schedule_take(coordinator,
                  &(struct schedule_event){.kind = SCHEDULE_EVENT_OUTCOME,
                                           .outcome = {
                                               .worker = (uint64_t)message->header.sender,
                                               .batch =
                                                   {
                                                       .search = (uint32_t)message->search,
                                                       .step = (uint32_t)message->step,
                                                       .batch = (uint32_t)message->batch,
                                                       .attempt = (uint32_t)message->attempt,
                                                       .first = (uint32_t)message->first,
                                                       .count = (uint32_t)message->count,
                                                   },
                                               .queue = (uint32_t)message->queue,
                                               .service_ns = message->service_ns,
                                           }});
    advance_or_stop(coordinator);
    open_when_hungry(coordinator);
}

static void heard_worker(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct coordinator *coordinator = user;
    const sobox_worker_status_t *message = bytes;
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_WORKER,
        .worker = {
            .id = (uint64_t)message->header.sender,
            .threads = (uint32_t)message->threads,
            .queue = (uint32_t)message->queue,
            .leaving = message->leaving != 0,
            .acceptable =
                memcmp(message->fingerprint, coordinator->fingerprint.bytes, DIGEST_SIZE) == 0,
        }};
    g_snprintf(event.worker.name, sizeof event.worker.name, "%.63s/%d", (const char *)message->host,
               message->process);
    schedule_take(coordinator, &event);
    open_when_hungry(coordinator);
}

static void heard_text_request(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct coordinator *coordinator = user;
    const sobox_text_request_t *message = bytes;
    if (!ours(coordinator, &message->header))
        return;
    struct digest digest;
    memcpy(digest.bytes, message->digest, DIGEST_SIZE);
    size_t total = 0;
    const uint8_t *text = texts_ask(coordinator->texts, &digest, (size_t)message->offset,
                                    clock_monotonic_ns(), TEXT_REPEAT_NS, &total);
    if (text == NULL)
        return;
    const size_t piece_max = wire_payload_max(coordinator->wire, WIRE_TEXT);
    size_t offset = (size_t)message->offset;
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
        (void)!wire_publish(coordinator->wire, WIRE_TEXT, &answer);
        offset += size;
    }
}

// ---- Timers ----

static void woken(void *user)
{
    schedule_take(user, &(struct schedule_event){.kind = SCHEDULE_EVENT_TICK});
}

// Says for what the coordinator waits when no worker is there, once per wait.
static void look_for_workers(struct coordinator *coordinator, uint32_t workers)
{
    const int64_t now_ns = clock_monotonic_ns();
    if (workers > 0) {
        coordinator->waiting_ns = 0;
        coordinator->wait_said = false;
        return;
    }
    if (coordinator->waiting_ns == 0)
        coordinator->waiting_ns = now_ns;
    if (coordinator->wait_said || now_ns - coordinator->waiting_ns < WAIT_NOTE_NS)
        return;
    coordinator->wait_said = true;
    if (coordinator->settings->open)
        log_note("waiting for a worker: start one on this or another machine with "
                 "'sobox-worker --url \"%s\"'",
                 coordinator->settings->url);
    else
        log_note("waiting for the local workers to answer");
}

static gboolean tell_status(gpointer user)
{
    struct coordinator *coordinator = user;
    struct schedule_counters counters;
    schedule_counters(coordinator->schedule, &counters);
    look_for_workers(coordinator, counters.workers);
    tell_run(coordinator->tell, counters.workers > 0 ? TELL_RUNNING : TELL_WAITING, &counters);
    return G_SOURCE_CONTINUE;
}

static gboolean tell_of_searches(gpointer user)
{
    tell_tick(((struct coordinator *)user)->tell);
    return G_SOURCE_CONTINUE;
}

static gboolean show_progress(gpointer user)
{
    struct coordinator *coordinator = user;
    struct schedule_counters counters;
    schedule_counters(coordinator->schedule, &counters);
    progress_show(&coordinator->progress, coordinator->run, &counters, clock_monotonic_ns());
    return G_SOURCE_CONTINUE;
}

static gboolean interrupted(gpointer user)
{
    struct coordinator *coordinator = user;
    if (coordinator->status != STATUS_OK)
        return G_SOURCE_CONTINUE;
    error_set(coordinator->error, STATUS_INTERRUPTED,
              "interrupted; continue with 'sobox-coordinator --resume %s'",
              coordinator->run->directory);
    stop(coordinator, STATUS_INTERRUPTED);
    return G_SOURCE_CONTINUE;
}

static gboolean give_up(gpointer user)
{
    struct coordinator *coordinator = user;
    coordinator->abandoned = 0;
    if (coordinator->status == STATUS_OK)
        stop(coordinator, error_set(coordinator->error, STATUS_FAILED,
                                    "all local workers have ended; continue with "
                                    "'sobox-coordinator --resume %s'",
                                    coordinator->run->directory));
    return G_SOURCE_REMOVE;
}

static void child_ended(void *user, uint32_t alive)
{
    struct coordinator *coordinator = user;
    if (alive == 0 && !coordinator->settings->open)
        coordinator->abandoned = g_timeout_add(ABANDONED_WAIT_MS, give_up, coordinator);
}

// ---- Life ----

static enum status subscribe(struct coordinator *coordinator)
{
    static const struct {
        enum wire_kind kind;
        wire_handler *handler;
    } handlers[] = {
        {WIRE_OUTCOME_BATCH, heard_outcome},
        {WIRE_TEXT_REQUEST, heard_text_request},
        {WIRE_WORKER_STATUS, heard_worker},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(handlers); i++) {
        enum status status = wire_subscribe(coordinator->wire, handlers[i].kind,
                                            handlers[i].handler, coordinator, coordinator->error);
        if (status != STATUS_OK)
            return status;
    }
    wire_source_attach(coordinator->wire);
    return STATUS_OK;
}

static struct schedule_settings schedule_settings(struct wire *wire)
{
    struct schedule_settings settings = schedule_settings_default();
    const size_t payload = wire_payload_max(wire, WIRE_OUTCOME_BATCH);
    uint32_t samples = OUTCOME_SAMPLES_MAX;
    while (verdict_packed_size_max(samples, VERDICT_DETAIL_FULL) > payload)
        samples -= samples / 16 + 1;
    settings.batch_samples_max = samples;
    samples = OUTCOME_SAMPLES_MAX;
    while (verdict_packed_size_max(samples, VERDICT_DETAIL_SHARE) > payload)
        samples -= samples / 16 + 1;
    settings.batch_verdicts_max = samples;
    return settings;
}

// A session may end well and leave searches for another.
static enum tell_state state_after(enum status status, bool all_done)
{
    switch (status) {
    case STATUS_OK:
        return all_done ? TELL_DONE : TELL_INTERRUPTED;
    case STATUS_INTERRUPTED:
        return TELL_INTERRUPTED;
    default:
        return TELL_FAILED;
    }
}

static enum journal_state journal_state_after(enum status status, bool all_done)
{
    switch (status) {
    case STATUS_OK:
        return all_done ? JOURNAL_STATE_DONE : JOURNAL_STATE_INTERRUPTED;
    case STATUS_INTERRUPTED:
        return JOURNAL_STATE_INTERRUPTED;
    default:
        return JOURNAL_STATE_FAILED;
    }
}

static gboolean timed_dispatch(GSource *source, GSourceFunc callback, gpointer user)
{
    g_source_set_ready_time(source, -1);
    return callback(user);
}

// A source that runs whenever its ready time has come, and then waits for the next.
static GSource *timed_source(struct coordinator *coordinator, GSourceFunc callback)
{
    static GSourceFuncs functions = {.dispatch = timed_dispatch};
    GSource *source = g_source_new(&functions, sizeof(GSource));
    g_source_set_callback(source, callback, coordinator, NULL);
    g_source_attach(source, NULL);
    return source;
}

static void timed_source_end(GSource *source)
{
    g_source_destroy(source);
    g_source_unref(source);
}

// Runs the main loop with its timers and signals until something stops it.
static void loop(struct coordinator *coordinator)
{
    coordinator->opener = timed_source(coordinator, opening);
    guint timers[5] = {
        g_timeout_add(STATUS_INTERVAL_MS, tell_status, coordinator),
        g_timeout_add(TELL_TICK_MS, tell_of_searches, coordinator),
        g_unix_signal_add(SIGINT, interrupted, coordinator),
        g_unix_signal_add(SIGTERM, interrupted, coordinator),
    };
    const long long interval_ns = log_progress_interval_ns();
    if (interval_ns != INT64_MAX)
        timers[4] =
            g_timeout_add((guint)(interval_ns / CLOCK_MILLISECOND_NS), show_progress, coordinator);

    tell_run_state(coordinator, TELL_RUNNING);
    g_source_set_ready_time(coordinator->opener, 0);
    if (!run_finished(coordinator->run))
        g_main_loop_run(coordinator->loop);

    if (coordinator->abandoned != 0)
        g_source_remove(coordinator->abandoned);
    for (size_t i = 0; i < G_N_ELEMENTS(timers); i++) {
        if (timers[i] != 0)
            g_source_remove(timers[i]);
    }
    timed_source_end(coordinator->opener);
    progress_end(&coordinator->progress);
}

enum status coordinator_run(struct run *run, struct wire *wire, uint64_t sender,
                            const struct coordinator_settings *settings, struct error *error)
{
    const struct schedule_settings schedule = schedule_settings(wire);
    const struct digest fingerprint = fingerprint_compute();
    struct coordinator coordinator = {
        .run = run,
        .wire = wire,
        .sender = sender,
        .settings = settings,
        .fingerprint = fingerprint,
        .schedule = schedule_create(&schedule),
        .texts = texts_create(),
        .tell = tell_create(run, wire, &fingerprint),
        .unpacked = g_new(struct verdict, OUTCOME_SAMPLES_MAX),
        .ready = G_QUEUE_INIT,
        .opening = opening_default(),
        .loop = g_main_loop_new(NULL, FALSE),
        .error = error,
    };
    coordinator.wake = deadline_create(woken, &coordinator);
    assert(coordinator.wake != NULL);
    if (settings->children != NULL)
        children_watch(settings->children, child_ended, &coordinator);

    coordinator.status = subscribe(&coordinator);
    if (coordinator.status == STATUS_OK && run->record.search_count > 1)
        coordinator.status = pool_create(&coordinator.trimmer, settings->threads, trim,
                                         heard_trimmed, &coordinator, error);
    if (coordinator.status == STATUS_OK)
        loop(&coordinator);
    pool_free(coordinator.trimmer);

    enum status status = coordinator.status;
    const bool all_done = run->done_count == run->record.search_count;
    struct error unwritten = {0};
    if (run_end(run, journal_state_after(status, all_done), clock_monotonic_ns(), &unwritten) !=
            STATUS_OK &&
        status == STATUS_OK) {
        *error = unwritten;
        status = unwritten.status;
    }
    tell_run_state(&coordinator, state_after(status, all_done));
    wire_source_detach(wire);
    g_queue_clear(&coordinator.ready);
    g_main_loop_unref(coordinator.loop);
    deadline_free(coordinator.wake);
    schedule_effects_fini(&coordinator.effects);
    schedule_free(coordinator.schedule);
    tell_free(coordinator.tell);
    texts_free(coordinator.texts);
    g_free(coordinator.unpacked);
    return status;
}
