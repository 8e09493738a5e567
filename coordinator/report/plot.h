// From a gnuplot script to a picture.
#ifndef SOBOX_COORDINATOR_REPORT_PLOT_H
#define SOBOX_COORDINATOR_REPORT_PLOT_H

#include "coordinator/report/report.h"

#include <glib.h>

// Writes the script beside `output` and under its name (STEM.gp), lets gnuplot make the picture,
// and writes that. Errors: STATUS_FAILED (gnuplot), STATUS_IO.
enum status plot_write(const char *script, const char *output, enum report_format format,
                       struct error *error) MUST_USE;

// The picture as SVG text without the head that stands before its <svg> element, to stand in HTML.
// The caller frees it. Errors: STATUS_FAILED, STATUS_IO.
enum status plot_inline(const char *script, char **svg, struct error *error) MUST_USE;

// Where a picture goes: plot->output, or a file of the run folder named NAME.FORMAT, with -compared
// and -normalised behind the name where it is. The caller frees it.
char *plot_output(const char *directory, const char *name, const struct report_plot *plot);

// The name of a picture's file without folder and ending, for its script. The caller frees it.
char *plot_stem(const char *output);

#endif
