// Which components share a spring. Those that the table puts into one group do; the others are
// grouped by where they stand: components in line along the car, one behind the other, are pressed
// by the same force, so they share a spring and their lengths add.
//
//      z ^   +-----------+-------+         seen from the front; each group's patch is the
//        |   |  shotgun  | dome  |         rectangle around its components
//        |   +------+----+-------+
//        |   |      |   rail     |         x from the front:   |crash box|  rail  |dash
//        |   | wheel+------------+                             <----- one spring ---->
//            ------------------------> y
//
// A component without a group joins the patch with which it shares the most, where that is at
// least half of the smaller of the two rectangles; else it founds a group of its own name. The
// table's order decides, named groups first.
#ifndef SOBOX_WORKER_COMPONENTS_GROUP_H
#define SOBOX_WORKER_COMPONENTS_GROUP_H

#include "worker/components/component.h"

enum { GROUP_MAX = SCENARIO_SPRING_MAX };

struct group {
    char name[SCENARIO_NAME_SIZE];
    struct component_box box; // around all its components
    uint32_t component_count;
};

struct group_list {
    struct group items[GROUP_MAX]; // in the order in which the table names them
    uint32_t count;
    uint32_t of[COMPONENT_MAX]; // the group of each component
};

// Groups the components. Errors: STATUS_INVALID (more than GROUP_MAX groups).
enum status group_make(struct group_list *groups, const struct component_list *components,
                       struct error *error) MUST_USE;

// The area that two boxes share, seen from the front. [m2]
double group_shared_area(const struct component_box *one, const struct component_box *other);

#endif
