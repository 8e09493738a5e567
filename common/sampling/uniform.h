// random_uniform() for many samples at once: one Philox block a sample gives two variables, and the
// samples stand side by side in vector registers. Integer arithmetic and exact conversions only, so
// every width gives the same bits; the widest that the processor has is chosen when first used.
#ifndef SOBOX_COMMON_SAMPLING_UNIFORM_H
#define SOBOX_COMMON_SAMPLING_UNIFORM_H

#include "common/sampling/sampling.h"

enum { UNIFORM_BLOCK = 64 }; // samples made at once: whole vectors of every width

// even[i] and odd[i] (UNIFORM_BLOCK) become random_uniform() of sample first + i in the variables
// `variable` (even) and variable + 1. Always fills whole blocks.
void uniform_block(const struct sampling *sampling, uint32_t variable, uint32_t first,
                   double *restrict even, double *restrict odd);

#endif
