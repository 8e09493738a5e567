// A CSV file of text cells in which every cell remembers where it stands: a table of cases that a
// sweep goes through. Commas between cells; a cell in double quotes may hold commas and, doubled,
// quotes; blanks around a cell and empty lines do not count, nor do lines that begin with
// '#'. The text is untrusted: size, rows and columns are bounded.
#ifndef SOBOX_COMMON_SCENARIO_SHEET_H
#define SOBOX_COMMON_SCENARIO_SHEET_H

#include "common/base/error.h"

#include <stddef.h>
#include <stdint.h>

enum {
    SHEET_TEXT_SIZE_MAX = 16 << 20, // [bytes] of CSV
    SHEET_COLUMN_MAX = 256,
};

struct sheet_cell {
    char *text;      // UTF-8 without control characters; never NULL
    uint32_t line;   // of the file, 1 is the first
    uint32_t column; // at which the text begins, behind a quote; 1 is the first character
};

struct sheet {
    char *source;             // the file's name
    uint32_t column_count;    // as the header has them
    uint32_t row_count;       // without the header
    struct sheet_cell *cells; // ((1 + row_count) x column_count), the header first
};

// Reads a file with at most `row_max` rows below its header. On success the caller releases it;
// else it is left zeroed. Errors: STATUS_INVALID, "FILE:LINE:COLUMN: ...", also for a file that
// cannot be read.
enum status sheet_read_file(struct sheet *sheet, const char *path, uint32_t row_max,
                            struct error *error) MUST_USE;

// The same from memory; `source` stands for the file in messages.
enum status sheet_read_text(struct sheet *sheet, const char *source, const char *text, size_t size,
                            uint32_t row_max, struct error *error) MUST_USE;

// The cell of a row; row 0 is the header.
const struct sheet_cell *sheet_cell(const struct sheet *sheet, uint32_t row, uint32_t column);

// Releases what it owns. A zeroed struct is fine.
void sheet_fini(struct sheet *sheet);

#endif
