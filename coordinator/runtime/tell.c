#include "coordinator/runtime/tell.h"

#include "common/base/clock.h"
#include "coordinator/runtime/run_status.h"

#include "sobox_cases_t.h"
#include "sobox_search_status_t.h"
#include "sobox_step_status_t.h"

#include <float.h>
#include <glib.h>
#include <math.h>
#include <string.h>

enum {
    SEARCH_BURST = 32,   // open searches told of in a tick; thousands take turns
    RETOLD_BURST = 4,    // done and failed ones: a thousand in half a minute
    STEP_BURST = 4,      // messages of samples in a tick
    STEP_QUEUE_MAX = 16, // messages that wait for their tick; further steps are not told of
    SAMPLES_TOLD = 200,  // of a step at most: as many points as a picture can show
    CASES_PAUSE = 3,     // ticks between two messages of names, once all cases were named
    VALUE_SIZE = 96,     // [bytes] of a case's value on an axis; longer ones are cut short
};

// The same search's samples are not told of again within this time.
static const int64_t STEP_INTERVAL_NS = 200 * CLOCK_MILLISECOND_NS;

struct tell {
    const struct run *run;
    struct wire *wire;
    struct digest fingerprint;
    uint32_t told;   // the open search whose turn it was last
    uint32_t retold; // likewise of those that are not open
    uint32_t named;  // the case whose turn it is to be named
    uint32_t rounds; // in which all cases were named
    uint32_t pause;  // ticks in later rounds
    char **axes;     // paths; NULL where the run is no sweep
    GQueue parts;    // struct part *, messages of samples that wait
    int allowance;   // messages of samples that may still be sent in this tick
};

// A message of samples, and the bytes it points to.
struct part {
    sobox_step_status_t message;
    uint8_t packed[];
};

struct tell *tell_create(const struct run *run, struct wire *wire, const struct digest *fingerprint)
{
    struct tell *tell = g_new(struct tell, 1);
    *tell = (struct tell){
        .run = run,
        .wire = wire,
        .fingerprint = *fingerprint,
        .parts = G_QUEUE_INIT,
        .allowance = STEP_BURST,
    };
    struct error ignored = {0};
    // A journal that cannot be read says so where it is needed; watching does without.
    if (journal_read_axes(run->journal, &tell->axes, &ignored) != STATUS_OK)
        tell->axes = NULL;
    if (tell->axes != NULL && tell->axes[0] == NULL)
        g_clear_pointer(&tell->axes, g_strfreev);
    return tell;
}

void tell_free(struct tell *tell)
{
    if (tell == NULL)
        return;
    g_queue_clear_full(&tell->parts, g_free);
    g_strfreev(tell->axes);
    g_free(tell);
}

static void send_parts(struct tell *tell)
{
    while (tell->allowance > 0 && !g_queue_is_empty(&tell->parts)) {
        struct part *part = g_queue_pop_head(&tell->parts);
        part->message.packed = part->packed;
        (void)!wire_publish(tell->wire, WIRE_STEP_STATUS, &part->message);
        g_free(part);
        tell->allowance--;
    }
}

void tell_run(struct tell *tell, enum run_state state, const struct schedule_counters *counters)
{
    const struct run *run = tell->run;
    const struct run_status status = {
        .run = run->record.id,
        .name = run->record.name,
        .fingerprint = &tell->fingerprint,
        .state = state,
        .searches = run->record.search_count,
        .searches_done = run->done_count,
        .elapsed_ns = run_elapsed_ns(run, clock_monotonic_ns()),
    };
    // What waits for its tick has none any more.
    if (protocol_run_ended(state)) {
        tell->allowance = (int)tell->parts.length;
        send_parts(tell);
    }
    run_status_publish(tell->wire, &status, counters);
}

// ---- Searches ----

// Sends the message with as many of the box's bounds from `first` on as fit; returns the variable
// that follows them.
static uint32_t publish_search(struct tell *tell, sobox_search_status_t *message,
                               const struct box *box, uint32_t first)
{
    const size_t payload = wire_payload_max(tell->wire, WIRE_SEARCH_STATUS);
    const uint32_t count = (uint32_t)MIN(box->count - first, payload / (2 * sizeof(double)));
    double *bounds = g_new(double, 2 * (size_t)count);
    if (count > 0) { // a search that could not be carried out has no box
        memcpy(bounds, box->lower + first, count * sizeof *bounds);
        memcpy(bounds + count, box->upper + first, count * sizeof *bounds);
    }
    message->variables = (int32_t)box->count;
    message->first_variable = (int32_t)first;
    message->bound_count = (int32_t)(2 * count);
    message->bounds = bounds;
    (void)!wire_publish(tell->wire, WIRE_SEARCH_STATUS, message);
    g_free(bounds);
    return first + count;
}

static sobox_search_status_t open_status(const struct tell *tell, const struct run_search *search,
                                         struct search_progress *progress)
{
    struct search_result result;
    search_progress(search->search, progress);
    search_result(search->search, &result);
    sobox_search_status_t message = {
        .header.run = (int64_t)tell->run->record.id,
        .search = (int32_t)search->index,
        .standing =
            result.status == SEARCH_STATUS_RUNNING ? SEARCH_STANDING_OPEN : SEARCH_STANDING_DONE,
        .phase = (int8_t)progress->phase,
        .status = (int8_t)result.status,
        .step = (int32_t)progress->step,
        .step_count = (int32_t)progress->step_count,
        .evaluations = (int64_t)progress->evaluations,
        .good_share = progress->good_share,
        .log_volume = fmax(progress->log_volume, -DBL_MAX),
        .purity_lower95 = result.purity.lower95,
    };
    memcpy(message.scenario, search->scenario.digest.bytes, DIGEST_SIZE);
    return message;
}

static void tell_open(struct tell *tell, struct run_search *search)
{
    struct search_progress progress;
    sobox_search_status_t message = open_status(tell, search, &progress);
    const uint32_t next = publish_search(tell, &message, progress.box, search->told_variable);
    search->told_variable = next < progress.box->count ? next : 0;
}

void tell_end(struct tell *tell, struct run_search *search)
{
    struct search_progress progress;
    sobox_search_status_t message = open_status(tell, search, &progress);
    uint32_t next = 0;
    do
        next = publish_search(tell, &message, progress.box, next);
    while (next < progress.box->count);
}

static void tell_searches(struct tell *tell)
{
    const struct run *run = tell->run;
    uint32_t burst = SEARCH_BURST;
    for (uint32_t i = 0; i < run->record.search_count && burst > 0; i++) {
        tell->told = (tell->told + 1) % run->record.search_count;
        struct run_search *search = run->open[tell->told];
        if (search == NULL || !search->active)
            continue;
        tell_open(tell, search);
        burst--;
    }
}

// What the journal says of a finished search.
static enum search_status status_of(const struct journal_search *record)
{
    enum search_status status = SEARCH_STATUS_RUNNING;
    if (record->finished)
        (void)protocol_status_of(record->status, &status);
    return status;
}

// Tells of a search that is not open, from the journal.
static void retell(struct tell *tell, uint32_t index)
{
    struct journal_search record;
    struct error ignored = {0};
    if (journal_read_search(tell->run->journal, index, &record, &ignored) != STATUS_OK)
        return;
    sobox_search_status_t message = {
        .header.run = (int64_t)tell->run->record.id,
        .search = (int32_t)index,
        .standing = record.finished ? SEARCH_STANDING_DONE : SEARCH_STANDING_FAILED,
        .phase = record.finished ? SEARCH_PHASE_DONE : SEARCH_PHASE_SEEK,
        .status = (int8_t)status_of(&record),
        .step = (int32_t)record.steps,
        .step_count = (int32_t)record.steps,
        .evaluations = (int64_t)record.evaluations,
        .good_share = record.purity_estimate,
        .log_volume = record.finished ? fmax(record.log_volume, -DBL_MAX) : -DBL_MAX,
        .purity_lower95 = record.purity_lower95,
    };
    memcpy(message.scenario, record.scenario.bytes, DIGEST_SIZE);
    uint32_t next = 0;
    do
        next = publish_search(tell, &message, &record.box, next);
    while (next < record.box.count);
    journal_search_fini(&record);
}

// Those that are done or have failed, for monitors that came after; one that waits has nothing to
// tell but its name.
static void retell_searches(struct tell *tell)
{
    const struct run *run = tell->run;
    const uint32_t count = run->record.search_count;
    uint32_t burst = RETOLD_BURST;
    for (uint32_t i = 0; count > 1 && i < count && burst > 0; i++) {
        tell->retold = (tell->retold + 1) % count;
        const uint8_t standing = run->standings[tell->retold];
        if (standing != SEARCH_STANDING_DONE && standing != SEARCH_STANDING_FAILED)
            continue;
        retell(tell, tell->retold);
        burst--;
    }
}

// ---- Cases ----

static void publish_cases(struct tell *tell, int32_t first, const GByteArray *texts)
{
    sobox_cases_t message = {
        .header.run = (int64_t)tell->run->record.id,
        .first = first,
        .columns = (int32_t)g_strv_length(tell->axes) + 1,
        .text_size = (int32_t)texts->len,
        .text = texts->data,
    };
    (void)!wire_publish(tell->wire, WIRE_CASES, &message);
}

// Appends a text with its NUL, at most `size` bytes; what a screen cannot show becomes a space, and
// no letter is cut in two.
static void append_text(GByteArray *texts, const char *text, size_t size)
{
    char *copy = g_strndup(text, size - 1);
    const char *end;
    if (!g_utf8_validate(copy, -1, &end))
        copy[end - copy] = '\0';
    for (char *c = copy; *c != '\0'; c = g_utf8_next_char(c)) {
        if (g_unichar_iscntrl(g_utf8_get_char(c)))
            memset(c, ' ', (size_t)(g_utf8_next_char(c) - c));
    }
    g_byte_array_append(texts, (const guint8 *)copy, (guint)strlen(copy) + 1);
    g_free(copy);
}

static bool append_case(struct tell *tell, GByteArray *texts, uint32_t index)
{
    struct journal_search record;
    struct error ignored = {0};
    char **values = NULL;
    if (journal_read_search(tell->run->journal, index, &record, &ignored) != STATUS_OK)
        return false;
    const bool whole =
        journal_read_values(tell->run->journal, index, &values, &ignored) == STATUS_OK &&
        g_strv_length(values) == g_strv_length(tell->axes);
    if (whole) {
        append_text(texts, record.name, JOURNAL_NAME_SIZE);
        for (char **value = values; *value != NULL; value++)
            append_text(texts, *value, VALUE_SIZE);
    }
    g_strfreev(values);
    journal_search_fini(&record);
    return whole;
}

// The paths of the axes at the start of each round, then cases, as many as fit a message. The first
// round is quick, the later ones are for those who come late.
static void tell_cases(struct tell *tell)
{
    if (tell->axes == NULL || (tell->rounds > 0 && ++tell->pause % CASES_PAUSE != 0))
        return;
    const size_t payload = wire_payload_max(tell->wire, WIRE_CASES);
    GByteArray *texts = g_byte_array_new();
    if (tell->named == 0) {
        append_text(texts, "case", VALUE_SIZE);
        for (char **axis = tell->axes; *axis != NULL; axis++)
            append_text(texts, *axis, VALUE_SIZE);
        if (texts->len <= payload)
            publish_cases(tell, -1, texts);
        g_byte_array_set_size(texts, 0);
    }
    const uint32_t first = tell->named;
    guint whole = 0; // bytes of the cases that fit
    while (tell->named < tell->run->record.search_count && append_case(tell, texts, tell->named) &&
           texts->len <= payload) {
        whole = texts->len;
        tell->named++;
    }
    g_byte_array_set_size(texts, whole);
    if (whole > 0)
        publish_cases(tell, (int32_t)first, texts);
    else
        tell->named++; // one that fits no message has no name here
    if (tell->named >= tell->run->record.search_count) {
        tell->named = 0;
        tell->rounds++;
    }
    g_byte_array_free(texts, TRUE);
}

// ---- Samples ----

static uint8_t *put_doubles(uint8_t *at, const double *values, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        bits = GUINT64_TO_LE(bits);
        memcpy(at, &bits, sizeof bits);
        at += sizeof bits;
    }
    return at;
}

// Margins are for the search alone.
static enum verdict_detail told_detail(enum verdict_detail detail)
{
    return detail == VERDICT_DETAIL_MARGIN ? VERDICT_DETAIL_FULL : detail;
}

// Packs the verdicts of the step's first samples, at most `room` bytes of them, into `packed`,
// which holds verdict_packed_size_max() of SAMPLES_TOLD.
static size_t pack_verdicts(const struct run_search *search, size_t room, uint32_t *count,
                            uint8_t *packed)
{
    const struct search_request *request = &search->request;
    const enum verdict_detail detail = told_detail(request->detail);
    *count = MIN(request->sampling.samples, SAMPLES_TOLD);
    size_t size = verdict_pack(search->verdicts, *count, detail, packed);
    while (size > room) {
        *count -= *count / 8 + 1;
        size = verdict_pack(search->verdicts, *count, detail, packed);
    }
    return size;
}

// Cuts a step into messages: verdicts first, then bounds of as many variables as each has room for.
static void queue_step(struct tell *tell, const struct run_search *search,
                       const struct search_progress *progress)
{
    const uint32_t variables = search->scenario.design_space.count;
    const size_t payload = wire_payload_max(tell->wire, WIRE_STEP_STATUS);
    const size_t row = 4 * sizeof(double);
    uint8_t verdicts[3 * SAMPLES_TOLD + SAMPLES_TOLD / 8 + 1];
    uint32_t count;
    // With few samples told of, half a message holds them; a box of usual size has the other half.
    size_t size = pack_verdicts(search, payload / 2, &count, verdicts);
    for (uint32_t first = 0; first < variables;) {
        const uint32_t window = (uint32_t)MIN(variables - first, (payload - size) / row);
        struct part *part = g_malloc(sizeof *part + size + window * row);
        part->message = (sobox_step_status_t){
            .header.run = (int64_t)tell->run->record.id,
            .seed = (int64_t)search->request.sampling.seed,
            .search = (int32_t)search->index,
            .step = (int32_t)search->request.sampling.step,
            .phase = (int8_t)search->request.phase,
            .sampling = (int8_t)search->request.sampling.method,
            .detail = (int8_t)told_detail(search->request.detail),
            .samples = (int32_t)search->request.sampling.samples,
            .good = (int32_t)search_last_step(search->search)->good,
            .count = (int32_t)count,
            .variables = (int32_t)variables,
            .first_variable = (int32_t)first,
            .window = (int32_t)window,
            .packed_size = (int32_t)(size + window * row),
        };
        memcpy(part->message.scenario, search->scenario.digest.bytes, DIGEST_SIZE);
        memcpy(part->packed, verdicts, size);
        uint8_t *at = part->packed + size;
        at = put_doubles(at, search->sampled.lower + first, window);
        at = put_doubles(at, search->sampled.upper + first, window);
        at = put_doubles(at, progress->box->lower + first, window);
        put_doubles(at, progress->box->upper + first, window);
        g_queue_push_tail(&tell->parts, part);
        first += window;
        size = 0;
        count = 0;
    }
}

void tell_step(struct tell *tell, struct run_search *search, int64_t now_ns)
{
    struct search_progress progress;
    search_progress(search->search, &progress);
    const bool phase_ends = progress.phase != search->request.phase;
    if (tell->parts.length >= STEP_QUEUE_MAX ||
        (!phase_ends && now_ns - search->told_ns < STEP_INTERVAL_NS))
        return;
    search->told_ns = now_ns;
    queue_step(tell, search, &progress);
    send_parts(tell);
}

void tell_tick(struct tell *tell)
{
    tell->allowance = STEP_BURST;
    send_parts(tell);
    tell_searches(tell);
    retell_searches(tell);
    tell_cases(tell);
}
