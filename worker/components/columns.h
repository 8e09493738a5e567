// A table's header of named columns in any order: which stands where.
#ifndef SOBOX_WORKER_COMPONENTS_COLUMNS_H
#define SOBOX_WORKER_COMPONENTS_COLUMNS_H

#include "common/table/csv.h"

#define COLUMNS_ABSENT UINT32_MAX

struct columns_name {
    const char *name;
    bool optional;
};

// Reads the header and says in `place` (count) at which field each column stands, or
// COLUMNS_ABSENT. `expected` is the sentence about the right columns. Errors: STATUS_INVALID (a
// column that is unknown, there twice, or missing).
enum status columns_read(struct csv *csv, const struct columns_name *columns, uint32_t count,
                         const char *expected, uint32_t *place, struct error *error) MUST_USE;

// Reads the next row, which has `field_count` fields as the header; at the end of the text
// csv->field_count is 0. Errors: STATUS_INVALID.
enum status columns_row(struct csv *csv, uint32_t field_count, struct error *error) MUST_USE;

// Reads a field as a name of letters, digits, '_' and '-', as springs have them; an empty one only
// where `optional`. Errors: STATUS_INVALID.
enum status columns_identifier(const struct csv *csv, uint32_t field,
                               const struct columns_name *column, char *name, size_t size,
                               struct error *error) MUST_USE;

#endif
