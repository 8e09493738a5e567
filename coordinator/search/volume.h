// The volume of a box in units of another, as mantissa and exponent: with hundreds of variables it
// leaves the range of a double, and a logarithm, which machines round differently, must not decide
// which of two boxes is larger.
#ifndef SOBOX_COORDINATOR_SEARCH_VOLUME_H
#define SOBOX_COORDINATOR_SEARCH_VOLUME_H

#include "common/numeric/box.h"

struct volume {
    double mantissa;  // in [0.5, 1), or 0
    int64_t exponent; // of two
};

// Product of width / width in `space` over the variables that have a width there.
struct volume volume_of(const struct box *box, const struct box *space);

// Product of (width / width in `space`) to the power of the variable's weight (> 0). Logarithms and
// powers are summed from their series, so that all machines round the same.
struct volume volume_weighted(const struct box *box, const struct box *space,
                              const double *weights);

// Whether a > b.
bool volume_above(struct volume a, struct volume b);

#endif
