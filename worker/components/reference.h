// Reference curves, measured or from a finite-element crash, from which discretization points are
// chosen. A design as sobox-barrier-forces writes it is such a table; its unload branches are
// passed over.
//
//     spring,branch,deformation_m,force_x_N,force_y_N
//     wheel,load,0.00,0,0
//     wheel,load,0.02,31e3,4e3
#ifndef SOBOX_WORKER_COMPONENTS_REFERENCE_H
#define SOBOX_WORKER_COMPONENTS_REFERENCE_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"

#include <stddef.h>

enum {
    REFERENCE_MAX = SCENARIO_SPRING_MAX, // curves of a table
    REFERENCE_POINT_MAX = 100000,        // of a curve
};

struct reference {
    char name[SCENARIO_NAME_SIZE];
    uint32_t count;                          // points, at least 2
    double *deformation;                     // [m] ascending by 0.1 mm at least (count)
    double *force[SCENARIO_DIRECTION_COUNT]; // [N] (count) each
    uint32_t passed; // rows that went back, or not on by 0.1 mm: the first pass counts
};

struct reference_list {
    struct reference items[REFERENCE_MAX];
    uint32_t count;
};

// Reads the curves from the text of a CSV file; `source` stands for the file in messages. Columns
// stand in any order; branch may be left out. On success the caller releases the list; else it is
// left zeroed. Errors: STATUS_INVALID, "FILE:LINE:COLUMN: ...".
enum status reference_parse(struct reference_list *list, const char *source, const char *text,
                            size_t size, struct error *error) MUST_USE;

// The curve of that name, or NULL.
const struct reference *reference_find(const struct reference_list *list, const char *name);

// Releases what it owns. A zeroed struct is fine.
void reference_fini(struct reference_list *list);

#endif
