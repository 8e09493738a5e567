#include "worker/runtime/worker.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/processors.h"
#include "common/base/watch.h"
#include "common/protocol/protocol.h"
#include "common/wire/codec.h"
#include "common/wire/source.h"
#include "worker/batch/fingerprint.h"
#include "worker/batch/intake.h"
#include "worker/runtime/engine.h"
#include "worker/runtime/presence.h"

#include <assert.h>
#include <glib-unix.h>
#include <glib.h>
#include <inttypes.h>
#include <string.h>
#include <unistd.h>

enum {
    STATUS_INTERVAL_MS = 1000,
    DEAF_SECONDS_MAX = 5, // without hearing anything, itself included, before LCM is opened anew
};

struct worker {
    struct worker_settings settings; // threads resolved
    struct wire *wire;
    uint64_t sender;
    struct digest fingerprint;
    char host[sizeof((sobox_worker_status_t *)0)->host];
    int64_t start_ns;

    struct intake *intake;
    struct engine *engine;
    struct presence presence;
    size_t subscribed; // how many of `heard`

    GSource *wake;    // fires when the intake wants to ask for a text
    guint tick;       // once a second
    guint results;    // the engine has results
    guint greeting;   // a status that a crowd spreads; 0 when none is due
    uint64_t heard;   // wire_heard() a second ago
    int deaf_seconds; // for how long it has not grown
    uint64_t dropped; // batches that could not be taken in
    uint64_t unsent;  // outcomes that the wire did not take
    uint64_t batches; // evaluated
    uint64_t samples; // evaluated
    int64_t busy_ns;  // spent evaluating
};

struct worker_settings worker_settings_default(void)
{
    return (struct worker_settings){.priority = WORKER_PRIORITY_DEFAULT};
}

// A flood of the same trouble gives few lines: the 1st, 2nd, 4th, 8th, ...
static bool worth_a_note(uint64_t count)
{
    return (count & (count - 1)) == 0;
}

// ---- Its own status ----

static void publish_status(struct worker *worker, bool leaving)
{
    struct wire_counters wire;
    wire_counters(worker->wire, &wire);
    sobox_worker_status_t status = {
        .process = getpid(),
        .threads = worker->settings.threads,
        .queue = (int32_t)intake_queue(worker->intake),
        .leaving = leaving,
        .batches = (int64_t)worker->batches,
        .samples = (int64_t)worker->samples,
        .busy_ns = worker->busy_ns,
        .uptime_ns = clock_monotonic_ns() - worker->start_ns,
        .lost = (int64_t)wire.lost,
        .dropped = (int64_t)wire.dropped,
        .buffer_size = (int32_t)MIN(wire.buffer_size, INT32_MAX),
    };
    memcpy(status.fingerprint, worker->fingerprint.bytes, sizeof status.fingerprint);
    memcpy(status.host, worker->host, sizeof status.host);
    if (wire_publish(worker->wire, WIRE_WORKER_STATUS, &status) != STATUS_OK)
        log_debug("the network did not take a status");
}

static gboolean greet_now(gpointer user)
{
    struct worker *worker = user;
    worker->greeting = 0;
    publish_status(worker, false);
    return G_SOURCE_REMOVE;
}

// A coordinator that has just started knows no worker; every worker answers it at once, unless
// there are so many that their answers would drown each other.
static void greet(struct worker *worker)
{
    if (!presence_crowded(&worker->presence)) {
        publish_status(worker, false);
        return;
    }
    if (worker->greeting == 0)
        worker->greeting = g_timeout_add(
            (guint)g_random_int_range(0, (gint32)presence_spread_ms(&worker->presence) + 1),
            greet_now, worker);
}

// LCM goes deaf without a word when the multicast route changes. A worker hears its own status as
// long as all is well. (A hub that is away is waited for by the wire itself.)
static void reopen_when_deaf(struct worker *worker)
{
    uint64_t heard = wire_heard(worker->wire);
    bool deaf = heard == worker->heard && wire_connected(worker->wire);
    worker->deaf_seconds = deaf ? worker->deaf_seconds + 1 : 0;
    worker->heard = heard;
    if (worker->deaf_seconds < DEAF_SECONDS_MAX)
        return;
    worker->deaf_seconds = 0;
    log_note("nothing heard for %d s, not even this worker itself: opening the network anew",
             DEAF_SECONDS_MAX);
    struct error error = {0};
    if (wire_reopen(worker->wire, &error) != STATUS_OK)
        log_note("%s; trying again in %d s", error.text, DEAF_SECONDS_MAX);
    wire_source_attach(worker->wire);
}

static gboolean each_second(gpointer user)
{
    struct worker *worker = user;
    const bool due = presence_second(&worker->presence);
    if (worker->settings.reopen)
        reopen_when_deaf(worker);
    if (due)
        publish_status(worker, false);
    return G_SOURCE_CONTINUE;
}

// ---- Batches in, outcomes out ----

static void publish_requests(struct worker *worker, int64_t now_ns)
{
    struct intake_request request;
    while (intake_request(worker->intake, now_ns, &request)) {
        sobox_text_request_t message = {
            .header.run = (int64_t)request.run,
            .offset = (int32_t)request.offset,
        };
        memcpy(message.digest, request.digest.bytes, sizeof message.digest);
        if (wire_publish(worker->wire, WIRE_TEXT_REQUEST, &message) != STATUS_OK)
            log_debug("the network did not take a request for a text");
    }
}

static void set_wake(struct worker *worker)
{
    int64_t wake_ns = intake_wake_ns(worker->intake);
    // Rounded up, or the source would fire just before the request is due, again and again.
    gint64 wake_us = wake_ns == INT64_MAX ? -1 : wake_ns / 1000 + 1;
    g_source_set_ready_time(worker->wake, wake_us);
}

// What is ready goes to the engine until that has enough to go on with while the message thread is
// busy. The rest waits where coordinators have their turns.
static void submit_ready(struct worker *worker)
{
    struct intake_work work;
    while (engine_hungry(worker->engine) && intake_take(worker->intake, &work)) {
        struct engine_job *job = g_new0(struct engine_job, 1);
        job->work = work;
        engine_submit(worker->engine, job);
    }
}

// After anything that may have changed what the intake wants.
static void serve_intake(struct worker *worker, int64_t now_ns)
{
    submit_ready(worker);
    publish_requests(worker, now_ns);
    set_wake(worker);
}

static gboolean wake_dispatch(GSource *source, GSourceFunc callback, gpointer user)
{
    (void)source;
    callback(user);
    return G_SOURCE_CONTINUE;
}

static GSourceFuncs wake_functions = {.dispatch = wake_dispatch};

static gboolean wake_up(gpointer user)
{
    serve_intake(user, clock_monotonic_ns());
    return G_SOURCE_CONTINUE;
}

static void note_unsent(struct worker *worker, enum wire_kind kind, size_t size)
{
    if (!worth_a_note(++worker->unsent))
        return;
    if (size > wire_payload_max(worker->wire, kind))
        log_note("an outcome of %zu bytes does not fit a message: give this worker the "
                 "coordinator's --mtu",
                 size);
    else
        log_note("the network did not take an outcome (%" PRIu64 " so far)", worker->unsent);
}

static void publish_values(struct worker *worker, const struct engine_job *job)
{
    const struct intake_batch *batch = &job->work.batch;
    sobox_value_batch_t message = {
        .header.run = (int64_t)batch->run,
        .batch = codec_batch(&batch->identity),
        .queue = (int32_t)intake_queue(worker->intake),
        .service_ns = job->service_ns,
        .value_count = (int32_t)job->outcome_count,
        .values = job->outcomes,
    };
    if (wire_publish(worker->wire, WIRE_VALUE_BATCH, &message) != STATUS_OK)
        note_unsent(worker, WIRE_VALUE_BATCH, job->outcome_count * sizeof(double));
}

static void publish_outcome(struct worker *worker, const struct engine_job *job)
{
    const struct intake_batch *batch = &job->work.batch;
    sobox_outcome_batch_t message = {
        .header.run = (int64_t)batch->run,
        .batch = codec_batch(&batch->identity),
        .detail = (int8_t)batch->detail,
        .non_finite = (int32_t)job->non_finite,
        .queue = (int32_t)intake_queue(worker->intake),
        .service_ns = job->service_ns,
        .packed_size = (int32_t)job->packed_size,
        .packed = job->packed,
    };
    if (wire_publish(worker->wire, WIRE_OUTCOME_BATCH, &message) != STATUS_OK)
        note_unsent(worker, WIRE_OUTCOME_BATCH, job->packed_size);
}

static void collect_results(struct worker *worker)
{
    struct engine_job *job;
    while ((job = engine_collect(worker->engine)) != NULL) {
        worker->batches++;
        worker->samples += job->work.batch.identity.count;
        worker->busy_ns += job->service_ns;
        intake_done(worker->intake, &job->work);
        if (job->outcomes != NULL)
            publish_values(worker, job);
        else
            publish_outcome(worker, job);
        engine_job_free(job);
    }
}

static gboolean results_wait(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)descriptor;
    (void)condition;
    struct worker *worker = user;
    engine_acknowledge(worker->engine);
    collect_results(worker);
    submit_ready(worker);
    return G_SOURCE_CONTINUE;
}

// ---- What is heard ----

static void note_dropped(struct worker *worker, const struct error *error)
{
    worker->dropped++;
    if (worth_a_note(worker->dropped))
        log_note("a batch was dropped (%" PRIu64 " so far): %s", worker->dropped, error->text);
}

// Takes in a batch leased to this worker. Its coordinator knows it, so it needs no greeting.
static void take_batch(struct worker *worker, const struct intake_batch *batch)
{
    struct error error = {0};
    int64_t now_ns = clock_monotonic_ns();
    presence_coordinator(&worker->presence, batch->coordinator, now_ns);
    if (intake_batch(worker->intake, batch, now_ns, &error) != STATUS_OK)
        note_dropped(worker, &error);
    serve_intake(worker, now_ns);
}

static void on_sample_batch(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct worker *worker = user;
    const sobox_sample_batch_t *message = received;
    if ((uint64_t)message->holder != worker->sender)
        return;
    struct intake_batch batch = {
        .run = (uint64_t)message->header.run,
        .coordinator = (uint64_t)message->header.sender,
        .identity = codec_identity(&message->batch),
        .sampling =
            {
                .seed = (uint64_t)message->seed,
                .step = (uint32_t)message->batch.step,
                .samples = (uint32_t)message->step_samples,
                .method = (enum sampling_method)message->sampling,
            },
        .detail = (enum verdict_detail)message->detail,
        .variables = (uint32_t)message->variables,
        .text = message->text,
        .text_size = (uint32_t)message->text_size,
    };
    memcpy(batch.scenario.bytes, message->scenario, sizeof batch.scenario.bytes);
    memcpy(batch.box.bytes, message->box, sizeof batch.box.bytes);
    take_batch(worker, &batch);
}

static void on_design_batch(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct worker *worker = user;
    const sobox_design_batch_t *message = received;
    if ((uint64_t)message->holder != worker->sender)
        return;
    struct intake_batch batch = {
        .run = (uint64_t)message->header.run,
        .coordinator = (uint64_t)message->header.sender,
        .identity = codec_identity(&message->batch),
        .designs = message->values,
        .design_value_count = (uint32_t)message->value_count,
    };
    memcpy(batch.scenario.bytes, message->scenario, sizeof batch.scenario.bytes);
    take_batch(worker, &batch);
}

static void on_text(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct worker *worker = user;
    const sobox_text_t *message = received;
    struct digest digest;
    memcpy(digest.bytes, message->digest, sizeof digest.bytes);
    struct error error = {0};
    int64_t now_ns = clock_monotonic_ns();
    if (intake_text(worker->intake, &digest, (uint32_t)message->total_size,
                    (uint32_t)message->offset, message->piece, (uint32_t)message->piece_size,
                    now_ns, &error) != STATUS_OK)
        note_dropped(worker, &error);
    serve_intake(worker, now_ns);
}

static void on_run_status(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct worker *worker = user;
    const sobox_run_status_t *message = received;
    uint64_t sender = (uint64_t)message->header.sender;
    if (protocol_run_ended((enum run_state)message->state)) {
        presence_coordinator_ended(&worker->presence, sender);
        if (worker->settings.notes)
            log_note("run %s has ended", (const char *)message->name);
        return;
    }
    if (!presence_coordinator(&worker->presence, sender, clock_monotonic_ns()))
        return;
    if (worker->settings.notes)
        log_note("run %s is there", (const char *)message->name);
    greet(worker);
}

static void on_worker_status(void *user, enum wire_kind kind, const void *message)
{
    (void)kind;
    (void)message;
    struct worker *worker = user;
    presence_worker(&worker->presence);
}

// Takes the place of a stopped worker's handlers: a wire has no way to unsubscribe.
static void on_nothing(void *user, enum wire_kind kind, const void *message)
{
    (void)user;
    (void)kind;
    (void)message;
}

static const struct {
    enum wire_kind kind;
    wire_handler *handler;
} heard[] = {
    {WIRE_SAMPLE_BATCH, on_sample_batch},
    {WIRE_DESIGN_BATCH, on_design_batch},
    {WIRE_TEXT, on_text},
    {WIRE_RUN_STATUS, on_run_status},
    // Last, because only a worker that listens for itself subscribes to it. Inside a coordinator
    // this kind is the coordinator's. They are only counted, so nobody needs to prove that it is
    // there.
    {WIRE_WORKER_STATUS, on_worker_status},
};

static enum status subscribe(struct worker *worker, struct error *error)
{
    size_t count = worker->settings.reopen ? G_N_ELEMENTS(heard) : G_N_ELEMENTS(heard) - 1;
    enum status status = STATUS_OK;
    while (worker->subscribed < count && status == STATUS_OK) {
        size_t i = worker->subscribed;
        status = heard[i].kind == WIRE_WORKER_STATUS
                     ? wire_overhear(worker->wire, heard[i].kind, heard[i].handler, worker, error)
                     : wire_subscribe(worker->wire, heard[i].kind, heard[i].handler, worker, error);
        worker->subscribed += status == STATUS_OK;
    }
    wire_source_attach(worker->wire);
    return status;
}

static void unsubscribe(struct worker *worker)
{
    while (worker->subscribed > 0) {
        enum wire_kind kind = heard[--worker->subscribed].kind;
        enum status status = wire_subscribe(worker->wire, kind, on_nothing, NULL, NULL);
        assert(status == STATUS_OK); // only the first handler of a kind can fail to be put there
        (void)status;
    }
}

// ---- The whole ----

static void name_host(struct worker *worker)
{
    g_autofree char *valid = g_utf8_make_valid(g_get_host_name(), -1);
    g_strlcpy(worker->host, valid, sizeof worker->host);
    const char *end;
    g_utf8_validate(worker->host, -1, &end); // a character may have been cut
    worker->host[end - worker->host] = '\0';
}

static void start_sources(struct worker *worker)
{
    worker->wake = g_source_new(&wake_functions, sizeof(GSource));
    g_source_set_name(worker->wake, "texts to ask for");
    g_source_set_callback(worker->wake, wake_up, worker, NULL);
    g_source_attach(worker->wake, NULL);
    worker->results = watch_add(engine_descriptor(worker->engine), results_wait, worker);
    worker->tick = g_timeout_add(STATUS_INTERVAL_MS, each_second, worker);
}

static void stop_sources(struct worker *worker)
{
    g_source_destroy(worker->wake);
    g_source_unref(worker->wake);
    g_source_remove(worker->results);
    g_source_remove(worker->tick);
    if (worker->greeting != 0)
        g_source_remove(worker->greeting);
}

enum status worker_start(struct worker **started, struct wire *wire, uint64_t sender,
                         const struct worker_settings *settings, struct error *error)
{
    assert(settings->threads >= 0 && settings->threads <= WORKER_THREADS_MAX);
    assert(settings->priority >= 0 && settings->priority <= WORKER_PRIORITY_MAX);
    *started = NULL;
    struct worker *worker = g_new0(struct worker, 1);
    worker->settings = *settings;
    if (worker->settings.threads == 0)
        worker->settings.threads = processors_usable();
    // More than OpenMP gives would be announced and never run.
    worker->settings.threads = processors_limited(worker->settings.threads);
    worker->wire = wire;
    worker->sender = sender;
    worker->fingerprint = fingerprint_compute();
    worker->start_ns = clock_monotonic_ns();
    name_host(worker);
    enum status status =
        engine_create(&worker->engine, worker->settings.threads, worker->settings.priority, error);
    if (status != STATUS_OK)
        goto err;
    worker->intake = intake_create();
    start_sources(worker);
    status = subscribe(worker, error);
    if (status != STATUS_OK)
        goto err_after_sources_start;
    publish_status(worker, false);
    *started = worker;
    return STATUS_OK;

err_after_sources_start:
    stop_sources(worker);
    unsubscribe(worker);
    intake_free(worker->intake);
    engine_free(worker->engine);
err:
    g_free(worker);
    return status;
}

void worker_stop(struct worker *worker)
{
    if (worker == NULL)
        return;
    unsubscribe(worker);
    stop_sources(worker);
    engine_stop(worker->engine);
    collect_results(worker);
    publish_status(worker, true);
    engine_free(worker->engine);
    intake_free(worker->intake);
    g_free(worker);
}

int worker_threads(const struct worker *worker)
{
    return worker->settings.threads;
}

void worker_counters(const struct worker *worker, struct worker_counters *counters)
{
    *counters = (struct worker_counters){
        .batches = worker->batches,
        .samples = worker->samples,
        .busy_ns = worker->busy_ns,
        .queue = intake_queue(worker->intake),
        .coordinators = presence_coordinator_count(&worker->presence, clock_monotonic_ns()),
    };
}
