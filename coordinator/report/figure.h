// The corridors as a gnuplot script that carries its data: a row a spring, axial force on the left,
// lateral force on the right.
//
//     title, subtitle, legend
//     +-----------+  +-----------+
//     |   ____    |  |           |   grey: the design space
//     |  /####\__ |  |  ______   |   blue: the corridor
//     | /   ##### |  | /######\  |   orange: the corridor of the run it is compared with
//     +-----------+  +-----------+
#ifndef SOBOX_COORDINATOR_REPORT_FIGURE_H
#define SOBOX_COORDINATOR_REPORT_FIGURE_H

#include "coordinator/report/run_data.h"

struct figure {
    const struct run_data_search *search; // borrowed
    const struct run_data_search *other;  // drawn over it, or NULL; borrowed
    const char *search_label;             // what tells the two apart in the legend
    const char *other_label;
    const struct box *spread; // of the search's bounds over several seeds, or NULL; borrowed
    bool normalise;   // (value - least) / (greatest - least), thesis eq. 5.2, in place of units
    const char *stem; // of the file that the script writes when run by hand
};

// How many springs of the other run have the name of one of this run.
uint32_t figure_shared_springs(const struct run_data_search *search,
                               const struct run_data_search *other);

// The script. It draws to the file named by the gnuplot variable `output` in the format named by
// `format` ('svg', 'png', 'pdf'); without them to STEM.svg. The caller frees it.
char *figure_script(const struct figure *figure);

#endif
