// Runs gnuplot as a child process, without a shell, and writes texts into its scripts.
#ifndef SOBOX_COMMON_PLOT_GNUPLOT_H
#define SOBOX_COMMON_PLOT_GNUPLOT_H

#include "common/base/error.h"

#include <glib.h>

// Lets gnuplot run a script that picture_begin() began and returns the picture in `format` ("svg",
// "png", "pdf"). The caller releases it. Errors: STATUS_FAILED (gnuplot is not there or failed).
enum status gnuplot_run(const char *script_path, const char *format, GBytes **picture,
                        struct error *error) MUST_USE;

// A text as a gnuplot string that is only ever text. The caller frees it.
char *gnuplot_quoted(const char *text);

// The same for the name of a tick, "set xtics (NAME 0)", which gnuplot takes as a format where it
// holds a per cent sign.
char *gnuplot_tick(const char *text);

#endif
