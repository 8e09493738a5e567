// The components of a car's front structure as boxes in space, read from a table:
//
//     name,group,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m,z_max_m,force_x_N,force_y_N
//     tyre,wheel,-1.46,-1.08,-0.91,-0.59,0.15,0.70,250e3,175e3
//
// x and y are those of the scenario at first contact: from the centre of gravity, forwards is -x,
// the struck side is at negative y. z is the height above the road.
#ifndef SOBOX_WORKER_COMPONENTS_COMPONENT_H
#define SOBOX_WORKER_COMPONENTS_COMPONENT_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    COMPONENT_MAX = 1024, // boxes of a table
    COMPONENT_AXIS_COUNT = 3,
};

// An axis-parallel box.
struct component_box {
    double min[COMPONENT_AXIS_COUNT]; // [m] x, y, z
    double max[COMPONENT_AXIS_COUNT]; // [m] each above its min
};

struct component {
    char name[SCENARIO_NAME_SIZE];
    char group[SCENARIO_NAME_SIZE]; // "": the table leaves it to group_make()
    struct component_box box;
    double force[SCENARIO_DIRECTION_COUNT]; // [N] the greatest that it can carry; NAN: not given
    uint32_t line;                          // of the table, from 1
};

struct component_list {
    const char *source; // stands for the table in messages; borrowed
    struct component items[COMPONENT_MAX];
    uint32_t count;
    bool forces; // every component has both forces
};

// Reads the boxes from the text of a CSV file; `source` stands for the file in messages, now
// and later. Columns stand in any order; group and the two forces may be left out. Errors:
// STATUS_INVALID, "FILE:LINE:COLUMN: ..." (also for lengths that can only be millimetres, and names
// used twice).
enum status component_parse(struct component_list *list, const char *source, const char *text,
                            size_t size, struct error *error) MUST_USE;

#endif
