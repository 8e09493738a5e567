// What a run folder shows: result.json, corridors.csv, history.csv, the table for the terminal and
// the plots, all made from run.db alone, so that they can be made again at any time, also of a run
// that is not finished.
#ifndef SOBOX_COORDINATOR_REPORT_REPORT_H
#define SOBOX_COORDINATOR_REPORT_REPORT_H

#include "common/base/error.h"

#include <stdbool.h>
#include <stdio.h>

enum report_format { REPORT_SVG, REPORT_PNG, REPORT_PDF };

struct report_plot {
    enum report_format format;
    const char *compare; // second run folder drawn over the first, or NULL
    bool normalise; // axes divided by their greatest value (thesis eq. 5.2): nothing secret shown
    const char *output; // file to write; NULL: corridors.FORMAT in the run folder
};

// Writes result.json, corridors.csv and history.csv into the run folder; each is whole or absent.
// Errors: STATUS_IO.
enum status report_write(const char *directory, struct error *error) MUST_USE;

// Draws the corridors with gnuplot: one panel a spring and direction. Leaves the script
// (corridors.gp) and its data in the run folder for users to edit.
// Errors: STATUS_FAILED (gnuplot is missing or failed: the text says which), STATUS_IO.
enum status report_draw(const char *directory, const struct report_plot *plot,
                        struct error *error) MUST_USE;

// Prints the corridors, the purity with its bound, the cost and the files to `out`.
enum status report_print(const char *directory, FILE *out, struct error *error) MUST_USE;

#endif
