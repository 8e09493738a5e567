// A design of a model in closed form: a number for each variable.
//
//     variable,value
//     F1,400e3
//     F2,550e3
#ifndef SOBOX_WORKER_MODELS_POINT_H
#define SOBOX_WORKER_MODELS_POINT_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"
#include "worker/models/design.h"

#include <stddef.h>

// Fills `values` (one a variable) with the middle or a bound of the design space.
void point_place(double *values, const struct scenario *scenario, enum design_place place);

// Fills `values` (one a variable) from the text of a CSV file; `source` stands for the file in
// messages. Rows may stand in any order; fixed variables may be left out. Values may lie outside
// the design space, as a design's forces may. Errors: STATUS_INVALID.
enum status point_parse(double *values, const struct scenario *scenario, const char *source,
                        const char *text, size_t size, struct error *error) MUST_USE;

#endif
