#include "monitor/record/record.h"

#include "common/base/log.h"
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
    bool goes_on;
    bool unknown_said; // that samples of this file are not shown
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

// ---- Telling the feed ----

static void tell_search(const struct reading *reading, sobox_search_status_t *message,
                        const struct box *box)
{
    message->search = (int32_t)reading->search->index;
    message->evaluations = (int64_t)reading->told->evaluations;
    memcpy(message->scenario, reading->search->scenario.bytes, DIGEST_SIZE);
    feed_search_read(reading->record->feed, reading->run->id, message, box, reading->now_ns);
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

// Said once, where somebody looks.
static void note_unknown_sampling(struct record *record)
{
    if (!record->unknown_said)
        log_note("%s/run.db: an earlier sobox wrote it, which did not keep how steps were sampled: "
                 "their samples are not shown",
                 record->folder);
    record->unknown_said = true;
}

// The journal keeps the box that was sampled; the one after the step is not there.
static enum status tell_samples(void *user, const struct journal_step *step, struct error *error)
{
    (void)error;
    const struct reading *reading = user;
    const struct journal_search *search = reading->search;
    if (step->step < reading->told->sampled || step->samples == 0)
        return STATUS_OK;
    reading->told->sampled = step->step + 1;
    if (!step->sampling_known) {
        note_unknown_sampling(reading->record);
        return STATUS_OK;
    }
    if (!sampling_of_points(step->sampling))
        return STATUS_OK; // pictures are of points: where a curve stands takes the scenario's
                          // springs
    const uint32_t count = MIN(step->samples, SAMPLES_TOLD);
    struct album_picture *picture = album_picture(count, step->box->count);
    picture->sampling = (struct sampling){.seed = search->seed,
                                          .step = step->step,
                                          .samples = step->samples,
                                          .method = step->sampling};
    picture->scenario = search->scenario;
    picture->phase = phase_of(step->phase);
    picture->detail = step->detail;
    picture->good = step->good;
    memcpy(picture->verdicts, step->verdicts, count * sizeof *picture->verdicts);
    box_assign(&picture->sampled, step->box);
    box_assign(&picture->box, step->box);
    feed_step_read(reading->record->feed, reading->run->id, search->index, picture,
                   reading->now_ns);
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
    feed_run_read(record->feed, run->id, &message, now_ns);
}

// ---- Cases ----

// A row: a text, then those of a list.
static void tell_row(struct record *record, const struct journal_run *run, int32_t index,
                     const char *first, char **rest)
{
    GPtrArray *texts = g_ptr_array_new();
    g_ptr_array_add(texts, (char *)first);
    for (char **text = rest; *text != NULL; text++)
        g_ptr_array_add(texts, *text);
    g_ptr_array_add(texts, NULL);
    feed_case_read(record->feed, run->id, index, (char *const *)texts->pdata);
    g_ptr_array_unref(texts);
}

static enum status tell_case(struct record *record, struct journal *journal,
                             const struct journal_run *run, uint32_t index, guint axes,
                             struct error *error)
{
    struct journal_search search = {0};
    char **values = NULL;
    enum status status = journal_read_search(journal, index, &search, error);
    if (status == STATUS_OK)
        status = journal_read_values(journal, index, &values, error);
    if (status == STATUS_OK && g_strv_length(values) == axes)
        tell_row(record, run, (int32_t)index, search.name, values);
    g_strfreev(values);
    journal_search_fini(&search);
    return status;
}

// The names and values of all cases: they never change.
static enum status tell_cases(struct record *record, struct journal *journal,
                              const struct journal_run *run, struct error *error)
{
    char **axes = NULL;
    enum status status = journal_read_axes(journal, &axes, error);
    const guint count = status == STATUS_OK ? g_strv_length(axes) : 0;
    record->named = true;
    if (count > 0)
        tell_row(record, run, -1, "case", axes);
    const uint32_t cases = count > 0 ? MIN(run->search_count, CASES_KNOWN_MAX) : 0;
    for (uint32_t i = 0; status == STATUS_OK && i < cases; i++)
        status = tell_case(record, journal, run, i, count, error);
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
            status = tell_cases(record, journal, &run, error);
    }
    if (status == STATUS_OK) {
        record->goes_on = run.state == RUN_STATE_RUNNING;
    }
    journal_close(journal);
    return status;
}
