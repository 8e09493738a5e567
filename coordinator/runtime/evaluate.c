#include "coordinator/runtime/evaluate.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/watch.h"
#include "common/numeric/identity.h"
#include "common/wire/codec.h"
#include "coordinator/runtime/dispatch_loop.h"
#include "coordinator/runtime/pool.h"
#include "coordinator/runtime/progress.h"
#include "coordinator/runtime/run_status.h"
#include "worker/batch/fingerprint.h"

#include <assert.h>
#include <inttypes.h>
#include <string.h>

enum {
    // How far it has come is noted so often, also while the table is slow in coming: what a kill
    // costs at most is done again.
    NOTE_INTERVAL_MS = 200,
};

//     FREE --> READING --> READ --> SAMPLED --> WRITING --> WRITTEN --> FREE
//                 |        at workers                          in the file's turn
//                 +--> WRONG (a row is none): the run ends when its turn comes
enum state { FREE, READING, READ, SAMPLED, WRITING, WRITTEN, WRONG };

// A piece of the table and all that becomes of it. Its place in the ring is its `search` for the
// schedule, which then counts the pieces at that place as steps.
struct piece {
    enum state state;
    const struct evaluate *table;
    struct source_piece source;
    uint32_t step;
    uint64_t first;         // number of its first design, once those before it are known; 0 before
    struct designs designs; // from READ on
    double *values;         // (designs x outcomes) from READ on
    struct evaluation_piece result;
    GString *text;
    bool wrong; // what the thread that reads it says
    struct error error;
};

struct work {
    struct evaluate *table;
    struct wire *wire;
    struct dispatch_loop *loop;
    struct pool *pool;
    struct digest fingerprint; // of the kernel
    uint64_t run;              // of this session alone: an outcome of an earlier one is no one's
    struct piece pieces[EVALUATE_PIECES_MAX];
    uint32_t oldest;     // place of the one whose turn it is
    uint32_t count;      // under way
    uint64_t next;       // number of the first design of which the number is not known yet
    bool all_read;       // no piece comes any more
    guint reader;        // watches the table while there is room for a piece; 0: does not
    const double *heard; // values of the outcome being given to the dispatcher
    int64_t shown_ns;    // for rates
    uint64_t shown_rows;
    struct error *error;
};

static uint32_t variable_count(const struct work *work)
{
    return work->table->evaluation->scenario.design_space.count;
}

static uint32_t outcome_count(const struct work *work)
{
    return scenario_outcome_count(&work->table->evaluation->scenario);
}

static void piece_free(struct piece *piece)
{
    g_free(piece->source.text);
    designs_fini(&piece->designs);
    g_free(piece->values);
    if (piece->text != NULL)
        g_string_free(piece->text, TRUE);
    *piece = (struct piece){.step = piece->step};
}

// ---- In the threads ----

static void read_piece(struct piece *piece)
{
    const struct source_piece *source = &piece->source;
    piece->result.digest = digest_of(source->text, source->size);
    piece->result.end = source->end;
    const enum status status =
        designs_read(&piece->designs, &piece->table->layout, source_name(piece->table->source),
                     source->line, source->text, source->size, &piece->error);
    piece->wrong = status != STATUS_OK;
}

static void write_piece(struct piece *piece)
{
    struct evaluation_piece *result = &piece->result;
    piece->text = g_string_sized_new(piece->source.size);
    outcomes_rows(&piece->table->evaluation->outcomes, &piece->designs, piece->first, piece->values,
                  piece->text, &result->sums);
    result->text = piece->text->str;
    result->size = piece->text->len;
    result->rows = piece->designs.count;
}

static void work_on(void *job)
{
    struct piece *piece = job;
    if (piece->state == READING)
        read_piece(piece);
    else
        write_piece(piece);
}

// ---- The order of things ----

static void watch_table(struct work *work);

static void fail(struct work *work, enum status status)
{
    dispatch_loop_stop(work->loop, status);
}

// Gives every piece whose predecessors are known its number, and the evaluated ones to be written.
static void number_pieces(struct work *work)
{
    for (uint32_t i = 0; i < work->count; i++) {
        struct piece *piece = &work->pieces[(work->oldest + i) % EVALUATE_PIECES_MAX];
        if (piece->state == READING || piece->state == WRONG)
            return;
        if (piece->first == 0) {
            piece->first = work->next;
            work->next += piece->designs.count;
        }
        if (piece->state == SAMPLED) {
            piece->state = WRITING;
            pool_take(work->pool, piece);
        }
    }
}

// Writes what is done into the file as far as it is in order. A row that is none ends the run here,
// with everything in front of it written.
static enum status write_in_order(struct work *work)
{
    while (work->count > 0) {
        struct piece *piece = &work->pieces[work->oldest];
        if (piece->state == WRONG)
            return error_set(work->error, piece->error.status, "%s", piece->error.text);
        if (piece->state != WRITTEN)
            return STATUS_OK;
        const enum status status =
            evaluation_append(work->table->evaluation, &piece->result, work->error);
        if (status != STATUS_OK)
            return status;
        piece_free(piece);
        work->oldest = (work->oldest + 1) % EVALUATE_PIECES_MAX;
        work->count--;
    }
    return STATUS_OK;
}

static void advance(struct work *work)
{
    number_pieces(work);
    const enum status status = write_in_order(work);
    if (status != STATUS_OK || (work->all_read && work->count == 0))
        fail(work, status);
    else
        watch_table(work);
}

// A piece has been read: its designs go to the workers.
static void take_read(struct work *work, struct piece *piece)
{
    const uint32_t designs = piece->designs.count;
    if (piece->wrong) {
        piece->state = WRONG;
        work->all_read = true; // nothing behind it will be written
        return;
    }
    if (designs == 0) { // only comments
        piece->state = SAMPLED;
        return;
    }
    piece->state = READ;
    piece->values = g_new(double, (size_t)designs *outcome_count(work));
    dispatch_loop_step(work->loop, (uint32_t)(piece - work->pieces), piece->step, designs, false);
}

static void threads_are_done(void *user, GPtrArray *jobs)
{
    struct work *work = user;
    for (guint i = 0; i < jobs->len; i++) {
        struct piece *piece = jobs->pdata[i];
        if (piece->state == WRITING)
            piece->state = WRITTEN;
        else
            take_read(work, piece);
    }
    advance(work);
}

// ---- The table ----

static enum status take_pieces(struct work *work)
{
    struct source *source = work->table->source;
    while (work->count < EVALUATE_PIECES_MAX && !work->all_read) {
        struct source_piece next;
        const enum status status = source_piece(source, &next, work->error);
        if (status != STATUS_OK)
            return status;
        work->all_read = source_ended(source);
        if (next.text == NULL)
            return STATUS_OK;
        struct piece *piece = &work->pieces[(work->oldest + work->count) % EVALUATE_PIECES_MAX];
        assert(piece->state == FREE);
        piece->table = work->table;
        piece->source = next;
        piece->state = READING;
        piece->step++;
        work->count++;
        pool_take(work->pool, piece);
    }
    return STATUS_OK;
}

static gboolean table_is_readable(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)descriptor;
    (void)condition;
    struct work *work = user;
    // What was read before may still hold pieces for which there was no room.
    enum status status = take_pieces(work);
    if (status == STATUS_OK && !work->all_read && work->count < EVALUATE_PIECES_MAX)
        status = source_fill(work->table->source, work->error);
    if (status == STATUS_OK)
        status = take_pieces(work);
    if (status != STATUS_OK) {
        work->reader = 0;
        fail(work, status);
        return G_SOURCE_REMOVE;
    }
    if (!work->all_read && work->count < EVALUATE_PIECES_MAX)
        return G_SOURCE_CONTINUE;
    work->reader = 0;
    if (work->count == 0)
        fail(work, STATUS_OK); // the end, and nothing was left to do
    return G_SOURCE_REMOVE;
}

// Reads on while there is room for a piece. A file is always readable, a pipe when something came.
static void watch_table(struct work *work)
{
    if (work->reader != 0 || work->all_read || work->count == EVALUATE_PIECES_MAX)
        return;
    work->reader = watch_add(source_descriptor(work->table->source), table_is_readable, work);
}

// ---- The workers ----

static void send_batch(void *user, uint64_t worker, const struct batch_identity *batch)
{
    struct work *work = user;
    const struct piece *piece = &work->pieces[batch->search];
    const uint32_t variables = variable_count(work);
    sobox_design_batch_t message = {
        .header.run = (int64_t)work->run,
        .holder = (int64_t)worker,
        .batch = codec_batch(batch),
        .value_count = (int32_t)(batch->count * variables),
        .values = piece->designs.values + batch->first * (size_t)variables,
    };
    memcpy(message.scenario, work->table->evaluation->scenario.digest.bytes, DIGEST_SIZE);
    (void)!wire_publish(work->wire, WIRE_DESIGN_BATCH, &message);
}

static void count_batch(void *user, const struct batch_identity *batch)
{
    const struct work *work = user;
    const size_t outcomes = outcome_count(work);
    memcpy(work->pieces[batch->search].values + batch->first * outcomes, work->heard,
           batch->count * outcomes * sizeof(double));
}

static void piece_sampled(void *user, uint32_t search, uint32_t step)
{
    struct work *work = user;
    struct piece *piece = &work->pieces[search];
    assert(piece->state == READ && piece->step == step);
    piece->state = SAMPLED;
    advance(work);
}

static void heard_values(void *user, enum wire_kind kind, const void *bytes)
{
    (void)kind;
    struct work *work = user;
    const sobox_value_batch_t *message = bytes;
    const struct batch_identity batch = codec_identity(&message->batch);
    if ((uint64_t)message->header.run != work->run || batch.search >= EVALUATE_PIECES_MAX)
        return;
    const struct piece *piece = &work->pieces[batch.search];
    // Only what is being evaluated can count. Whether the batch is one of it the schedule knows.
    if (piece->state != READ || batch.step != piece->step ||
        (uint32_t)message->value_count != batch.count * outcome_count(work)) {
        log_debug("an outcome of piece %u, step %u is not wanted", batch.search, batch.step);
        return;
    }
    work->heard = message->values;
    dispatch_loop_outcome(work->loop, (uint64_t)message->header.sender, &batch,
                          (uint32_t)message->queue, message->service_ns);
    work->heard = NULL;
}

// ---- What others hear ----

// For them it is a run of one search, of which there is nothing to show but how it goes.
static void publish_status(struct work *work, enum run_state state,
                           const struct schedule_counters *counters)
{
    const struct evaluation *evaluation = work->table->evaluation;
    const struct run_status status = {
        .run = work->run,
        .name = evaluation->scenario.name,
        .fingerprint = &work->fingerprint,
        .state = state,
        .searches = 1,
        .searches_done = state == RUN_STATE_DONE,
        .elapsed_ns = evaluation->elapsed_ns + clock_monotonic_ns() - evaluation->started_ns,
    };
    run_status_publish(work->wire, &status, counters);
}

static void tell_status(void *user, const struct schedule_counters *counters, bool waiting)
{
    publish_status(user, waiting ? RUN_STATE_WAITING : RUN_STATE_RUNNING, counters);
}

static void tell_end_state(struct work *work, enum status status)
{
    struct schedule_counters counters;
    dispatch_loop_counters(work->loop, &counters);
    publish_status(work, run_status_after(status, true), &counters);
}

// ---- Progress ----

static gboolean show_progress(gpointer user)
{
    struct work *work = user;
    const struct evaluation *evaluation = work->table->evaluation;
    struct schedule_counters counters;
    dispatch_loop_counters(work->loop, &counters);
    const int64_t now_ns = clock_monotonic_ns();
    const double seconds = (double)(now_ns - work->shown_ns) / CLOCK_SECOND_NS;
    const double rate = seconds > 0 ? (double)(evaluation->rows - work->shown_rows) / seconds : 0;
    work->shown_ns = now_ns;
    work->shown_rows = evaluation->rows;

    char share[64] = "", designs[16], speed[16], left[32];
    const uint64_t size = source_size(work->table->source);
    const double done = size > 0 ? (double)evaluation->bytes_read / (double)size : 0;
    if (done > 0 && rate > 0)
        g_snprintf(share, sizeof share, " (%.0f %%, about %s left)", 100 * done,
                   progress_duration((double)evaluation->rows * (1 - done) / done / rate, left));
    const double good =
        evaluation->rows > 0 ? (double)evaluation->sums.good / (double)evaluation->rows : 0;
    log_progress("%s designs%s, %s/s | %.3g %% good | %u worker%s",
                 progress_number((double)evaluation->rows, designs), share,
                 progress_number(rate, speed), 100 * good, counters.workers,
                 counters.workers == 1 ? "" : "s");
    return G_SOURCE_CONTINUE;
}

// ---- Life ----

// Reads what earlier sessions evaluated once more, to see that it is still the same.
static enum status skip_done(struct evaluate *evaluate, struct digest digest, struct error *error)
{
    struct source *source = evaluate->source;
    const struct evaluation *evaluation = evaluate->evaluation;
    uint64_t end = 0;
    while (end < evaluation->bytes_read && !source_ended(source)) {
        struct source_piece piece;
        enum status status = source_piece(source, &piece, error);
        if (status == STATUS_OK && piece.text == NULL)
            status = source_fill(source, error);
        if (status != STATUS_OK)
            return status;
        if (piece.text == NULL)
            continue;
        const struct digest own = digest_of(piece.text, piece.size);
        digest = evaluation_digest(&digest, &own);
        end = piece.end;
        g_free(piece.text);
    }
    if (end == evaluation->bytes_read && digest_equal(&digest, &evaluation->digest))
        return STATUS_OK;
    return error_set(error, STATUS_INVALID,
                     "%s: expected the table with which this evaluation was begun; among its first "
                     "%" PRIu64 " bytes, which are evaluated already, something has changed",
                     source_name(source), evaluation->bytes_read);
}

enum status evaluate_open(struct evaluate *evaluate, struct evaluation *evaluation,
                          struct error *error)
{
    *evaluate = (struct evaluate){.evaluation = evaluation};
    struct source_piece header = {0};
    enum status status = source_open(&evaluate->source, evaluation->designs, error);
    if (status == STATUS_OK)
        status = source_header(evaluate->source, &header, error);
    if (status == STATUS_OK)
        status = designs_layout_read(&evaluate->layout, &evaluation->scenario,
                                     source_name(evaluate->source), header.line, header.text,
                                     header.size, error);
    if (status == STATUS_OK) {
        const struct digest begun = digest_of(header.text, header.size);
        if (evaluation->bytes_read > 0) {
            // The header is no piece, but counts as the first of them.
            status =
                header.end == evaluation->bytes_read && digest_equal(&begun, &evaluation->digest)
                    ? STATUS_OK
                    : skip_done(evaluate, begun, error);
        } else {
            evaluation->digest = begun;
            evaluation->bytes_read = header.end;
        }
    }
    g_free(header.text);
    if (status != STATUS_OK)
        evaluate_close(evaluate);
    return status;
}

void evaluate_close(struct evaluate *evaluate)
{
    designs_layout_fini(&evaluate->layout);
    source_close(evaluate->source);
    *evaluate = (struct evaluate){0};
}

// How many designs a batch may have, by the messages that carry them and what comes of them.
static enum status batch_designs(const struct work *work, uint32_t *designs, struct error *error)
{
    const size_t there = wire_payload_max(work->wire, WIRE_DESIGN_BATCH) / sizeof(double);
    const size_t back = wire_payload_max(work->wire, WIRE_VALUE_BATCH) / sizeof(double);
    *designs = (uint32_t)MIN(MIN(there / variable_count(work), back / outcome_count(work)),
                             PROTOCOL_BATCH_SAMPLES_MAX);
    if (*designs > 0)
        return STATUS_OK;
    const uint32_t values = MAX(variable_count(work), outcome_count(work));
    return error_set(error, STATUS_INVALID,
                     "a design with %u values in and %u out does not fit a message: expected "
                     "--mtu %zu or more, for all workers too",
                     variable_count(work), outcome_count(work),
                     WIRE_MTU_DEFAULT + (values + 100) * sizeof(double));
}

static enum status end_state(struct work *work, enum status status)
{
    struct error unwritten = {0};
    if (evaluation_end(work->table->evaluation, run_status_after(status, true),
                       clock_monotonic_ns(), &unwritten) == STATUS_OK ||
        status != STATUS_OK)
        return status;
    *work->error = unwritten;
    return unwritten.status;
}

static gboolean note_progress(gpointer user)
{
    struct work *work = user;
    const enum status status =
        evaluation_note(work->table->evaluation, clock_monotonic_ns(), work->error);
    if (status != STATUS_OK)
        fail(work, status);
    return G_SOURCE_CONTINUE;
}

static enum status run_loop(struct work *work)
{
    const struct evaluation *evaluation = work->table->evaluation;
    guint progress = 0;
    const long long interval_ns = log_progress_interval_ns();
    if (interval_ns != INT64_MAX)
        progress = g_timeout_add((guint)(interval_ns / CLOCK_MILLISECOND_NS), show_progress, work);
    const guint notes = g_timeout_add(NOTE_INTERVAL_MS, note_progress, work);
    text_server_offer(dispatch_loop_texts(work->loop), &evaluation->scenario.digest,
                      evaluation->scenario.text, evaluation->scenario.text_size);
    watch_table(work);
    const enum status status = dispatch_loop_run(work->loop, evaluation->directory, work->error);
    if (work->reader != 0)
        g_source_remove(work->reader);
    g_source_remove(notes);
    if (progress != 0)
        g_source_remove(progress);
    log_progress_end();
    tell_end_state(work, status);
    return status;
}

enum status evaluate_run(struct evaluate *evaluate, struct wire *wire,
                         const struct coordinator_settings *settings, struct error *error)
{
    static const struct dispatch_loop_calls calls = {
        .send = send_batch,
        .count = count_batch,
        .finished = piece_sampled,
        .status = tell_status,
    };
    struct evaluation *evaluation = evaluate->evaluation;
    struct work *work = g_new0(struct work, 1);
    work->table = evaluate;
    work->wire = wire;
    work->fingerprint = fingerprint_compute();
    work->run = identity_random();
    work->next = evaluation->rows + 1;
    work->shown_ns = clock_monotonic_ns();
    work->shown_rows = evaluation->rows;
    work->error = error;
    struct schedule_settings schedule = schedule_settings_default();
    enum status status =
        batch_designs(work, &schedule.batch_samples_max[VERDICT_DETAIL_FULL], error);
    if (status == STATUS_OK)
        status = dispatch_loop_create(&work->loop, wire, work->run, settings, &schedule, &calls,
                                      work, error);
    if (status == STATUS_OK)
        status = wire_subscribe(wire, WIRE_VALUE_BATCH, heard_values, work, error);
    if (status == STATUS_OK)
        status =
            pool_create(&work->pool, settings->threads, work_on, threads_are_done, work, error);
    if (status == STATUS_OK)
        status = run_loop(work);
    pool_free(work->pool);
    status = end_state(work, status);
    dispatch_loop_free(work->loop);
    for (int i = 0; i < EVALUATE_PIECES_MAX; i++)
        piece_free(&work->pieces[i]);
    g_free(work);
    return status;
}
