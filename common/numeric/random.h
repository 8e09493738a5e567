// Counter-based random numbers: Philox4x32-10 of Salmon, Moraes, Dror and Shaw, "Parallel random
// numbers: as easy as 1, 2, 3" (SC 2011). Every number is a function of where it is used, so any
// worker makes any sample alone and no state is passed around.
#ifndef SOBOX_COMMON_NUMERIC_RANDOM_H
#define SOBOX_COMMON_NUMERIC_RANDOM_H

#include <stdint.h>

// One Philox4x32-10 block: 128 random bits from a 128-bit counter and a 64-bit key.
void random_philox(const uint32_t counter[4], const uint32_t key[2], uint32_t block[4]);

// The number of variable `variable` of sample `index` in step `step` of search `search`: uniform
// in [0, 1) with 53 random bits. Variables 2k and 2k+1 share one Philox block, whose counter is
// {variable / 2, index, step, search} and whose key is the seed, low word first.
double random_uniform(uint64_t seed, uint32_t search, uint32_t step, uint32_t index,
                      uint32_t variable);

#endif
