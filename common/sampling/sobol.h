// Sobol points: a low-discrepancy sequence, so that the samples of a step fill the box more evenly
// than random ones. Any point of any variable is computed alone, from the bits of its index.
//
// Each variable has a primitive polynomial over GF(2) of its own, taken in order of degree, and
// direction numbers that start from random odd integers drawn for the variable (Sobol, 1967; any
// odd start gives a digital (0, m, 1)-sequence in each variable). All points of a step are
// scrambled: a random digital shift and a random lower-triangular matrix (Matousek, 1998), keyed by
// seed, step and variable, so that steps are independent and points are uniform one by one.
#ifndef SOBOX_COMMON_SAMPLING_SOBOL_H
#define SOBOX_COMMON_SAMPLING_SOBOL_H

#include "common/sampling/sampling.h"

enum { SOBOL_BITS = 32 };

// One variable of one step.
struct sobol {
    uint32_t direction[SOBOL_BITS]; // scrambled; for bit b of the index
    uint32_t shift;
    uint32_t tail; // keys the bits below the 32 that the sequence fixes
};

void sobol_init(struct sobol *sobol, const struct sampling *sampling, uint32_t variable);

// Number of sample `index`, in [0, 1).
double sobol_of(const struct sobol *sobol, uint32_t index);

#endif
