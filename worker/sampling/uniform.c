#include "worker/sampling/uniform.h"

#include "common/numeric/random.h"

#include <assert.h>

void uniform_block(const struct sampling *sampling, uint32_t variable, uint32_t first,
                   double *restrict even, double *restrict odd)
{
    assert(variable % 2 == 0);
    const uint32_t key[2] = {(uint32_t)sampling->seed, (uint32_t)(sampling->seed >> 32)};
    for (uint32_t i = 0; i < UNIFORM_BLOCK; i++) {
        // The 0 is where random_uniform() has the search: see sampling.h.
        const uint32_t counter[4] = {variable / 2, first + i, sampling->step, 0};
        uint32_t block[4];
        random_philox(counter, key, block);
        even[i] = random_unit(block[0], block[1]);
        odd[i] = random_unit(block[2], block[3]);
    }
}
