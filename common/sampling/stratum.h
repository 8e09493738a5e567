// Which stratum of a Latin hypercube a sample has in a variable: a keyed pseudo-random permutation
// of 0 .. samples-1, so that any worker knows the place of any sample without having drawn the
// others. A Feistel network permutes the next power of two; a number that lands outside walks on
// along its cycle until it lands inside, which keeps it a permutation.
#ifndef SOBOX_COMMON_SAMPLING_STRATUM_H
#define SOBOX_COMMON_SAMPLING_STRATUM_H

#include "common/sampling/sampling.h"

struct stratum {
    uint32_t samples;   // strata
    uint32_t low_bits;  // of the number: the half that the odd rounds change
    uint32_t low_mask;  // (1 << low_bits) - 1
    uint32_t high_mask; // of the other half; low_bits or one bit less
    uint32_t key[4];
};

// The permutation of one variable of a step.
void stratum_init(struct stratum *stratum, const struct sampling *sampling, uint32_t variable);

// The stratum of sample `index` (below samples): 0 .. samples-1, each once.
uint32_t stratum_of(const struct stratum *stratum, uint32_t index);

#endif
