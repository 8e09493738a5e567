// Opening and writing. How durable a step is:
//
// The database is in WAL mode with synchronous=NORMAL. An append is then one write() to run.db-wal
// and no fsync(): what the kernel has been given survives any death of this process, and costs tens
// of microseconds. A power failure may take the last steps, never the consistency of what was there
// before; a resumed search computes lost steps again to the same bits, so an fsync() a step, some
// milliseconds on a disk, would buy nothing but time once in a blue moon. SQLite does fsync() when
// it moves the log into run.db: every 4,000 pages and when the run ends.
#include "coordinator/journal/journal_inside.h"

#include <assert.h>
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// A file of an older schema is continued as it is.
#define APPEND(column, value)                                                                      \
    "INSERT INTO step (id, search, step, phase, samples, good, growth, log_volume, exact, bounds," \
    " detail, verdicts" column ") VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12" value \
    ")"
static const char APPEND_STEP[] = APPEND(", sampling", ", ?13");
static const char APPEND_STEP_OLD[] = APPEND("", "");

int64_t journal_step_id(uint32_t search, uint32_t step)
{
    assert(search <= INT32_MAX); // ids stay positive and ordered
    return (int64_t)search << 32 | step;
}

void journal_doubles_put(GByteArray *bytes, const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        guint64 bits;
        memcpy(&bits, &values[i], sizeof bits);
        bits = GUINT64_TO_LE(bits);
        g_byte_array_append(bytes, (const guint8 *)&bits, sizeof bits);
    }
}

void journal_doubles_take(double *values, size_t count, const void *bytes)
{
    for (size_t i = 0; i < count; i++) {
        guint64 bits;
        memcpy(&bits, (const guint8 *)bytes + i * sizeof bits, sizeof bits);
        bits = GUINT64_FROM_LE(bits);
        memcpy(&values[i], &bits, sizeof bits);
    }
}

// ---- errors ----

enum status journal_failure(struct journal *journal, const char *what, struct error *error)
{
    int code = journal->database != NULL ? sqlite3_errcode(journal->database) & 0xff : SQLITE_NOMEM;
    const char *path = journal->path;
    switch (code) {
    case SQLITE_FULL:
        return error_set(error, STATUS_IO,
                         "%s: %s: the disk is full; free some space, what was written before is "
                         "whole",
                         path, what);
    case SQLITE_NOTADB:
        return error_set(error, STATUS_IO, "%s: not a run's journal: not an SQLite database", path);
    case SQLITE_CORRUPT:
        return error_set(error, STATUS_IO, "%s: %s: the file is damaged (%s)", path, what,
                         sqlite3_errmsg(journal->database));
    case SQLITE_READONLY:
    case SQLITE_PERM:
        return error_set(error, STATUS_IO, "%s: %s: no permission to write", path, what);
    default: {
        int reason = journal->database != NULL ? sqlite3_system_errno(journal->database) : 0;
        bool known = reason != 0 && (code == SQLITE_IOERR || code == SQLITE_CANTOPEN);
        return error_set(error, STATUS_IO, "%s: %s: %s", path, what,
                         known                       ? strerror(reason)
                         : journal->database != NULL ? sqlite3_errmsg(journal->database)
                                                     : "out of memory");
    }
    }
}

enum status journal_damaged(struct journal *journal, const char *what, struct error *error)
{
    return error_set(error, STATUS_IO, "%s: the file is damaged: %s", journal->path, what);
}

sqlite3_stmt *journal_prepare(struct journal *journal, const char *sql, struct error *error)
{
    sqlite3_stmt *statement = NULL;
    if (sqlite3_prepare_v2(journal->database, sql, -1, &statement, NULL) != SQLITE_OK) {
        journal_failure(journal, "cannot be read", error);
        return NULL;
    }
    return statement;
}

// ---- opening ----

enum status journal_execute(struct journal *journal, const char *sql, const char *what,
                            struct error *error)
{
    if (sqlite3_exec(journal->database, sql, NULL, NULL, NULL) != SQLITE_OK)
        return journal_failure(journal, what, error);
    return STATUS_OK;
}

struct journal *journal_new(const char *directory)
{
    struct journal *journal = g_new0(struct journal, 1);
    journal->path = g_build_filename(directory, "run.db", NULL);
    journal->bounds = g_byte_array_new();
    journal->verdicts = g_byte_array_new();
    return journal;
}

// Opens the file and takes away everything a database that was made to deceive could use against
// its reader: triggers, views, schemas that call functions, huge values.
enum status journal_database_open(struct journal *journal, const char *name, int flags,
                                  struct error *error)
{
    if (sqlite3_open_v2(name, &journal->database, flags | SQLITE_OPEN_EXRESCODE, NULL) != SQLITE_OK)
        return journal_failure(journal, "cannot be opened", error);
    sqlite3 *database = journal->database;
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, NULL);
    sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_VIEW, 0, NULL);
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, JOURNAL_BLOB_SIZE_MAX);
    sqlite3_busy_timeout(database, 5000); // a reader that recovers a dead coordinator's log
    return journal_execute(journal, "PRAGMA cell_size_check = ON", "cannot be opened", error);
}

// Where the file system has no shared memory SQLite keeps its rollback journal instead: slower,
// as durable, so the answer to journal_mode is not looked at.
enum status journal_writing_start(struct journal *journal, struct error *error)
{
    const bool old = journal->schema < JOURNAL_SCHEMA_SAMPLING;
    enum status status =
        journal_execute(journal,
                        "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;"
                        "PRAGMA wal_autocheckpoint = 4000; PRAGMA temp_store = MEMORY",
                        "cannot be written", error);
    if (status == STATUS_OK &&
        sqlite3_prepare_v3(journal->database, old ? APPEND_STEP_OLD : APPEND_STEP, -1,
                           SQLITE_PREPARE_PERSISTENT, &journal->append, NULL) != SQLITE_OK)
        status = journal_failure(journal, "cannot be written", error);
    return status;
}

// Reads one integer; what is not there or not an integer is -1.
static enum status read_number(struct journal *journal, const char *sql, int64_t *number,
                               struct error *error)
{
    *number = -1;
    sqlite3_stmt *statement = journal_prepare(journal, sql, error);
    if (statement == NULL)
        return STATUS_IO;
    int code = sqlite3_step(statement);
    if (code == SQLITE_ROW && sqlite3_column_type(statement, 0) == SQLITE_INTEGER)
        *number = sqlite3_column_int64(statement, 0);
    enum status status = STATUS_OK;
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        status = journal_failure(journal, "cannot be read", error);
    sqlite3_finalize(statement);
    return status;
}

// The file must be ours and of this version before anything in it is believed.
static enum status check_schema(struct journal *journal, struct error *error)
{
    int64_t application, tables;
    if (read_number(journal, "PRAGMA application_id", &application, error) != STATUS_OK ||
        read_number(journal, "SELECT count(*) FROM sqlite_schema", &tables, error) != STATUS_OK)
        return STATUS_IO;
    if (tables == 0)
        return error_set(error, STATUS_IO,
                         "%s: empty: its run was stopped before it began; delete the folder and "
                         "start anew",
                         journal->path);
    if (application != JOURNAL_APPLICATION_ID)
        return error_set(error, STATUS_IO, "%s: an SQLite database, but not the journal of a run",
                         journal->path);
    if (read_number(journal, "SELECT schema FROM meta", &journal->schema, error) != STATUS_OK)
        return STATUS_IO;
    if (journal->schema < 1 || journal->schema > JOURNAL_SCHEMA)
        return error_set(error, STATUS_REFUSED,
                         "%s: written in version %lld of the journal's format, this sobox reads "
                         "versions 1 to %d; use the sobox that wrote it",
                         journal->path, (long long)journal->schema, JOURNAL_SCHEMA);
    return STATUS_OK;
}

// A reader looks at one moment of the run, however long it takes.
static enum status snapshot_start(struct journal *journal, struct error *error)
{
    return journal_execute(journal,
                           "PRAGMA query_only = ON; BEGIN; SELECT count(*) FROM sqlite_schema",
                           "cannot be read", error);
}

// In a folder where nothing can be created SQLite cannot open a database in WAL mode, but when no
// log lies beside it nobody is writing, and it may be read as it stands.
static enum status read_only_open(struct journal *journal, struct error *error)
{
    char *log = g_strconcat(journal->path, "-wal", NULL);
    bool has_log = access(log, F_OK) == 0;
    g_free(log);
    if (has_log)
        return STATUS_IO; // the error of the first attempt stands
    sqlite3_close(journal->database);
    journal->database = NULL;
    char *absolute = g_canonicalize_filename(journal->path, NULL);
    char *escaped = g_uri_escape_string(absolute, "/", FALSE);
    char *uri = g_strdup_printf("file://%s?immutable=1", escaped);
    enum status status =
        journal_database_open(journal, uri, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, error);
    if (status == STATUS_OK)
        status = snapshot_start(journal, error);
    g_free(uri);
    g_free(escaped);
    g_free(absolute);
    return status;
}

// A reader asks for permission to write where it can have it, not to change anything, but because
// the last one out tidies up: a read-only connection leaves its run.db-wal and run.db-shm behind.
static enum status open_to_read(struct journal *journal, struct error *error)
{
    enum status status =
        journal_database_open(journal, journal->path, SQLITE_OPEN_READWRITE, error);
    if (status == STATUS_OK)
        status = snapshot_start(journal, error);
    int code = sqlite3_errcode(journal->database) & 0xff;
    if (status != STATUS_OK && (code == SQLITE_CANTOPEN || code == SQLITE_READONLY))
        status = read_only_open(journal, error);
    return status;
}

static enum status open_to_write(struct journal *journal, const char *directory,
                                 struct error *error)
{
    enum status status = journal_lock_take(&journal->lock, directory, error);
    if (status != STATUS_OK)
        return status;
    return journal_database_open(journal, journal->path, SQLITE_OPEN_READWRITE, error);
}

enum status journal_open(struct journal **result, const char *directory, enum journal_mode mode,
                         struct error *error)
{
    *result = NULL;
    struct journal *journal = journal_new(directory);
    enum status status = STATUS_OK;
    struct stat file;
    if (stat(journal->path, &file) != 0)
        status = error_set(error, STATUS_IO, "%s: %s; a run folder has a run.db", journal->path,
                           errno == ENOENT ? "there is none" : strerror(errno));
    else if (!S_ISREG(file.st_mode))
        status = error_set(error, STATUS_IO, "%s: not a file", journal->path);
    else if (mode == JOURNAL_RESUME)
        status = open_to_write(journal, directory, error);
    else
        status = open_to_read(journal, error);

    if (status == STATUS_OK)
        status = check_schema(journal, error);
    if (status == STATUS_OK && mode == JOURNAL_RESUME)
        status = journal_writing_start(journal, error);
    if (status != STATUS_OK) {
        journal_close(journal);
        return status;
    }
    *result = journal;
    return STATUS_OK;
}

bool journal_is_of_points(const struct journal *journal)
{
    return journal->schema < JOURNAL_SCHEMA_WORST;
}

void journal_close(struct journal *journal)
{
    if (journal == NULL)
        return;
    sqlite3_finalize(journal->append);
    sqlite3_close(journal->database);
    journal_lock_release(&journal->lock); // last: until here we are the writer
    g_byte_array_unref(journal->bounds);
    g_byte_array_unref(journal->verdicts);
    g_free(journal->path);
    g_free(journal);
}

// ---- writing ----

int journal_bind_text(sqlite3_stmt *statement, int column, const char *text)
{
    return sqlite3_bind_text(statement, column, text, -1, SQLITE_STATIC);
}

int journal_bind_blob(sqlite3_stmt *statement, int column, const void *bytes, size_t size)
{
    // Without an address SQLite would bind NULL, which is not an empty blob.
    return sqlite3_bind_blob64(statement, column, size > 0 ? bytes : "", size, SQLITE_STATIC);
}

enum status journal_run_statement(struct journal *journal, sqlite3_stmt *statement,
                                  const char *what, struct error *error)
{
    if (sqlite3_step(statement) == SQLITE_DONE)
        return STATUS_OK;
    return journal_failure(journal, what, error);
}

static void pack_box(GByteArray *bytes, const struct box *box)
{
    g_byte_array_set_size(bytes, 0);
    journal_doubles_put(bytes, box->lower, box->count);
    journal_doubles_put(bytes, box->upper, box->count);
}

// Whether the file is no longer where it was opened. SQLite would go on writing into what nobody
// will ever read, and hours later the run would be lost.
static bool removed(struct journal *journal)
{
    int moved = 0;
    return sqlite3_file_control(journal->database, "main", SQLITE_FCNTL_HAS_MOVED, &moved) ==
               SQLITE_OK &&
           moved != 0;
}

enum status journal_append(struct journal *journal, const struct journal_step *step,
                           struct error *error)
{
    assert(journal->append != NULL); // opened to write
    assert(step->samples <= JOURNAL_SAMPLE_MAX);
    assert(step->box->count <= JOURNAL_VARIABLE_MAX);
    assert(step->detail < VERDICT_DETAIL_COUNT);
    if (removed(journal))
        return error_set(error, STATUS_IO,
                         "%s: was removed or moved away while the run went on: nothing more can be "
                         "kept",
                         journal->path);

    pack_box(journal->bounds, step->box);
    journal_doubles_put(journal->bounds, (const double[]){step->growth, step->log_volume}, 2);
    size_t box_size = 2 * sizeof(double) * step->box->count;
    g_byte_array_set_size(journal->verdicts,
                          (guint)verdict_packed_size_max(step->samples, step->detail));
    size_t verdicts_size =
        verdict_pack(step->verdicts, step->samples, step->detail, journal->verdicts->data);

    sqlite3_stmt *append = journal->append;
    sqlite3_bind_int64(append, 1, journal_step_id(step->search, step->step));
    sqlite3_bind_int64(append, 2, step->search);
    sqlite3_bind_int64(append, 3, step->step);
    journal_bind_text(append, 4, step->phase);
    sqlite3_bind_int64(append, 5, step->samples);
    sqlite3_bind_int64(append, 6, step->good);
    sqlite3_bind_double(append, 7, step->growth);
    sqlite3_bind_double(append, 8, step->log_volume);
    journal_bind_blob(append, 9, journal->bounds->data + box_size, 2 * sizeof(double));
    journal_bind_blob(append, 10, journal->bounds->data, box_size);
    sqlite3_bind_int64(append, 11, step->detail);
    journal_bind_blob(append, 12, journal->verdicts->data, verdicts_size);
    if (journal->schema >= JOURNAL_SCHEMA_SAMPLING)
        sqlite3_bind_int64(append, 13, step->sampling);
    enum status status = journal_run_statement(journal, append, "cannot write a step", error);
    sqlite3_reset(append);
    return status;
}

#define FINISH_RESULT(more)                                                                 \
    "UPDATE search SET finished = 1, status = ?2, log_volume = ?3, purity_samples = ?4,"    \
    " purity_bad = ?5, purity_estimate = ?6, purity_lower95 = ?7, evaluations = ?8,"        \
    " non_finite = ?9, steps = ?10, blocking_constraint = ?11, wall_ns = ?12, exact = ?13," \
    " bounds = ?14, digest = ?15" more " WHERE number = ?1"
static const char FINISH[] = FINISH_RESULT(", worst = ?16, holders = ?17, gains = ?18");
static const char FINISH_OLD[] = FINISH_RESULT("");

static void bind_result(sqlite3_stmt *statement, const struct journal_search *search)
{
    sqlite3_bind_int64(statement, 1, search->index);
    journal_bind_text(statement, 2, search->status);
    sqlite3_bind_double(statement, 3, search->log_volume);
    sqlite3_bind_int64(statement, 4, (int64_t)search->purity_samples);
    sqlite3_bind_int64(statement, 5, (int64_t)search->purity_bad);
    sqlite3_bind_double(statement, 6, search->purity_estimate);
    sqlite3_bind_double(statement, 7, search->purity_lower95);
    sqlite3_bind_int64(statement, 8, (int64_t)search->evaluations);
    sqlite3_bind_int64(statement, 9, (int64_t)search->non_finite);
    sqlite3_bind_int64(statement, 10, search->steps);
    journal_bind_text(statement, 11, search->blocking_constraint);
    sqlite3_bind_int64(statement, 12, search->wall_ns);
    journal_bind_blob(statement, 15, search->digest.bytes, DIGEST_SIZE);
}

enum status journal_finish_search(struct journal *journal, const struct journal_search *search,
                                  struct error *error)
{
    assert(journal->append != NULL); // opened to write
    const bool old = journal->schema < JOURNAL_SCHEMA_WORST;
    sqlite3_stmt *statement = journal_prepare(journal, old ? FINISH_OLD : FINISH, error);
    if (statement == NULL)
        return STATUS_IO;
    GByteArray *exact = g_byte_array_new();
    journal_doubles_put(
        exact,
        (const double[]){search->log_volume, search->purity_estimate, search->purity_lower95}, 3);
    pack_box(journal->bounds, &search->box);
    bind_result(statement, search);
    journal_bind_blob(statement, 13, exact->data, exact->len);
    journal_bind_blob(statement, 14, journal->bounds->data, journal->bounds->len);
    GByteArray *worst = g_byte_array_new();
    pack_box(worst, &search->worst);
    GByteArray *gains = g_byte_array_new();
    if (search->holders != NULL)
        journal_doubles_put(gains, search->gains, search->gain_count);
    if (!old) {
        const size_t sides = search->holders != NULL ? 2 * (size_t)search->box.count : 0;
        journal_bind_blob(statement, 16, worst->data, worst->len);
        journal_bind_blob(statement, 17, search->holders, sides);
        journal_bind_blob(statement, 18, gains->data, gains->len);
    }
    enum status status = journal_run_statement(journal, statement, "cannot write a result", error);
    sqlite3_finalize(statement);
    g_byte_array_unref(exact);
    g_byte_array_unref(worst);
    g_byte_array_unref(gains);
    if (status == STATUS_OK && sqlite3_changes(journal->database) != 1)
        status = journal_damaged(journal, "a search of this run is missing", error);
    return status;
}

enum status journal_fail_search(struct journal *journal, uint32_t index, struct error *error)
{
    assert(journal->append != NULL); // opened to write
    sqlite3_stmt *statement =
        journal_prepare(journal, "UPDATE search SET status = 'failed' WHERE number = ?1", error);
    if (statement == NULL)
        return STATUS_IO;
    sqlite3_bind_int64(statement, 1, index);
    enum status status = journal_run_statement(journal, statement, "cannot write a result", error);
    sqlite3_finalize(statement);
    return status;
}

enum status journal_begin(struct journal *journal, struct error *error)
{
    assert(journal->append != NULL); // opened to write
    return journal_execute(journal, "BEGIN", "cannot be written", error);
}

enum status journal_commit(struct journal *journal, struct error *error)
{
    // SQLite takes a transaction back by itself when its disk is full.
    if (sqlite3_get_autocommit(journal->database))
        return STATUS_OK;
    return journal_execute(journal, "COMMIT", "cannot be written", error);
}

enum status journal_state(struct journal *journal, enum run_state state, int64_t elapsed_ns,
                          struct error *error)
{
    assert(journal->append != NULL); // opened to write
    sqlite3_stmt *statement =
        journal_prepare(journal, "UPDATE run SET state = ?1, elapsed_ns = ?2", error);
    if (statement == NULL)
        return STATUS_IO;
    journal_bind_text(statement, 1, protocol_run_state_name(state));
    sqlite3_bind_int64(statement, 2, elapsed_ns);
    enum status status = journal_run_statement(journal, statement, "cannot write its state", error);
    sqlite3_finalize(statement);
    return status;
}
