// What makes a search's result doubtful, for table, result.json and documents: what is not
// plausible about its scenario (common/scenario/plausibility.h), and a design space of which
// everything is good, which only the search can find out.
#ifndef SOBOX_COORDINATOR_REPORT_WARNINGS_H
#define SOBOX_COORDINATOR_REPORT_WARNINGS_H

#include "coordinator/report/run_data.h"

#include <stdio.h>

// The warnings of a search, ending with NULL, without the places of a file that the reader may not
// have. Released with g_strfreev().
char **warnings_of(const struct run_data_search *search);

bool warnings_any(const struct run_data_search *search);

// A line for each.
void warnings_print(const struct run_data_search *search, FILE *out);

#endif
