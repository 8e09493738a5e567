// Where the pictures of a run go.
#ifndef SOBOX_COORDINATOR_REPORT_PLOT_H
#define SOBOX_COORDINATOR_REPORT_PLOT_H

#include "coordinator/report/report.h"

// Where a picture goes: plot->output, or a file of the run folder named NAME.FORMAT, with -compared
// and -normalised behind the name where it is. The caller frees it.
char *plot_output(const char *directory, const char *name, const struct report_plot *plot);

#endif
