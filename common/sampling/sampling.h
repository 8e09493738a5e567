// The samples of a step, drawn from a box. Sample i of a step is a function of (seed, step, i,
// variable) alone, so that any worker makes any part of a step and the coordinator makes it again
// when it trims. The number of the search in its run has no part in it: a case of a sweep gives the
// same bits as its scenario run alone, and cases with one seed are compared on the same numbers.
#ifndef SOBOX_COMMON_SAMPLING_SAMPLING_H
#define SOBOX_COMMON_SAMPLING_SAMPLING_H

#include "common/numeric/box.h"
#include "common/numeric/curve_map.h"
#include "common/protocol/protocol.h"
#include "common/sampling/moves.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct sampling {
    uint64_t seed;
    uint32_t step;    // of the search, over all phases
    uint32_t samples; // of the whole step: a Latin hypercube has that many strata
    enum sampling_method method;
    const struct curve_map
        *curves; // borrowed; of the methods that draw levels of curves and of moves, else unused
    const struct moves *moves; // borrowed; of SAMPLING_METHOD_MOVES, else unused
};

// Whether a method's samples can be made again by whoever knows the box and no more: each variable
// on its own.
static inline bool sampling_of_points(enum sampling_method method)
{
    return method <= SAMPLING_METHOD_SOBOL;
}

// Whether a method draws levels of whole curves.
static inline bool sampling_of_curves(enum sampling_method method)
{
    return method >= SAMPLING_METHOD_CURVES && method <= SAMPLING_METHOD_EXTREMES;
}

// Fills in samples first .. first + count - 1: values[variable * stride + i] belongs to sample
// first + i. lower <= value <= upper always; a fixed variable has its lower bound exactly.
// stride >= count.
void sampling_fill(const struct sampling *sampling, const struct box *box, uint32_t first,
                   uint32_t count, double *values, size_t stride);

// Fills in those samples of a step that `index` (count, ascending) names: values[variable * stride
// + i] belongs to sample index[i]. The same bits as sampling_fill() gives it. stride >= count.
void sampling_pick(const struct sampling *sampling, const struct box *box, const uint32_t *index,
                   uint32_t count, double *values, size_t stride);

#endif
