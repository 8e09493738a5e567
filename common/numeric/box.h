// A box: one interval per design variable. Drawn over deformation, the intervals of one spring and
// direction are a corridor.
//
//        F2 ^   +-------------+ upper[1]
//           |   |   a box     |
//           |   +-------------+ lower[1]
//           +--------------------> F1
#ifndef SOBOX_COMMON_NUMERIC_BOX_H
#define SOBOX_COMMON_NUMERIC_BOX_H

#include <stdbool.h>
#include <stdint.h>

struct box {
    uint32_t count; // variables
    double *lower;  // (count) the unit of the variable
    double *upper;  // (count) lower[i] <= upper[i]; equal where the variable is fixed
};

// Makes room for `count` intervals [0, 0]. The caller releases it with box_fini().
void box_init(struct box *box, uint32_t count);

// Releases a box. A zeroed struct is fine.
void box_fini(struct box *box);

// Copies bounds. Both have the same count.
void box_assign(struct box *box, const struct box *from);

// Whether both have the same count and bit-identical bounds.
bool box_equal(const struct box *a, const struct box *b);

// Sum over the free variables of ln(width / width in `space`): 0 for the whole design space, -inf
// for a box without width. A variable is free when `space` gives it a width.
double box_log_volume(const struct box *box, const struct box *space);

// How many variables of `space` are free.
uint32_t box_free_count(const struct box *space);

// Whether every coordinate of `point` (count) lies within the bounds, bounds included.
bool box_contains(const struct box *box, const double *point);

// Whether every interval of `inner` lies within that of `outer`.
bool box_inside(const struct box *inner, const struct box *outer);

#endif
