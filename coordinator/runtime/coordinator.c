#include "coordinator/runtime/coordinator.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/codec.h"
#include "coordinator/runtime/dispatch_loop.h"
#include "coordinator/runtime/opening.h"
#include "coordinator/runtime/pool.h"
#include "coordinator/runtime/progress.h"
#include "coordinator/runtime/run_status.h"
#include "coordinator/runtime/tell.h"
#include "coordinator/schedule/schedule.h"
#include "worker/batch/fingerprint.h"

#include <glib.h>
#include <string.h>

enum {
    STATUS_INTERVAL_MS = 1000,
};

struct coordinator {
    struct run *run;
    struct wire *wire;
    struct dispatch_loop *loop;
    struct verdict *unpacked; // (PROTOCOL_BATCH_SAMPLES_MAX) of the outcome being looked at
    struct progress progress;
    GQueue ready; // indexes of open searches whose step is sampled, or that have just been opened
    struct opening opening;
    struct tell *tell;
    struct pool *trimmer; // NULL in a run of one search, which trims where it stands
    GSource *opener;      // runs once to see whether another search may be opened
    struct error *error;
};

// ---- Batches ----

static void send_batch(void *user, uint64_t worker, const struct batch_identity *batch)
{
    struct coordinator *coordinator = user;
    const struct run_search *search = coordinator->run->open[batch->search];
    const struct search_request *request = &search->request;
    sobox_sample_batch_t message = {
        .header.run = (int64_t)coordinator->run->record.id,
        .holder = (int64_t)worker,
        .seed = (int64_t)request->sampling.seed,
        .batch = codec_batch(batch),
        .step_samples = (int32_t)request->sampling.samples,
        .sampling = (int8_t)request->sampling.method,
        .detail = (int8_t)request->detail,
        .variables = (int32_t)search->sampled.count,
    };
    memcpy(message.scenario, search->scenario.digest.bytes, DIGEST_SIZE);
    memcpy(message.box, search->box.bytes, DIGEST_SIZE);
    if (search->text->len <= wire_payload_max(coordinator->wire, WIRE_SAMPLE_BATCH)) {
        message.text_size = (int32_t)search->text->len;
        message.text = search->text->data;
    }
    // A message that LCM cannot send is a message lost: the lease brings the batch back.
    (void)!wire_publish(coordinator->wire, WIRE_SAMPLE_BATCH, &message);
}

static void count_batch(void *user, const struct batch_identity *batch)
{
    const struct coordinator *coordinator = user;
    memcpy(coordinator->run->open[batch->search]->verdicts + batch->first, coordinator->unpacked,
           batch->count * sizeof(struct verdict));
}

static void step_sampled(void *user, uint32_t search, uint32_t step)
{
    (void)step;
    struct coordinator *coordinator = user;
    g_queue_push_tail(&coordinator->ready, GUINT_TO_POINTER(search));
}

static void tell_run_state(struct coordinator *coordinator, enum run_state state)
{
    struct schedule_counters counters;
    dispatch_loop_counters(coordinator->loop, &counters);
    tell_run(coordinator->tell, state, &counters);
}

// ---- Searches ----

// The search is done and leaves: what it held is released.
static void leave(struct coordinator *coordinator, uint32_t index)
{
    const struct scenario *scenario = &coordinator->run->open[index]->scenario;
    tell_end(coordinator->tell, coordinator->run->open[index]);
    text_server_withdraw(dispatch_loop_texts(coordinator->loop), &scenario->digest);
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
    text_server_offer(dispatch_loop_texts(coordinator->loop), &search->box, search->text->data,
                      search->text->len);
    dispatch_loop_step(coordinator->loop, index, search->request.sampling.step,
                       search->request.sampling.samples, search->request.detail);
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
            text_server_withdraw(dispatch_loop_texts(coordinator->loop), &search->box);
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
        dispatch_loop_stop(coordinator->loop, status);
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
        dispatch_loop_stop(coordinator->loop, status);
    else
        advance_or_stop(coordinator);
    g_source_set_ready_time(coordinator->opener, 0);
}

// Whether another search should be open.
static bool room_for_search(const struct coordinator *coordinator)
{
    struct schedule_counters counters;
    dispatch_loop_counters(coordinator->loop, &counters);
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
    text_server_offer(dispatch_loop_texts(coordinator->loop), &scenario->digest, scenario->text,
                      scenario->text_size);
    g_queue_push_tail(&coordinator->ready, GUINT_TO_POINTER(index));
    return STATUS_OK;
}

static void open_when_hungry(void *user)
{
    struct coordinator *coordinator = user;
    uint32_t index;
    if (run_waiting(coordinator->run, &index) && room_for_search(coordinator))
        g_source_set_ready_time(coordinator->opener, 0);
}

static gboolean opening(gpointer user)
{
    struct coordinator *coordinator = user;
    enum status status = open_search(coordinator);
    if (status != STATUS_OK)
        dispatch_loop_stop(coordinator->loop, status);
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
    const struct batch_identity batch = codec_identity(&message->batch);
    if (!ours(coordinator, &message->header) ||
        batch.search >= coordinator->run->record.search_count)
        return;
    const struct run_search *search = coordinator->run->open[batch.search];
    // Only the step being sampled can count; an outcome of an earlier one is unpacked by no one.
    if (search != NULL && search->active && batch.step == search->request.sampling.step &&
        (message->detail != (int8_t)search->request.detail ||
         !verdict_unpack(coordinator->unpacked, batch.count, search->request.detail,
                         search->scenario.constraint_count, message->packed,
                         (size_t)message->packed_size))) {
        log_debug("an outcome of step %u does not unpack", batch.step);
        return;
    }
    dispatch_loop_outcome(coordinator->loop, (uint64_t)message->header.sender, &batch,
                          (uint32_t)message->queue, message->service_ns);
    advance_or_stop(coordinator);
    open_when_hungry(coordinator);
}

// ---- Timers ----

static void tell_status(void *user, const struct schedule_counters *counters, bool waiting)
{
    const struct coordinator *coordinator = user;
    tell_run(coordinator->tell, waiting ? RUN_STATE_WAITING : RUN_STATE_RUNNING, counters);
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
    dispatch_loop_counters(coordinator->loop, &counters);
    progress_show(&coordinator->progress, coordinator->run, &counters, clock_monotonic_ns());
    return G_SOURCE_CONTINUE;
}

// ---- Life ----

static struct schedule_settings schedule_settings(struct wire *wire)
{
    struct schedule_settings settings = schedule_settings_default();
    const size_t payload = wire_payload_max(wire, WIRE_OUTCOME_BATCH);
    for (int detail = 0; detail < VERDICT_DETAIL_COUNT; detail++) {
        uint32_t samples = PROTOCOL_BATCH_SAMPLES_MAX;
        while (verdict_packed_size_max(samples, (enum verdict_detail)detail) > payload)
            samples -= samples / 16 + 1;
        settings.batch_samples_max[detail] = samples;
    }
    return settings;
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

// Runs the main loop with the timers of searches until something stops it.
static enum status loop(struct coordinator *coordinator)
{
    coordinator->opener = timed_source(coordinator, opening);
    guint timers[2] = {g_timeout_add(TELL_TICK_MS, tell_of_searches, coordinator)};
    const long long interval_ns = log_progress_interval_ns();
    if (interval_ns != INT64_MAX)
        timers[1] =
            g_timeout_add((guint)(interval_ns / CLOCK_MILLISECOND_NS), show_progress, coordinator);

    g_source_set_ready_time(coordinator->opener, 0);
    if (run_finished(coordinator->run))
        dispatch_loop_stop(coordinator->loop, STATUS_OK);
    const enum status status =
        dispatch_loop_run(coordinator->loop, coordinator->run->directory, coordinator->error);

    for (size_t i = 0; i < G_N_ELEMENTS(timers); i++) {
        if (timers[i] != 0)
            g_source_remove(timers[i]);
    }
    timed_source_end(coordinator->opener);
    progress_end(&coordinator->progress);
    return status;
}

enum status coordinator_run(struct run *run, struct wire *wire,
                            const struct coordinator_settings *settings, struct error *error)
{
    static const struct dispatch_loop_calls calls = {
        .send = send_batch,
        .count = count_batch,
        .finished = step_sampled,
        .status = tell_status,
        .room = open_when_hungry,
    };
    const struct schedule_settings schedule = schedule_settings(wire);
    const struct digest fingerprint = fingerprint_compute();
    struct coordinator coordinator = {
        .run = run,
        .wire = wire,
        .tell = tell_create(run, wire, &fingerprint),
        .unpacked = g_new(struct verdict, PROTOCOL_BATCH_SAMPLES_MAX),
        .ready = G_QUEUE_INIT,
        .opening = opening_default(),
        .error = error,
    };
    enum status status = dispatch_loop_create(&coordinator.loop, wire, run->record.id, settings,
                                              &schedule, &calls, &coordinator, error);
    if (status == STATUS_OK)
        status = wire_subscribe(wire, WIRE_OUTCOME_BATCH, heard_outcome, &coordinator, error);
    if (status == STATUS_OK && run->record.search_count > 1)
        status = pool_create(&coordinator.trimmer, settings->threads, trim, heard_trimmed,
                             &coordinator, error);
    if (status == STATUS_OK)
        status = loop(&coordinator);
    pool_free(coordinator.trimmer);

    const bool all_done = run->done_count == run->record.search_count;
    struct error unwritten = {0};
    if (run_end(run, run_status_after(status, all_done), clock_monotonic_ns(), &unwritten) !=
            STATUS_OK &&
        status == STATUS_OK) {
        *error = unwritten;
        status = unwritten.status;
    }
    if (coordinator.loop != NULL)
        tell_run_state(&coordinator, run_status_after(status, all_done));
    g_queue_clear(&coordinator.ready);
    dispatch_loop_free(coordinator.loop);
    tell_free(coordinator.tell);
    g_free(coordinator.unpacked);
    return status;
}
