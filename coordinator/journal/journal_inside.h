// What the files of this folder share: the open database and how doubles become blobs.
#ifndef SOBOX_COORDINATOR_JOURNAL_JOURNAL_INSIDE_H
#define SOBOX_COORDINATOR_JOURNAL_JOURNAL_INSIDE_H

#include "coordinator/journal/journal.h"
#include "coordinator/journal/journal_lock.h"

#include <glib.h>
#include <sqlite3.h>

enum {
    JOURNAL_APPLICATION_ID = 0x73626f78, // "sbox" in the header of the file
    // A box read from a file may have so many variables, a step so many samples: far more than any
    // scenario allows, and few enough that a lie costs no memory worth mentioning.
    JOURNAL_VARIABLE_MAX = 1 << 16,
    JOURNAL_SAMPLE_MAX = 1 << 24,
    JOURNAL_BLOB_SIZE_MAX = 64 << 20, // [bytes] of a text or blob; the samples above fit
};

struct journal {
    sqlite3 *database;
    char *path;               // of run.db
    struct journal_lock lock; // zero for a reader
    sqlite3_stmt *append;     // the one statement a search waits for is prepared once
    int64_t schema;           // of the file
    GByteArray *bounds;       // scratch of an append
    GByteArray *verdicts;
};

// A step's place in the table: ordered by search, then by step.
int64_t journal_step_id(uint32_t search, uint32_t step);

// Says in the error what SQLite just reported, with what to do about it. Returns its status.
enum status journal_failure(struct journal *journal, const char *what, struct error *error);

// Says that the contents of the database make no sense. Returns its status.
enum status journal_damaged(struct journal *journal, const char *what, struct error *error);

// Prepares a statement that is used once; NULL with the error set when that fails.
sqlite3_stmt *journal_prepare(struct journal *journal, const char *sql, struct error *error);

// Makes a journal of `directory` that is not open yet.
struct journal *journal_new(const char *directory);

// Opens the database `name` with SQLite's `flags`.
enum status journal_database_open(struct journal *journal, const char *name, int flags,
                                  struct error *error);

// Gets ready for appends.
enum status journal_writing_start(struct journal *journal, struct error *error);

// Runs statements that return nothing; `what` says what failed otherwise.
enum status journal_execute(struct journal *journal, const char *sql, const char *what,
                            struct error *error);

// Runs a prepared statement that returns nothing.
enum status journal_run_statement(struct journal *journal, sqlite3_stmt *statement,
                                  const char *what, struct error *error);

// Bind a text or bytes that outlive the statement's run. Return SQLite's result.
int journal_bind_text(sqlite3_stmt *statement, int column, const char *text);
int journal_bind_blob(sqlite3_stmt *statement, int column, const void *bytes, size_t size);

// Appends doubles as little-endian IEEE bits: SQLite's REAL turns -0.0 into 0 and NaN into NULL.
void journal_doubles_put(GByteArray *bytes, const double *values, size_t count);

// The inverse, from `bytes` of count * 8 bytes.
void journal_doubles_take(double *values, size_t count, const void *bytes);

#endif
