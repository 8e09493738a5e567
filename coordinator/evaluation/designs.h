// Designs as rows of comma-separated values: a header with the names of the scenario's variables,
// as result.json has them, in any order, and then a row for each design.
//
//     id,front.force_x[0],front.force_x[1],front.force_y[0],front.force_y[1]
//     a1,80e3,450e3,0,120000
//     a2,80e3,400e3,0,120000
//
// `id` is any text without comma and quotes and may be left out, and so may variables that the
// scenario fixes. Values are in the unit of the variable and may lie outside the design space, as
// those for sobox-simulate may. For the rest see common/table/csv.h.
#ifndef SOBOX_COORDINATOR_EVALUATION_DESIGNS_H
#define SOBOX_COORDINATOR_EVALUATION_DESIGNS_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"

#include <stddef.h>
#include <stdint.h>

enum { DESIGNS_ID = -1 }; // what a column is that is no variable

// What the header says.
struct designs_layout {
    const struct scenario *scenario; // borrowed
    uint32_t column_count;
    int32_t *columns; // (column_count) the variable it holds, or DESIGNS_ID
    int32_t id;       // column of the id; -1: there is none
};

// Reads the header, the line `line` of `source`. On success the caller releases it. Errors:
// STATUS_INVALID (a column is no variable of the scenario, comes twice, or is missing).
enum status designs_layout_read(struct designs_layout *layout, const struct scenario *scenario,
                                const char *source, uint64_t line, const char *text, size_t size,
                                struct error *error) MUST_USE;

void designs_layout_fini(struct designs_layout *layout);

// The rows of a piece.
struct designs {
    uint32_t count;
    double *values;   // (count x variables) design by design; fixed variables filled in
    const char **ids; // (count) where its id begins in the text, not terminated; NULL: none has one
    uint32_t *id_sizes; // (count) [bytes]
};

// Reads rows of designs, the first in line `line`. On success the caller releases them; `text` is
// borrowed as long as the ids are. Depends on its arguments alone, so many pieces may be read at
// once. Errors: STATUS_INVALID (a row has too few or too many fields; a value is no finite number).
enum status designs_read(struct designs *designs, const struct designs_layout *layout,
                         const char *source, uint64_t line, const char *text, size_t size,
                         struct error *error) MUST_USE;

void designs_fini(struct designs *designs);

#endif
