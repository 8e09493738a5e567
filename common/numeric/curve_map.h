// Which variables of a design make a curve. A department does not build independent points: it
// builds a curve, often along a bound from end to end, so a box is also judged by designs whose
// curves stand at one level of their corridors (common/sampling).
//
//     variable   0  1  2  3  4  5        front.force_x[0..2], front.force_y[0..2]
//     curve      0  0  0  1  1  1        one of each direction
//     group      0  0  0  1  1  1        all curves of force_x, all curves of force_y
//
// In models without curves each variable is its own curve and its own group.
#ifndef SOBOX_COMMON_NUMERIC_CURVE_MAP_H
#define SOBOX_COMMON_NUMERIC_CURVE_MAP_H

#include <stdint.h>

struct curve_map {
    uint32_t variables;
    uint32_t count;       // curves
    uint32_t *curve;      // (variables) 0 .. count - 1
    uint32_t group_count; // groups of curves that are strong or light together
    uint32_t *group;      // (variables) 0 .. group_count - 1
};

// Makes each of `variables` a curve and a group of its own; whoever knows better changes them. The
// caller releases it with curve_map_fini().
void curve_map_init(struct curve_map *map, uint32_t variables);

// Releases curves. A zeroed struct is fine.
void curve_map_fini(struct curve_map *map);

#endif
