// Runs gnuplot as a child process, without a shell.
#ifndef SOBOX_COORDINATOR_REPORT_GNUPLOT_H
#define SOBOX_COORDINATOR_REPORT_GNUPLOT_H

#include "common/base/error.h"

#include <glib.h>

// Lets gnuplot run a script of figure.h and returns the picture in `format` ("svg", "png", "pdf").
// The caller releases it. Errors: STATUS_FAILED (gnuplot is not there or failed).
enum status gnuplot_run(const char *script_path, const char *format, GBytes **picture,
                        struct error *error) MUST_USE;

#endif
