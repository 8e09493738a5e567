// random_philox() and random_unit() on vectors, for a source that says what a vector is:
// WORDS_LANES 32-bit words, each in the low half of 64 bits, which is where the machine multiplies
// them. What stands in the high halves is ignored until WORDS_UNIT, which clears it.
#ifndef SOBOX_COMMON_SAMPLING_UNIFORM_WIDE_H
#define SOBOX_COMMON_SAMPLING_UNIFORM_WIDE_H

#include "common/sampling/uniform_path.h"

#include <assert.h>

enum { WIDE_ROUNDS = 10 };

_Static_assert((int)UNIFORM_BLOCK % (int)WORDS_LANES == 0, "a block is whole vectors");

static inline void uniform_wide(const struct sampling *sampling, uint32_t variable, uint32_t first,
                                double *restrict even, double *restrict odd)
{
    assert(variable % 2 == 0);
    const words multiplier_0 = WORDS_SET(0xD2511F53);
    const words multiplier_2 = WORDS_SET(0xCD9E8D57);
    for (uint32_t i = 0; i < UNIFORM_BLOCK; i += WORDS_LANES) {
        // The counter as uniform_plain() has it.
        words c0 = WORDS_SET(variable / 2);
        words c1 = WORDS_ADD(WORDS_SET(first + i), WORDS_INDEX());
        words c2 = WORDS_SET(sampling->step);
        words c3 = WORDS_SET(0);
        uint32_t k0 = (uint32_t)sampling->seed;
        uint32_t k1 = (uint32_t)(sampling->seed >> 32);
#pragma GCC unroll 10
        for (int round = 0; round < WIDE_ROUNDS; round++) {
            const words product_0 = WORDS_MUL(multiplier_0, c0);
            const words product_1 = WORDS_MUL(multiplier_2, c2);
            c0 = WORDS_XOR(WORDS_HIGH(product_1), c1, WORDS_SET(k0));
            c2 = WORDS_XOR(WORDS_HIGH(product_0), c3, WORDS_SET(k1));
            c1 = product_1;
            c3 = product_0;
            k0 += UINT32_C(0x9E3779B9);
            k1 += UINT32_C(0xBB67AE85);
        }
        WORDS_STORE(even + i, WORDS_UNIT(c0, c1));
        WORDS_STORE(odd + i, WORDS_UNIT(c2, c3));
    }
}

#endif
