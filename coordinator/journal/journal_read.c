// Reading. A run folder may come from anywhere, so what the database says is believed only after
// its type, its size and its range have been looked at.
#include "coordinator/journal/journal_inside.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// ---- columns ----
// Each returns false when the value is not of the type and range that the writer gives it.

static bool column_u64(sqlite3_stmt *row, int column, uint64_t *value)
{
    *value = (uint64_t)sqlite3_column_int64(row, column);
    return sqlite3_column_type(row, column) == SQLITE_INTEGER;
}

static bool column_i64(sqlite3_stmt *row, int column, int64_t *value)
{
    *value = sqlite3_column_int64(row, column);
    return sqlite3_column_type(row, column) == SQLITE_INTEGER;
}

static bool column_u32(sqlite3_stmt *row, int column, uint32_t *value)
{
    uint64_t wide;
    bool fits = column_u64(row, column, &wide) && wide <= UINT32_MAX;
    *value = fits ? (uint32_t)wide : 0;
    return fits;
}

static bool column_text(sqlite3_stmt *row, int column, char *text, size_t size)
{
    const unsigned char *bytes = sqlite3_column_text(row, column);
    size_t length = (size_t)sqlite3_column_bytes(row, column);
    if (bytes == NULL || length >= size || memchr(bytes, '\0', length) != NULL ||
        !g_utf8_validate((const char *)bytes, (gssize)length, NULL))
        return false;
    memcpy(text, bytes, length);
    text[length] = '\0';
    return true;
}

static bool column_digest(sqlite3_stmt *row, int column, struct digest *digest)
{
    const void *bytes = sqlite3_column_blob(row, column);
    if (bytes == NULL || sqlite3_column_bytes(row, column) != DIGEST_SIZE)
        return false;
    memcpy(digest->bytes, bytes, DIGEST_SIZE);
    return true;
}

static bool column_doubles(sqlite3_stmt *row, int column, double *values, size_t count)
{
    const void *bytes = sqlite3_column_blob(row, column);
    if (bytes == NULL || (size_t)sqlite3_column_bytes(row, column) != count * sizeof(double))
        return false;
    journal_doubles_take(values, count, bytes);
    return true;
}

// Makes the box anew when the count differs from the one it has.
static bool column_box(sqlite3_stmt *row, int column, struct box *box)
{
    const uint8_t *bytes = sqlite3_column_blob(row, column);
    size_t size = (size_t)sqlite3_column_bytes(row, column);
    size_t count = size / (2 * sizeof(double));
    if (sqlite3_column_type(row, column) != SQLITE_BLOB || size % (2 * sizeof(double)) != 0 ||
        count > JOURNAL_VARIABLE_MAX)
        return false;
    if (box->count != count) {
        box_fini(box);
        box_init(box, (uint32_t)count);
    }
    if (count == 0)
        return true;
    journal_doubles_take(box->lower, count, bytes);
    journal_doubles_take(box->upper, count, bytes + count * sizeof(double));
    for (size_t i = 0; i < count; i++)
        if (!isfinite(box->lower[i]) || !isfinite(box->upper[i]) || box->lower[i] > box->upper[i])
            return false;
    return true;
}

// ---- the run ----

// A journal knows no run that waits: it says that it is running.
static bool parse_state(const char *name, enum run_state *state)
{
    return protocol_run_state_of(name, state) && *state != RUN_STATE_WAITING;
}

static bool run_from_row(sqlite3_stmt *row, struct journal_run *run)
{
    char state[32];
    return column_u64(row, 0, &run->id) && column_text(row, 1, run->name, sizeof run->name) &&
           column_text(row, 2, run->version, sizeof run->version) &&
           column_text(row, 3, state, sizeof state) && parse_state(state, &run->state) &&
           column_u32(row, 4, &run->search_count) && column_i64(row, 5, &run->started_ns) &&
           column_i64(row, 6, &run->elapsed_ns);
}

enum status journal_read_run(struct journal *journal, struct journal_run *run, struct error *error)
{
    *run = (struct journal_run){0};
    // A run says how many searches it has, and the searches must be there: whoever loops over them
    // may trust the count.
    sqlite3_stmt *statement = journal_prepare(
        journal,
        "SELECT id, name, version, state, search_count, started_ns, elapsed_ns FROM run"
        " WHERE search_count = (SELECT count(*) FROM search)",
        error);
    if (statement == NULL)
        return STATUS_IO;
    enum status status = STATUS_OK;
    int code = sqlite3_step(statement);
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        status = journal_failure(journal, "cannot read the run", error);
    else if (code == SQLITE_DONE || !run_from_row(statement, run))
        status = journal_damaged(journal, "its run is missing or makes no sense", error);
    sqlite3_finalize(statement);
    return status;
}

// ---- searches ----

static bool scenario_from_row(sqlite3_stmt *row, struct journal_search *search)
{
    const void *text = sqlite3_column_text(row, 1);
    if (text == NULL)
        return false;
    search->text_size = (size_t)sqlite3_column_bytes(row, 1);
    search->text = g_malloc(search->text_size + 1);
    memcpy(search->text, text, search->text_size);
    search->text[search->text_size] = '\0';
    return column_text(row, 0, search->name, sizeof search->name) &&
           column_digest(row, 2, &search->scenario) && column_u64(row, 3, &search->seed);
}

// The worst design, and what holds the bounds; each may be empty.
static bool findings_from_row(sqlite3_stmt *row, struct journal_search *search)
{
    if (!column_box(row, 16, &search->worst) ||
        (search->worst.count > 0 && search->worst.count != search->box.count))
        return false;
    const size_t holders = (size_t)sqlite3_column_bytes(row, 17);
    const size_t gains = (size_t)sqlite3_column_bytes(row, 18) / sizeof(double);
    if (holders == 0)
        return true;
    if (holders != 2 * (size_t)search->box.count || gains == 0 || gains > UINT8_MAX)
        return false;
    search->holders = g_memdup2(sqlite3_column_blob(row, 17), holders);
    search->gains = g_new(double, gains);
    search->gain_count = (uint32_t)gains;
    return column_doubles(row, 18, search->gains, gains);
}

static bool result_from_row(sqlite3_stmt *row, struct journal_search *search)
{
    double exact[3];
    if (!column_text(row, 5, search->status, sizeof search->status) ||
        !column_u64(row, 6, &search->purity_samples) || !column_u64(row, 7, &search->purity_bad) ||
        search->purity_bad > search->purity_samples || !column_u64(row, 8, &search->evaluations) ||
        !column_u64(row, 9, &search->non_finite) || !column_u32(row, 10, &search->steps) ||
        !column_text(row, 11, search->blocking_constraint, sizeof search->blocking_constraint) ||
        !column_i64(row, 12, &search->wall_ns) || !column_doubles(row, 13, exact, 3) ||
        !column_box(row, 14, &search->box) || !column_digest(row, 15, &search->digest))
        return false;
    if (sqlite3_column_type(row, 16) != SQLITE_NULL && !findings_from_row(row, search))
        return false;
    search->log_volume = exact[0];
    search->purity_estimate = exact[1];
    search->purity_lower95 = exact[2];
    return true;
}

static bool search_from_row(sqlite3_stmt *row, struct journal_search *search)
{
    uint64_t finished;
    if (!scenario_from_row(row, search) || !column_u64(row, 4, &finished) || finished > 1)
        return false;
    search->finished = finished == 1;
    if (search->finished)
        return result_from_row(row, search);
    return column_text(row, 5, search->status, sizeof search->status);
}

enum status journal_read_search(struct journal *journal, uint32_t index,
                                struct journal_search *search, struct error *error)
{
    *search = (struct journal_search){.index = index};
#define READ_SEARCH(more)                                                                         \
    "SELECT name, scenario, scenario_digest, seed, finished, status, purity_samples, purity_bad," \
    " evaluations, non_finite, steps, blocking_constraint, wall_ns, exact, bounds, digest, " more \
    " FROM search WHERE number = ?1"
    const bool old = journal->schema < JOURNAL_SCHEMA_WORST;
    sqlite3_stmt *statement = journal_prepare(
        journal, old ? READ_SEARCH("NULL") : READ_SEARCH("worst, holders, gains"), error);
    if (statement == NULL)
        return STATUS_IO;
    sqlite3_bind_int64(statement, 1, index);
    enum status status = STATUS_OK;
    int code = sqlite3_step(statement);
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        status = journal_failure(journal, "cannot read a search", error);
    else if (code == SQLITE_DONE || !search_from_row(statement, search)) {
        char what[64];
        g_snprintf(what, sizeof what, "search %" PRIu32 " is missing or makes no sense", index);
        status = journal_damaged(journal, what, error);
    }
    sqlite3_finalize(statement);
    if (status != STATUS_OK)
        journal_search_fini(search);
    return status;
}

void journal_search_fini(struct journal_search *search)
{
    g_free(search->text);
    box_fini(&search->box);
    box_fini(&search->worst);
    g_free(search->holders);
    g_free(search->gains);
    *search = (struct journal_search){0};
}

// ---- a sweep ----

// A row's text, to be freed; NULL when it is none.
static char *text_of(sqlite3_stmt *row, int column)
{
    const char *bytes = (const char *)sqlite3_column_text(row, column);
    size_t length = (size_t)sqlite3_column_bytes(row, column);
    bool is_text = sqlite3_column_type(row, column) == SQLITE_TEXT && bytes != NULL &&
                   strlen(bytes) == length && g_utf8_validate(bytes, (gssize)length, NULL);
    return is_text ? g_strdup(bytes) : NULL;
}

// Rows numbered from 0 on, each with a text.
static enum status read_texts(struct journal *journal, sqlite3_stmt *rows, char ***texts,
                              struct error *error)
{
    GPtrArray *list = g_ptr_array_new_null_terminated(0, g_free, TRUE);
    enum status status = STATUS_OK;
    int code;
    while (status == STATUS_OK && (code = sqlite3_step(rows)) != SQLITE_DONE) {
        char *text = NULL;
        if (code != SQLITE_ROW)
            status = journal_failure(journal, "cannot read an axis", error);
        else if (list->len == JOURNAL_AXIS_MAX || sqlite3_column_int64(rows, 0) != list->len ||
                 (text = text_of(rows, 1)) == NULL)
            status = journal_damaged(journal, "an axis is missing or makes no sense", error);
        else
            g_ptr_array_add(list, text);
    }
    *texts = (char **)g_ptr_array_free(list, status != STATUS_OK);
    return status;
}

static enum status read_texts_by(struct journal *journal, const char *sql, uint32_t index,
                                 char ***texts, struct error *error)
{
    *texts = NULL;
    if (journal->schema < JOURNAL_SCHEMA_AXES) {
        *texts = g_new0(char *, 1);
        return STATUS_OK;
    }
    sqlite3_stmt *rows = journal_prepare(journal, sql, error);
    if (rows == NULL)
        return STATUS_IO;
    sqlite3_bind_int64(rows, 1, index);
    enum status status = read_texts(journal, rows, texts, error);
    sqlite3_finalize(rows);
    return status;
}

enum status journal_read_axes(struct journal *journal, char ***axes, struct error *error)
{
    return read_texts_by(journal, "SELECT number, path FROM axis WHERE ?1 = ?1 ORDER BY number", 0,
                         axes, error);
}

enum status journal_read_values(struct journal *journal, uint32_t index, char ***values,
                                struct error *error)
{
    return read_texts_by(journal,
                         "SELECT axis, value FROM axis_value WHERE search = ?1 ORDER BY axis",
                         index, values, error);
}

static bool standing_from_row(sqlite3_stmt *row, struct journal_standing *standing)
{
    uint64_t finished;
    if (!column_u32(row, 0, &standing->index) ||
        !column_text(row, 1, standing->name, sizeof standing->name) ||
        !column_u64(row, 2, &finished) || finished > 1 ||
        !column_text(row, 3, standing->status, sizeof standing->status))
        return false;
    standing->finished = finished == 1;
    return true;
}

enum status journal_read_standings(struct journal *journal, journal_stand_visitor *visit,
                                   void *user, struct error *error)
{
    sqlite3_stmt *rows = journal_prepare(
        journal, "SELECT number, name, finished, status FROM search ORDER BY number", error);
    if (rows == NULL)
        return STATUS_IO;
    enum status status = STATUS_OK;
    int code = SQLITE_ROW;
    for (uint32_t index = 0; status == STATUS_OK && (code = sqlite3_step(rows)) == SQLITE_ROW;
         index++) {
        struct journal_standing standing;
        if (!standing_from_row(rows, &standing) || standing.index != index)
            status = journal_damaged(journal, "a search is missing or makes no sense", error);
        else
            status = visit(user, &standing, error);
    }
    if (status == STATUS_OK && code != SQLITE_DONE)
        status = journal_failure(journal, "cannot read a search", error);
    sqlite3_finalize(rows);
    return status;
}

// ---- steps ----

// What a step points to, reused from row to row.
struct step_memory {
    struct box box;
    GArray *verdicts; // of struct verdict
};

static bool verdicts_from_row(sqlite3_stmt *row, struct journal_step *step, GArray *verdicts)
{
    const uint8_t *packed = sqlite3_column_blob(row, 9);
    size_t size = (size_t)sqlite3_column_bytes(row, 9);
    // At least a bit a sample: a count that the blob cannot hold is refused before memory is taken.
    if (step->samples > JOURNAL_SAMPLE_MAX || step->samples > size * 8)
        return false;
    g_array_set_size(verdicts, step->samples);
    struct verdict *unpacked = (struct verdict *)(void *)verdicts->data;
    step->verdicts = unpacked;
    return verdict_unpack(unpacked, step->samples, step->detail, UINT8_MAX + 1, packed, size) &&
           verdict_good_count(unpacked, step->samples) == step->good;
}

static bool step_from_row(sqlite3_stmt *row, struct journal_step *step, struct step_memory *memory)
{
    uint64_t detail, sampling = 0;
    double exact[2];
    if (!column_u32(row, 0, &step->search) || !column_u32(row, 1, &step->step) ||
        step->search > INT32_MAX ||
        sqlite3_column_int64(row, 2) != journal_step_id(step->search, step->step) ||
        !column_text(row, 3, step->phase, sizeof step->phase) ||
        !column_u32(row, 4, &step->samples) || !column_u32(row, 5, &step->good) ||
        !column_doubles(row, 6, exact, 2) || !column_box(row, 7, &memory->box) ||
        !column_u64(row, 8, &detail) || detail >= VERDICT_DETAIL_COUNT)
        return false;
    step->sampling_known = sqlite3_column_count(row) > 10;
    if (step->sampling_known &&
        (!column_u64(row, 10, &sampling) || sampling >= SAMPLING_METHOD_COUNT))
        return false;
    step->sampling = (enum sampling_method)sampling;
    step->detail = (enum verdict_detail)detail;
    step->growth = exact[0];
    step->log_volume = exact[1];
    step->box = &memory->box;
    return verdicts_from_row(row, step, memory->verdicts);
}

static enum status visit_steps(struct journal *journal, sqlite3_stmt *rows,
                               struct step_memory *memory, journal_visitor *visit, void *user,
                               struct error *error)
{
    int code;
    while ((code = sqlite3_step(rows)) == SQLITE_ROW) {
        struct journal_step step = {0};
        if (!step_from_row(rows, &step, memory)) {
            char what[64];
            g_snprintf(what, sizeof what, "step %" PRIu32 " of search %" PRIu32 " makes no sense",
                       step.step, step.search);
            return journal_damaged(journal, what, error);
        }
        enum status status = visit(user, &step, error);
        if (status != STATUS_OK)
            return status;
    }
    return code == SQLITE_DONE ? STATUS_OK : journal_failure(journal, "cannot read a step", error);
}

#define STEPS(column)                                                                       \
    "SELECT search, step, id, phase, samples, good, exact, bounds, detail, verdicts" column \
    " FROM step WHERE id BETWEEN ?1 AND ?2 ORDER BY id"

enum status journal_read_steps(struct journal *journal, uint32_t search, journal_visitor *visit,
                               void *user, struct error *error)
{
    const bool old = journal->schema < JOURNAL_SCHEMA_SAMPLING;
    sqlite3_stmt *rows = journal_prepare(journal, old ? STEPS("") : STEPS(", sampling"), error);
    if (rows == NULL)
        return STATUS_IO;
    sqlite3_bind_int64(rows, 1, journal_step_id(search, 0));
    sqlite3_bind_int64(rows, 2, journal_step_id(search, UINT32_MAX));
    struct step_memory memory = {.verdicts = g_array_new(FALSE, FALSE, sizeof(struct verdict))};
    enum status status = visit_steps(journal, rows, &memory, visit, user, error);
    sqlite3_finalize(rows);
    box_fini(&memory.box);
    g_array_unref(memory.verdicts);
    return status;
}
