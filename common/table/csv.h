// A table of comma-separated values, read from memory a row at a time, with the place of every
// field, so that a complaint can say FILE:LINE:COLUMN.
//
//     # measured on the second of March
//     id, mass, "note, if any"
//     a1, 1500, "the ""heavy"" one"
//
// A field in double quotes may hold commas and, doubled, quotes, but no line end. Blanks around
// fields, empty lines and lines that begin with # are skipped; lines end with LF or CR LF. The text
// is as untrusted as any file. Nothing is copied, so that tables of millions of rows cost no more
// than a look at each byte, and threads may read pieces of one table side by side.
#ifndef SOBOX_COMMON_TABLE_CSV_H
#define SOBOX_COMMON_TABLE_CSV_H

#include "common/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    CSV_FIELD_MAX = 512,         // fields that csv_row() takes; a trajectory of 64 springs has 327
    CSV_SHOWN_SIZE = 48,         // [bytes] of a field in a message, with its NUL
    CSV_TEXT_SIZE_MAX = 16 << 20 // [bytes] of a file that csv_load() reads
};

struct csv_field {
    const char *text; // borrowed from the table, not terminated, without the quotes around it
    size_t size;      // [bytes]
    bool quoted;      // quotes in `text` stand for one each where they are doubled
};

struct csv {
    const char *source; // stands for the file in messages; borrowed
    const char *rest;   // what has not been read yet; borrowed
    const char *end;
    uint64_t line;          // of the current row, from 1
    const char *line_begin; // the current row, without its line end
    const char *line_end;
    const char *at; // its next field; NULL when there is none left
    struct csv_field fields[CSV_FIELD_MAX];
    uint32_t field_count; // that csv_row() read
};

// Reads a table that is small enough to be in memory whole. The text is released with g_free().
// Errors: NULL, with `error` filled (STATUS_INVALID: no such file, too long, not UTF-8).
char *csv_load(const char *path, size_t *size, struct error *error);

// Begins to read; a byte order mark is skipped. `source` and `text` are borrowed while the table is
// in use. The first line is 1; a caller whose text begins at another sets `line` to the one before.
void csv_start(struct csv *csv, const char *source, const char *text, size_t size);

// Goes on with the text that follows what was read, once csv_row() came to its end: tables too
// large for memory come in pieces of whole lines. Borrowed as before.
void csv_continue(struct csv *csv, const char *text, size_t size);

// Reads the next row into `fields`; at the end of the text field_count is 0.
// Errors: STATUS_INVALID (more than CSV_FIELD_MAX fields; broken quotes).
enum status csv_row(struct csv *csv, struct error *error) MUST_USE;

// For rows of any number of fields: csv_line() moves to the next row, false at the end of the text,
// and csv_next() reads its next field, as long as `at` is not NULL.
// Errors: STATUS_INVALID (broken quotes).
bool csv_line(struct csv *csv);
enum status csv_next(struct csv *csv, struct csv_field *field, struct error *error) MUST_USE;

// Whether a field is exactly this word.
bool csv_is(const struct csv_field *field, const char *word);

// A copy of the field's text, doubled quotes made one. Released with g_free().
char *csv_text(const struct csv_field *field);

// Writes the field as a message may show it: cut where it is long, and without characters that
// could steer a terminal. Returns `shown`.
const char *csv_shown(const struct csv_field *field, char shown[CSV_SHOWN_SIZE]);

// Reads a field as a finite number. `name` and `unit` say what it is in the message.
// Errors: STATUS_INVALID.
enum status csv_number(const struct csv *csv, uint32_t field, const char *name, const char *unit,
                       double *number, struct error *error) MUST_USE;

// In which column of its line a byte of the current row stands, counted in characters from 1.
uint32_t csv_column(const struct csv *csv, const char *at);

// Fills the error with "SOURCE:LINE:COLUMN: " and the message. A field beyond the row's last stands
// for the end of the row. Returns STATUS_INVALID.
enum status csv_error(const struct csv *csv, uint32_t field, struct error *error,
                      const char *format, ...) __attribute__((format(printf, 4, 5)));

// The same at a byte of the current row.
enum status csv_error_at(const struct csv *csv, const char *at, struct error *error,
                         const char *format, ...) __attribute__((format(printf, 4, 5)));

#endif
