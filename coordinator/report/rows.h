// A sweep as a table in memory: of each case what it is and how it ended, without its corridors and
// steps. What its pictures and documents are made from.
#ifndef SOBOX_COORDINATOR_REPORT_ROWS_H
#define SOBOX_COORDINATOR_REPORT_ROWS_H

#include "coordinator/report/run_data.h"

// One case.
struct rows_row {
    uint32_t index; // of the search in the run
    char *name;
    char *status;
    char **values;         // on the axes, ends with NULL
    uint32_t group;        // cases that differ in their seed alone share one
    double log_volume;     // NAN where there are no corridors
    double purity_lower95; // NAN where there is no certificate
    char *costliest;       // constraint, with what relaxing it by 1 % gains; NULL: not known
    uint64_t evaluations;
    double wall_s;
};

// A warning and how many cases have it.
struct rows_warning {
    char *text;
    uint32_t count;
    uint32_t first; // index of the first row that has it
};

enum { ROWS_WARNINGS_MAX = 50 }; // different ones that are kept; more would be read by nobody

struct rows {
    char *name; // of the sweep
    char *version;
    char **axes; // ends with NULL
    uint32_t axis_count;
    struct rows_row *items; // (count) in the order of the sweep
    uint32_t count;
    uint32_t group_count;
    uint32_t done;                                   // how many searches are done
    uint32_t found;                                  // and have corridors
    struct rows_warning warnings[ROWS_WARNINGS_MAX]; // (warning_count)
    uint32_t warning_count;
};

// Reads the run folder of a sweep. On failure the struct is zeroed.
// Errors: STATUS_INVALID (the run is no sweep), and those of run_data_open().
enum status rows_read(struct rows *rows, const char *directory, struct error *error) MUST_USE;

void rows_fini(struct rows *rows);

// The axis of that path, or of that last key where only one ends so; axis_count when there is none.
uint32_t rows_axis(const struct rows *rows, const char *path);

// The values of an axis in the order in which they appear, each once, ending with NULL. They belong
// to the rows, the list to the caller (g_free).
const char **rows_values(const struct rows *rows, uint32_t axis, uint32_t *count);

// Whether an axis says nothing that another does not say already: each value of `other` goes with
// one of it, as in a zip.
bool rows_follows(const struct rows *rows, uint32_t axis, uint32_t other);

// Whether the axis is the seed, over which the others are repeated.
bool rows_is_seed(const struct rows *rows, uint32_t axis);

// The row of a group with the largest log-volume; NULL when none has corridors.
const struct rows_row *rows_best(const struct rows *rows, uint32_t group);

// The middle one of numbers (count > 0), the mean of the two in the middle; sorts them.
double rows_median(double *numbers, uint32_t count);

#endif
