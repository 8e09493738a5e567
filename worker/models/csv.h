// A table of comma-separated values, read from memory a row at a time, with the place of every
// field, so that a complaint can say FILE:LINE:COLUMN. Fields are not quoted; blanks around them,
// empty lines and lines that begin with # are skipped; lines end with LF or CR LF. The text is as
// untrusted as any file.
#ifndef SOBOX_WORKER_MODELS_CSV_H
#define SOBOX_WORKER_MODELS_CSV_H

#include "common/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CSV_FIELD_MAX = 512 }; // fields of a row; a trajectory of 64 springs has 327

struct csv_field {
    const char *text; // borrowed from the table, not terminated
    size_t size;      // [bytes]
    uint32_t column;  // [bytes] from 1
};

struct csv {
    const char *source; // stands for the file in messages; borrowed
    const char *rest;   // what has not been read yet; borrowed
    const char *end;
    uint32_t line; // of the current row, from 1
    struct csv_field fields[CSV_FIELD_MAX];
    uint32_t field_count; // of the current row
};

// Begins to read. `source` and `text` are borrowed while the table is in use.
void csv_start(struct csv *csv, const char *source, const char *text, size_t size);

// Goes on with the text that follows what was read, once csv_row() came to its end: tables too
// large for memory come in pieces of whole lines. Borrowed as before.
void csv_continue(struct csv *csv, const char *text, size_t size);

// Reads the next row into `fields`; at the end of the text field_count is 0.
// Errors: STATUS_INVALID (more than CSV_FIELD_MAX fields).
enum status csv_row(struct csv *csv, struct error *error) MUST_USE;

// Whether a field is exactly this word.
bool csv_is(const struct csv_field *field, const char *word);

// Reads a field as a finite number. `name` and `unit` say what it is in the message.
// Errors: STATUS_INVALID.
enum status csv_number(const struct csv *csv, uint32_t field, const char *name, const char *unit,
                       double *number, struct error *error) MUST_USE;

// Fills the error with "SOURCE:LINE:COLUMN: " and the message. A field beyond the row's last stands
// for the end of the row. Returns STATUS_INVALID.
enum status csv_error(const struct csv *csv, uint32_t field, struct error *error,
                      const char *format, ...) __attribute__((format(printf, 4, 5)));

#endif
