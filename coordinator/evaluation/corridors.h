// Corridors as a table: the corridors.csv of a run folder, perhaps changed by hand or by a
// spreadsheet, read back as a box of a scenario.
//
//     spring,direction,deformation_m,lower_N,upper_N
//     front,x,0.15,45e3,80e3
//     front,y,0.15,0,31e3
//
// Columns are found by their names, may stand in any order, and others are not looked at. Of a
// variable that is no spring's force the name stands under `spring`, and nothing under direction
// and deformation. A bound that misses the design space by no more than the rounding of a
// spreadsheet lies on its edge. Variables that the scenario fixes may be left out. The text is as
// untrusted as any file.
#ifndef SOBOX_COORDINATOR_EVALUATION_CORRIDORS_H
#define SOBOX_COORDINATOR_EVALUATION_CORRIDORS_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"

// Reads a box of all variables of the scenario from a table, or from the corridors.csv of a run
// folder. On success the caller releases it; else it is left zeroed. Errors: STATUS_INVALID (with
// FILE:LINE:COLUMN: there are no rows; a row is no variable of the scenario or comes twice; a bound
// is no number, lies outside the design space or above the other; a variable is missing).
enum status corridors_read(struct box *box, const struct scenario *scenario, const char *path,
                           struct error *error) MUST_USE;

// The same as the value that `search.box` has in a scenario: "{lower: [...], upper: [...]}", exact
// to the bit. Released with g_free().
char *corridors_text(const struct box *box);

#endif
