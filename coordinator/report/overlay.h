// The corridors of several cases over each other: a row a spring, axial force on the left, lateral
// force on the right, each case's two bounds in a colour of its own over the design space of the
// first. The script carries its data.
#ifndef SOBOX_COORDINATOR_REPORT_OVERLAY_H
#define SOBOX_COORDINATOR_REPORT_OVERLAY_H

#include "coordinator/report/run_data.h"

enum { OVERLAY_MAX = 8 }; // cases whose colours can be told apart

struct overlay {
    const char *title;
    const struct run_data_search *searches; // (count) with corridors, of models with springs
    uint32_t count;                         // 1..OVERLAY_MAX
    bool normalise;                         // forces and deformations from 0 to 1, without units
    const char *stem;                       // of the file that the script writes when run by hand
};

// The caller frees it. Springs are those of the first case; a case that has none of the name is not
// in its panels.
char *overlay_script(const struct overlay *overlay);

#endif
