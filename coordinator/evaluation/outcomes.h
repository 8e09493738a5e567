// The outcomes of designs as rows of comma-separated values, in the order of the designs:
//
//     id,s_L,AbWAP,...,good,violated
//     a1,0.3125,1.02,...,1,
//     a2,0.1875,0.94,...,0,s_L;AbWAP
//
// `good` is 1 or 0, `violated` the outcomes whose constraints are not met. A number that is not
// finite is nan, inf or -inf. Without ids in the table of designs they are numbered from 1.
#ifndef SOBOX_COORDINATOR_EVALUATION_OUTCOMES_H
#define SOBOX_COORDINATOR_EVALUATION_OUTCOMES_H

#include "common/base/error.h"
#include "coordinator/evaluation/designs.h"

#include <glib.h>

// Which outcomes are written.
struct outcomes_layout {
    const struct scenario *scenario; // borrowed
    uint32_t *outcomes;              // (count) of the scenario
    uint32_t count;
};

// Takes the names of outcomes, separated by commas; NULL: all. The caller releases it. Errors:
// STATUS_INVALID (the scenario has no such outcome).
enum status outcomes_layout_read(struct outcomes_layout *layout, const struct scenario *scenario,
                                 const char *names, struct error *error) MUST_USE;

void outcomes_layout_fini(struct outcomes_layout *layout);

// What the rows say together.
struct outcomes_sums {
    uint64_t good;
    uint64_t non_finite; // designs of which some outcome is
};

// Appends the header.
void outcomes_header(const struct outcomes_layout *layout, GString *text);

// Appends a row for each of the designs, of which the first is number `first` (from 1), and adds
// to `sums`. values[design * outcomes of the scenario + outcome] are what came of them. Depends on
// its arguments alone.
void outcomes_rows(const struct outcomes_layout *layout, const struct designs *designs,
                   uint64_t first, const double *values, GString *text, struct outcomes_sums *sums);

#endif
