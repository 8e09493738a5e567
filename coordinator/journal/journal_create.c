// Making a journal: the schema, the run, and its searches, in one transaction. Nothing half-written
// is left behind.
#include "coordinator/journal/journal_inside.h"

#include <assert.h>
#include <unistd.h>

// The REAL columns are for people; `exact` repeats them bit by bit and is what is read back. A
// step's id is its place, (search << 32) + step, so that one B-tree serves key, order and row.
static const char SCHEMA[] =
    "CREATE TABLE meta (schema INTEGER NOT NULL) STRICT;"
    "CREATE TABLE run (id INTEGER NOT NULL, name TEXT NOT NULL, version TEXT NOT NULL,"
    " state TEXT NOT NULL, search_count INTEGER NOT NULL, started_ns INTEGER NOT NULL,"
    " elapsed_ns INTEGER NOT NULL) STRICT;"
    "CREATE TABLE axis (number INTEGER PRIMARY KEY, path TEXT NOT NULL) STRICT;"
    "CREATE TABLE axis_value (search INTEGER NOT NULL, axis INTEGER NOT NULL, value TEXT NOT NULL,"
    " PRIMARY KEY (search, axis)) STRICT, WITHOUT ROWID;"
    "CREATE TABLE search (number INTEGER PRIMARY KEY, name TEXT NOT NULL, scenario TEXT NOT NULL,"
    " scenario_digest BLOB NOT NULL, seed INTEGER NOT NULL,"
    " finished INTEGER NOT NULL DEFAULT 0, status TEXT NOT NULL DEFAULT 'running',"
    " log_volume REAL, purity_samples INTEGER, purity_bad INTEGER, purity_estimate REAL,"
    " purity_lower95 REAL, evaluations INTEGER, non_finite INTEGER, steps INTEGER,"
    " blocking_constraint TEXT, wall_ns INTEGER, exact BLOB, bounds BLOB, digest BLOB,"
    " worst BLOB, holders BLOB, gains BLOB) STRICT;"
    "CREATE TABLE step (id INTEGER PRIMARY KEY, search INTEGER NOT NULL, step INTEGER NOT NULL,"
    " phase TEXT NOT NULL, samples INTEGER NOT NULL, good INTEGER NOT NULL, growth REAL,"
    " log_volume REAL, exact BLOB NOT NULL, bounds BLOB NOT NULL, detail INTEGER NOT NULL,"
    " verdicts BLOB NOT NULL, sampling INTEGER NOT NULL) STRICT;";

static enum status insert_run(struct journal *journal, const struct journal_run *run,
                              uint32_t search_count, struct error *error)
{
    sqlite3_stmt *statement =
        journal_prepare(journal, "INSERT INTO run VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)", error);
    if (statement == NULL)
        return STATUS_IO;
    sqlite3_bind_int64(statement, 1, (int64_t)run->id);
    journal_bind_text(statement, 2, run->name);
    journal_bind_text(statement, 3, run->version);
    journal_bind_text(statement, 4, protocol_run_state_name(run->state));
    sqlite3_bind_int64(statement, 5, search_count);
    sqlite3_bind_int64(statement, 6, run->started_ns);
    sqlite3_bind_int64(statement, 7, run->elapsed_ns);
    enum status status = journal_run_statement(journal, statement, "cannot write the run", error);
    sqlite3_finalize(statement);
    return status;
}

// What is to be written at the creation.
struct contents {
    const struct journal_run *run;
    const char *const *axes;
    uint32_t axis_count;
    journal_source *next;
    void *user;
};

static enum status insert_axes(struct journal *journal, const struct contents *contents,
                               struct error *error)
{
    sqlite3_stmt *statement = journal_prepare(journal, "INSERT INTO axis VALUES (?1, ?2)", error);
    enum status status = statement != NULL ? STATUS_OK : STATUS_IO;
    for (uint32_t i = 0; i < contents->axis_count && status == STATUS_OK; i++) {
        sqlite3_bind_int64(statement, 1, i);
        journal_bind_text(statement, 2, contents->axes[i]);
        status = journal_run_statement(journal, statement, "cannot write an axis", error);
        sqlite3_reset(statement);
    }
    sqlite3_finalize(statement);
    return status;
}

static enum status insert_search(struct journal *journal, sqlite3_stmt *statement,
                                 const struct journal_search *search, struct error *error)
{
    sqlite3_bind_int64(statement, 1, search->index);
    journal_bind_text(statement, 2, search->name);
    sqlite3_bind_text64(statement, 3, search->text, search->text_size, SQLITE_STATIC, SQLITE_UTF8);
    journal_bind_blob(statement, 4, search->scenario.bytes, DIGEST_SIZE);
    sqlite3_bind_int64(statement, 5, (int64_t)search->seed);
    enum status status = journal_run_statement(journal, statement, "cannot write a search", error);
    sqlite3_reset(statement);
    return status;
}

static enum status insert_values(struct journal *journal, sqlite3_stmt *statement,
                                 const struct journal_search *search, uint32_t axis_count,
                                 struct error *error)
{
    enum status status = STATUS_OK;
    for (uint32_t i = 0; i < axis_count && status == STATUS_OK; i++) {
        sqlite3_bind_int64(statement, 1, search->index);
        sqlite3_bind_int64(statement, 2, i);
        journal_bind_text(statement, 3, search->values[i]);
        status = journal_run_statement(journal, statement, "cannot write a case", error);
        sqlite3_reset(statement);
    }
    return status;
}

static enum status insert_searches(struct journal *journal, const struct contents *contents,
                                   uint32_t *count, struct error *error)
{
    sqlite3_stmt *searches =
        journal_prepare(journal,
                        "INSERT INTO search (number, name, scenario, scenario_digest, seed) VALUES "
                        "(?1, ?2, ?3, ?4, ?5)",
                        error);
    sqlite3_stmt *values =
        journal_prepare(journal, "INSERT INTO axis_value VALUES (?1, ?2, ?3)", error);
    enum status status = searches != NULL && values != NULL ? STATUS_OK : STATUS_IO;
    bool more = true;
    for (*count = 0; status == STATUS_OK; ++*count) {
        struct journal_search search = {0};
        status = contents->next(contents->user, &search, &more, error);
        if (status != STATUS_OK || !more)
            break;
        status = insert_search(journal, searches, &search, error);
        if (status == STATUS_OK)
            status = insert_values(journal, values, &search, contents->axis_count, error);
    }
    sqlite3_finalize(values);
    sqlite3_finalize(searches);
    return status;
}

static enum status create_contents(struct journal *journal, const struct contents *contents,
                                   struct error *error)
{
    char *schema = g_strdup_printf("BEGIN; PRAGMA application_id = %d; %s"
                                   "INSERT INTO meta VALUES (%d);",
                                   JOURNAL_APPLICATION_ID, SCHEMA, JOURNAL_SCHEMA);
    uint32_t count = 0;
    enum status status = journal_execute(journal, schema, "cannot be created", error);
    g_free(schema);
    if (status == STATUS_OK)
        status = insert_axes(journal, contents, error);
    if (status == STATUS_OK)
        status = insert_searches(journal, contents, &count, error);
    if (status == STATUS_OK)
        status = insert_run(journal, contents->run, count, error);
    if (status == STATUS_OK)
        status = journal_execute(journal, "COMMIT", "cannot be created", error);
    return status;
}

// Removes what a failed creation left, so that nothing half-written looks like a run.
static void remove_files(const char *path)
{
    static const char *const SUFFIXES[] = {"", "-wal", "-shm", "-journal"};
    for (size_t i = 0; i < G_N_ELEMENTS(SUFFIXES); i++) {
        char *file = g_strconcat(path, SUFFIXES[i], NULL);
        unlink(file);
        g_free(file);
    }
}

// The first pages go in without an fsync(): nothing is promised before the transaction is whole.
static enum status create_database(struct journal *journal, const struct contents *contents,
                                   struct error *error)
{
    enum status status = journal_database_open(journal, journal->path,
                                               SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, error);
    if (status == STATUS_OK)
        status = journal_execute(journal, "PRAGMA synchronous = OFF; PRAGMA journal_mode = WAL",
                                 "cannot be created", error);
    if (status == STATUS_OK)
        status = create_contents(journal, contents, error);
    if (status == STATUS_OK)
        status = journal_writing_start(journal, error);
    return status;
}

enum status journal_create_from(struct journal **result, const char *directory,
                                const struct journal_run *run, const char *const *axes,
                                uint32_t axis_count, journal_source *next, void *user,
                                struct error *error)
{
    assert(axis_count <= JOURNAL_AXIS_MAX);
    const struct contents contents = {
        .run = run, .axes = axes, .axis_count = axis_count, .next = next, .user = user};
    *result = NULL;
    struct journal *journal = journal_new(directory);
    journal->schema = JOURNAL_SCHEMA;
    enum status status = journal_lock_take(&journal->lock, directory, error);
    if (status == STATUS_OK && access(journal->path, F_OK) == 0)
        status = error_set(error, STATUS_IO, "%s: there is a run already; choose another folder",
                           journal->path);
    else if (status == STATUS_OK) {
        status = create_database(journal, &contents, error);
        if (status != STATUS_OK) {
            sqlite3_finalize(journal->append);
            sqlite3_close(journal->database);
            journal->append = NULL;
            journal->database = NULL;
            remove_files(journal->path);
        }
    }
    if (status != STATUS_OK) {
        journal_close(journal);
        return status;
    }
    *result = journal;
    return STATUS_OK;
}

// Searches that lie one after the other in memory.
struct listing {
    const struct journal_search *searches;
    uint32_t count;
};

static enum status next_listed(void *user, struct journal_search *search, bool *more,
                               struct error *error)
{
    (void)error;
    struct listing *listing = user;
    *more = listing->count > 0;
    if (*more) {
        *search = *listing->searches++;
        listing->count--;
    }
    return STATUS_OK;
}

enum status journal_create(struct journal **result, const char *directory,
                           const struct journal_run *run, const struct journal_search *searches,
                           struct error *error)
{
    struct listing listing = {.searches = searches, .count = run->search_count};
    return journal_create_from(result, directory, run, NULL, 0, next_listed, &listing, error);
}
