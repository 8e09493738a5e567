// The log-volume of a sweep's corridors against one axis, as lines, or two, as a heat map: gnuplot
// scripts that carry their data. Cases that differ in nothing else are dots, the line goes through
// their medians.
#ifndef SOBOX_COORDINATOR_REPORT_VOLUME_H
#define SOBOX_COORDINATOR_REPORT_VOLUME_H

#include "coordinator/report/rows.h"

// Against `axis`: a line for each combination of the other axes, the seed and axes that follow
// `axis` excepted; one line over all where there would be more than eight. `stem` names the file
// that the script writes when run by hand. The caller frees it.
char *volume_lines(const struct rows *rows, uint32_t axis, const char *stem);

// Against two axes: the median of all cases of each cell.
char *volume_map(const struct rows *rows, uint32_t across, uint32_t up, const char *stem);

#endif
