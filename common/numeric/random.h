// Counter-based random numbers: Philox4x32-10 of Salmon, Moraes, Dror and Shaw, "Parallel random
// numbers: as easy as 1, 2, 3" (SC 2011). Every number is a function of where it is used, so any
// worker makes any sample alone and no state is passed around.
#ifndef SOBOX_COMMON_NUMERIC_RANDOM_H
#define SOBOX_COMMON_NUMERIC_RANDOM_H

#include <stdint.h>

// One Philox4x32-10 block: 128 random bits from a 128-bit counter and a 64-bit key. Inline, so that
// loops over samples turn into vector code. The multipliers and key increments are those of the
// paper's table 2.
static inline void random_philox(const uint32_t counter[4], const uint32_t key[2],
                                 uint32_t block[4])
{
    uint32_t c0 = counter[0], c1 = counter[1], c2 = counter[2], c3 = counter[3];
    uint32_t k0 = key[0], k1 = key[1];
#pragma GCC unroll 10
    for (int round = 0; round < 10; round++) {
        uint64_t product_0 = UINT64_C(0xD2511F53) * c0;
        uint64_t product_1 = UINT64_C(0xCD9E8D57) * c2;
        c0 = (uint32_t)(product_1 >> 32) ^ c1 ^ k0;
        c1 = (uint32_t)product_1;
        c2 = (uint32_t)(product_0 >> 32) ^ c3 ^ k1;
        c3 = (uint32_t)product_0;
        k0 += UINT32_C(0x9E3779B9); // the golden ratio as a fraction
        k1 += UINT32_C(0xBB67AE85); // sqrt(3) - 1
    }
    block[0] = c0;
    block[1] = c1;
    block[2] = c2;
    block[3] = c3;
}

// A number in [0, 1) from 64 random bits: the 27 leading bits of `high`, then the 26 of `low`. Both
// parts are exact in a double, and so is their sum.
static inline double random_unit(uint32_t high, uint32_t low)
{
    return ((double)(int32_t)(high >> 5) * 0x1p26 + (double)(int32_t)(low >> 6)) * 0x1p-53;
}

// The number of variable `variable` of sample `index` in step `step` of search `search`: uniform
// in [0, 1) with 53 random bits. Variables 2k and 2k+1 share one Philox block, whose counter is
// {variable / 2, index, step, search} and whose key is the seed, low word first; 2k takes its words
// 0 and 1, 2k+1 its words 2 and 3, as random_unit() of them. Counters whose first word has the
// highest bit set are never used for this and are free for other purposes.
double random_uniform(uint64_t seed, uint32_t search, uint32_t step, uint32_t index,
                      uint32_t variable);

#endif
