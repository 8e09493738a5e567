// Random numbers on every width of vector registers.
#include "common/sampling/uniform_path.h"

#include "common/numeric/random.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void assert_as_one_by_one(uniform_path *path, const struct sampling *sampling,
                                 uint32_t variable, uint32_t first)
{
    double unit[2][UNIFORM_BLOCK];
    path(sampling, variable, first, unit[0], unit[1]);
    for (uint32_t i = 0; i < UNIFORM_BLOCK; i++) {
        for (uint32_t odd = 0; odd < 2; odd++) {
            const double one =
                random_uniform(sampling->seed, 0, sampling->step, first + i, variable + odd);
            assert_memory_equal(&unit[odd][i], &one, sizeof one);
        }
    }
}

// Worker and coordinator draw the same samples on different machines: a width that carried a bit
// from one word to the next, or counted samples beyond 32 bits, would break every digest.
static void every_width_draws_the_same_numbers(void **state)
{
    (void)state;
    uniform_path *paths[3] = {uniform_plain};
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx2")) {
        paths[1] = uniform_avx2;
    }
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        paths[2] = uniform_avx512;
    }
#endif
    static const uint64_t seeds[] = {0, 1, UINT64_C(0xFEDCBA9876543210), UINT64_MAX};
    static const uint32_t firsts[] = {0, 64, 12345, UINT32_MAX - 40};
    for (size_t path = 0; path < 3; path++) {
        for (size_t i = 0; i < 16 && paths[path] != NULL; i++) {
            const struct sampling sampling = {.seed = seeds[i % 4],
                                              .step = i % 3 == 0 ? UINT32_MAX : 7};
            assert_as_one_by_one(paths[path], &sampling, i % 2 == 0 ? 0 : 4094, firsts[i / 4]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_width_draws_the_same_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
