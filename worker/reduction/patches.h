// Which spring takes a force that acts on the barrier (thesis 7.2.1, "the mid distance between two
// springs as the boundary of the spring"). Every spring whose line meets the barrier's face has a
// patch around the point where it does; the patches move with the vehicle.
//
//      z ^   |     b     |  d  |          a, b stand one above the other and share a column, which
//        |   |- - - - - -|     |    e     is divided half-way between their heights. Columns are
//        |   |     a     |     |          divided half-way between projection points; the outermost
//            far_y                edge_y  reach to the ends of the face.
//
// Where the components of each spring are known as boxes, a force goes to the spring whose
// rectangle is nearest to it, of those that overlap there to the one whose middle is. The
// rectangles move with the projection points.
//
// A spring that has no projection, because its line passes the face or the vehicle turned by more
// than 90 degrees, has no patch: it could not hand on the force, and its neighbours take it.
#ifndef SOBOX_WORKER_REDUCTION_PATCHES_H
#define SOBOX_WORKER_REDUCTION_PATCHES_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"
#include "worker/components/group.h"

#include <stdbool.h>

#define PATCHES_NONE UINT32_MAX // no spring

struct patches_spring {
    double deformation; // [m]
    double projection;  // [m] y of P2
    bool projected;     // P2 lies on the barrier
};

struct patches {
    const struct scenario *scenario; // borrowed
    struct patches_spring springs[SCENARIO_SPRING_MAX];
    const struct group *groups[SCENARIO_SPRING_MAX]; // of each spring, borrowed; NULL: no boxes

    // Springs in order of their y, then of their height; a column is a run of equal y.
    uint32_t order[SCENARIO_SPRING_MAX];
    uint32_t column_first[SCENARIO_SPRING_MAX + 1]; // in `order`
    uint32_t column_count;

    // Columns that have a projection now, and the upper ends of their patches in y.
    uint32_t shown[SCENARIO_SPRING_MAX];
    double border[SCENARIO_SPRING_MAX]; // [m]
    uint32_t shown_count;
};

// Takes in the springs of a scenario, and the groups of components of their names, or NULL; both
// stay in use. Errors: STATUS_INVALID (a spring has no group; without groups springs that share y
// need heights, and different ones).
enum status patches_init(struct patches *patches, const struct scenario *scenario,
                         const struct group_list *groups, struct error *error) MUST_USE;

// Moves the vehicle: its COG to (x, y) [m] in the scenario's axes, its yaw [rad].
void patches_move(struct patches *patches, double x, double y, double yaw);

// The spring in whose patch the point (y, z) [m] of the barrier lies, or PATCHES_NONE.
uint32_t patches_find(const struct patches *patches, double y, double z);

#endif
