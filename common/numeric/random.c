#include "common/numeric/random.h"

double random_uniform(uint64_t seed, uint32_t search, uint32_t step, uint32_t index,
                      uint32_t variable)
{
    const uint32_t counter[4] = {variable / 2, index, step, search};
    const uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
    uint32_t block[4];
    random_philox(counter, key, block);
    const uint32_t *half = block + 2 * (variable % 2);
    return random_unit(half[0], half[1]);
}
