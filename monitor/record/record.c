#include "monitor/record/record.h"

#include "coordinator/journal/journal.h"

#include <float.h>
#include <glib.h>
#include <math.h>
#include <string.h>

enum { SAMPLES_TOLD = 200 }; // of a step, as a coordinator tells of

// What was told of a search.
struct told {
    uint32_t steps;
    uint32_t sampled; // steps whose samples were told of
    uint64_t evaluations;
    bool finished;
};

struct record {
    char *folder;
    struct feed *feed;
    struct texts *texts;
    GArray *told; // struct told, one a search
    uint64_t run; // its number
    bool named;   // the cases of a sweep were told of
    int32_t sequence;
    bool goes_on;
};

// A search that is being read.
struct reading {
    struct record *record;
    const struct journal_run *run;
    const struct journal_search *search;
    struct told *told;
    uint32_t step_count; // estimate of the total
    int64_t now_ns;
};

struct record *record_open(const char *folder, struct feed *feed, struct texts *texts)
{
    struct record *record = g_new0(struct record, 1);
    *record = (struct record){
        .folder = g_strdup(folder),
        .feed = feed,
        .texts = texts,
        .told = g_array_new(FALSE, TRUE, sizeof(struct told)),
    };
    return record;
}

void record_close(struct record *record)
{
    if (record == NULL)
        return;
    g_array_free(record->told, TRUE);
    g_free(record->folder);
    g_free(record);
}

bool record_goes_on(const struct record *record)
{
    return record->goes_on;
}

// ---- Words of the journal as numbers of the messages ----

// A word that a later sobox may have is shown as the first one.
static enum search_phase phase_of(const char *name)
{
    enum search_phase phase = SEARCH_PHASE_SEEK;
    (void)protocol_phase_of(name, &phase);
    return phase;
}

static enum search_status status_of(const char *name)
{
    enum search_status status = SEARCH_STATUS_RUNNING;
    (void)protocol_status_of(name, &status);
    return status;
}

// Which points a step drew: the journal does not say, it follows from the phase (search.c).
static enum sampling_method sampling_of(enum search_phase phase, const struct scenario *scenario)
{
    switch (phase) {
    case SEARCH_PHASE_SEEK:
        return SAMPLING_METHOD_LATIN_HYPERCUBE;
    case SEARCH_PHASE_EXPLORE:
    case SEARCH_PHASE_CONSOLIDATE:
        return scenario->search.sampling;
    case SEARCH_PHASE_CERTIFY:
    case SEARCH_PHASE_EXPLAIN:
    case SEARCH_PHASE_DONE:
        break;
    }
    return SAMPLING_METHOD_UNIFORM;
}

// ---- Telling the feed ----

static sobox_header_t next_header(struct record *record, const struct journal_run *run)
{
    return (sobox_header_t){
        .sequence = record->sequence++,
        .sender = 1, // nobody else tells this feed anything
        .run = (int64_t)run->id,
    };
}

static void tell_search(const struct reading *reading, sobox_search_status_t *message,
                        const struct box *box)
{
    message->header = next_header(reading->record, reading->run);
    message->search = (int32_t)reading->search->index;
    message->evaluations = (int64_t)reading->told->evaluations;
    memcpy(message->scenario, reading->search->scenario.bytes, DIGEST_SIZE);
    double *bounds = g_new(double, 2 * (size_t)box->count);
    memcpy(bounds, box->lower, box->count * sizeof *bounds);
    memcpy(bounds + box->count, box->upper, box->count * sizeof *bounds);
    message->variables = (int32_t)box->count;
    message->bound_count = (int32_t)(2 * box->count);
    message->bounds = bounds;
    feed_search_heard(reading->record->feed, message, reading->now_ns);
    g_free(bounds);
}

static enum status tell_step(void *user, const struct journal_step *step, struct error *error)
{
    (void)error;
    const struct reading *reading = user;
    if (step->step < reading->told->steps)
        return STATUS_OK;
    reading->told->steps = step->step + 1;
    reading->told->evaluations += step->samples;
    sobox_search_status_t message = {
        .standing = SEARCH_STANDING_OPEN,
        .phase = (int8_t)phase_of(step->phase),
        .status = SEARCH_STATUS_RUNNING,
        .step = (int32_t)step->step + 1,
        .step_count = (int32_t)MAX(reading->step_count, step->step + 1),
        .good_share = step->samples > 0 ? (double)step->good / step->samples : 0,
        .log_volume = fmax(step->log_volume, -DBL_MAX),
    };
    tell_search(reading, &message, step->box);
    return STATUS_OK;
}

static void tell_result(const struct reading *reading)
{
    const struct journal_search *search = reading->search;
    reading->told->finished = true;
    reading->told->evaluations = search->evaluations;
    sobox_search_status_t message = {
        .standing = SEARCH_STANDING_DONE,
        .phase = SEARCH_PHASE_DONE,
        .status = (int8_t)status_of(search->status),
        .step = (int32_t)search->steps,
        .step_count = (int32_t)search->steps,
        .good_share = search->purity_estimate,
        .log_volume = fmax(search->log_volume, -DBL_MAX),
        .purity_lower95 = search->purity_lower95,
    };
    tell_search(reading, &message, &search->box);
}

// ---- Samples ----

static uint8_t *put_bounds(uint8_t *at, const double *values, uint32_t count)
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

// The journal keeps the box that was sampled; the one after the step is not there.
static enum status tell_samples(void *user, const struct journal_step *step, struct error *error)
{
    (void)error;
    const struct reading *reading = user;
    const struct journal_search *search = reading->search;
    const struct scenario *scenario = texts_find(reading->record->texts, &search->scenario);
    if (step->step < reading->told->sampled || scenario == NULL || step->samples == 0)
        return STATUS_OK;
    reading->told->sampled = step->step + 1;
    const enum search_phase phase = phase_of(step->phase);
    const uint32_t variables = step->box->count;
    const uint32_t count = MIN(step->samples, SAMPLES_TOLD);
    uint8_t *packed =
        g_malloc(verdict_packed_size_max(count, step->detail) + variables * 4 * sizeof(double));
    const size_t size = verdict_pack(step->verdicts, count, step->detail, packed);
    uint8_t *at = packed + size;
    for (int boxes = 0; boxes < 2; boxes++) {
        at = put_bounds(at, step->box->lower, variables);
        at = put_bounds(at, step->box->upper, variables);
    }
    sobox_step_status_t message = {
        .header = next_header(reading->record, reading->run),
        .seed = (int64_t)search->seed,
        .search = (int32_t)search->index,
        .step = (int32_t)step->step,
        .phase = (int8_t)phase,
        .sampling = (int8_t)sampling_of(phase, scenario),
        .detail = (int8_t)step->detail,
        .samples = (int32_t)step->samples,
        .good = (int32_t)step->good,
        .count = (int32_t)count,
        .variables = (int32_t)variables,
        .window = (int32_t)variables,
        .packed_size = (int32_t)(at - packed),
        .packed = packed,
    };
    memcpy(message.scenario, search->scenario.bytes, DIGEST_SIZE);
    feed_step_heard(reading->record->feed, &message, reading->now_ns);
    g_free(packed);
    return STATUS_OK;
}

static enum status read_samples(struct record *record, struct journal *journal, uint32_t index,
                                int64_t now_ns, struct error *error)
{
    struct journal_run run;
    struct journal_search search = {0};
    enum status status = journal_read_run(journal, &run, error);
    if (status == STATUS_OK)
        status = journal_read_search(journal, index, &search, error);
    struct reading reading = {
        .record = record,
        .run = &run,
        .search = &search,
        .told = &g_array_index(record->told, struct told, index),
        .now_ns = now_ns,
    };
    if (status == STATUS_OK) {
        texts_learn(record->texts, &search.scenario, search.text, search.text_size);
        status = journal_read_steps(journal, index, tell_samples, &reading, error);
    }
    journal_search_fini(&search);
    return status;
}

enum status record_read_samples(struct record *record, uint32_t index, int64_t now_ns,
                                struct error *error)
{
    if (index >= record->told->len)
        return STATUS_OK;
    struct told *told = &g_array_index(record->told, struct told, index);
    const struct feed_search *search = feed_search_find(record->feed, record->run, index);
    // Samples of a search that nobody looked at for long are gone, and are told of again.
    if (search != NULL && search->album == NULL)
        told->sampled = 0;
    if (search == NULL || told->sampled >= told->steps)
        return STATUS_OK;
    struct journal *journal = NULL;
    enum status status = journal_open(&journal, record->folder, JOURNAL_READ, error);
    if (status == STATUS_OK)
        status = read_samples(record, journal, index, now_ns, error);
    journal_close(journal);
    return status;
}

// ---- Steps and results ----

static uint32_t steps_expected(struct texts *texts, const struct digest *digest)
{
    const struct scenario *scenario = texts_find(texts, digest);
    // Seeking and certifying take some steps more.
    return scenario != NULL
               ? scenario->search.exploration_steps + scenario->search.consolidation_steps + 2
               : 0;
}

static enum status read_search(struct record *record, struct journal *journal,
                               const struct journal_run *run, uint32_t index, int64_t now_ns,
                               struct error *error)
{
    struct told *told = &g_array_index(record->told, struct told, index);
    if (told->finished)
        return STATUS_OK;
    struct journal_search search = {0};
    enum status status = journal_read_search(journal, index, &search, error);
    if (status != STATUS_OK)
        return status;
    texts_learn(record->texts, &search.scenario, search.text, search.text_size);
    struct reading reading = {
        .record = record,
        .run = run,
        .search = &search,
        .told = told,
        .step_count = steps_expected(record->texts, &search.scenario),
        .now_ns = now_ns,
    };
    status = journal_read_steps(journal, index, tell_step, &reading, error);
    if (status == STATUS_OK && search.finished)
        tell_result(&reading);
    journal_search_fini(&search);
    return status;
}

static void tell_run(struct record *record, const struct journal_run *run, int64_t now_ns)
{
    sobox_run_status_t message = {
        .header = next_header(record, run),
        .state = (int8_t)run->state,
        .searches = (int32_t)run->search_count,
        .elapsed_ns = run->elapsed_ns,
    };
    for (guint i = 0; i < record->told->len; i++) {
        const struct told *told = &g_array_index(record->told, struct told, i);
        message.samples += (int64_t)told->evaluations;
        message.searches_done += told->finished;
    }
    g_strlcpy((char *)message.name, run->name, sizeof message.name);
    feed_run_heard(record->feed, &message, now_ns);
}

// ---- Cases ----

static void append_texts(GByteArray *to, const char *first, char *const *rest)
{
    g_byte_array_append(to, (const guint8 *)first, (guint)strlen(first) + 1);
    for (; *rest != NULL; rest++)
        g_byte_array_append(to, (const guint8 *)*rest, (guint)strlen(*rest) + 1);
}

static void tell_texts(struct record *record, const struct journal_run *run, int32_t first,
                       guint columns, const GByteArray *texts, int64_t now_ns)
{
    const sobox_cases_t message = {
        .header = next_header(record, run),
        .first = first,
        .columns = (int32_t)columns,
        .text_size = (int32_t)texts->len,
        .text = texts->data,
    };
    feed_cases_heard(record->feed, &message, now_ns);
}

// The names and values of all cases: they never change.
static enum status tell_cases(struct record *record, struct journal *journal,
                              const struct journal_run *run, int64_t now_ns, struct error *error)
{
    char **axes = NULL;
    GByteArray *texts = g_byte_array_new();
    enum status status = journal_read_axes(journal, &axes, error);
    const guint columns = status == STATUS_OK ? g_strv_length(axes) + 1 : 0;
    record->named = true;
    if (columns > 1) {
        append_texts(texts, "case", axes);
        tell_texts(record, run, -1, columns, texts, now_ns);
    }
    const uint32_t count = columns > 1 ? MIN(run->search_count, CASES_KNOWN_MAX) : 0;
    for (uint32_t i = 0; status == STATUS_OK && i < count; i++) {
        struct journal_search search = {0};
        char **values = NULL;
        status = journal_read_search(journal, i, &search, error);
        if (status == STATUS_OK)
            status = journal_read_values(journal, i, &values, error);
        if (status == STATUS_OK && g_strv_length(values) + 1 == columns) {
            g_byte_array_set_size(texts, 0);
            append_texts(texts, search.name, values);
            tell_texts(record, run, (int32_t)i, columns, texts, now_ns);
        }
        g_strfreev(values);
        journal_search_fini(&search);
    }
    g_byte_array_free(texts, TRUE);
    g_strfreev(axes);
    return status;
}

enum status record_read(struct record *record, int64_t now_ns, struct error *error)
{
    struct journal *journal = NULL;
    struct journal_run run;
    // A journal shows the moment at which it was opened.
    enum status status = journal_open(&journal, record->folder, JOURNAL_READ, error);
    if (status == STATUS_OK)
        status = journal_read_run(journal, &run, error);
    if (status == STATUS_OK) {
        g_array_set_size(record->told, run.search_count);
        for (uint32_t i = 0; status == STATUS_OK && i < run.search_count; i++)
            status = read_search(record, journal, &run, i, now_ns, error);
    }
    if (status == STATUS_OK) {
        record->run = run.id;
        tell_run(record, &run, now_ns);
        if (!record->named)
            status = tell_cases(record, journal, &run, now_ns, error);
    }
    if (status == STATUS_OK) {
        record->goes_on = run.state == RUN_STATE_RUNNING;
    }
    journal_close(journal);
    return status;
}
