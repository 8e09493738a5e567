#include "common/sampling/uniform.h"

#include "common/numeric/random.h"
#include "common/sampling/uniform_path.h"

#include <assert.h>
#include <stdatomic.h>
#include <stddef.h>

void uniform_plain(const struct sampling *sampling, uint32_t variable, uint32_t first,
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

static uniform_path *uniform_widest(void)
{
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        return uniform_avx512;
    }
    if (__builtin_cpu_supports("avx2")) {
        return uniform_avx2;
    }
#endif
    return uniform_plain;
}

void uniform_block(const struct sampling *sampling, uint32_t variable, uint32_t first,
                   double *restrict even, double *restrict odd)
{
    // Threads that come at once find the same.
    static uniform_path *_Atomic chosen;
    uniform_path *path = atomic_load_explicit(&chosen, memory_order_relaxed);
    if (path == NULL) {
        path = uniform_widest();
        atomic_store_explicit(&chosen, path, memory_order_relaxed);
    }
    path(sampling, variable, first, even, odd);
}
