#include "worker/kinematics/kinematics.h"
#include "worker/kinematics/kernel_path.h"

#include <assert.h>

static void plain_evaluate(const struct kinematics_problem *problem, uint32_t count,
                           const double *values, double *results, size_t stride)
{
    kernel_plain_evaluate(problem, count, values, results, stride, NULL);
}

#ifdef __x86_64__
// Forces of a design whose coefficients for 16 designs fill half of a first-level cache of 48 KB;
// beyond, 8 designs at a time are faster (README: Cost).
enum { AVX512_PAIR_VALUES = 192 };

static void avx512_evaluate(const struct kinematics_problem *problem, uint32_t count,
                            const double *values, double *results, size_t stride)
{
    if (kinematics_value_count(problem) > AVX512_PAIR_VALUES) {
        kernel_avx512_single_evaluate(problem, count, values, results, stride);
    } else {
        kernel_avx512_evaluate(problem, count, values, results, stride);
    }
}
#endif

// The paths, narrowest first. Other machines than x86-64 have the plain one only: their compilers
// know fused multiply-add from the start, so it is not slow there.
static const struct {
    const char *name;
    void (*evaluate)(const struct kinematics_problem *, uint32_t, const double *, double *, size_t);
    uint32_t (*value_max)(void);
} paths[KINEMATICS_PATH_COUNT] = {
    [KINEMATICS_PATH_PLAIN] = {"plain", plain_evaluate, kernel_plain_value_max},
#ifdef __x86_64__
    [KINEMATICS_PATH_AVX2] = {"avx2", kernel_avx2_evaluate, kernel_avx2_value_max},
    [KINEMATICS_PATH_AVX512] = {"avx512", avx512_evaluate, kernel_avx512_value_max},
#else
    [KINEMATICS_PATH_AVX2] = {"avx2", NULL, NULL},
    [KINEMATICS_PATH_AVX512] = {"avx512", NULL, NULL},
#endif
};

const char *kinematics_path_name(enum kinematics_path path)
{
    return paths[path].name;
}

bool kinematics_path_supported(enum kinematics_path path)
{
#ifdef __x86_64__
    switch (path) {
    case KINEMATICS_PATH_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
    case KINEMATICS_PATH_AVX2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    default:
        break;
    }
#endif
    return path == KINEMATICS_PATH_PLAIN;
}

void kinematics_evaluate_on(enum kinematics_path path, const struct kinematics_problem *problem,
                            uint32_t count, const double *values, double *results, size_t stride)
{
    assert(count <= stride);
    while (kinematics_value_count(problem) > paths[path].value_max()) {
        assert(path > KINEMATICS_PATH_PLAIN);
        path--;
    }
    paths[path].evaluate(problem, count, values, results, stride);
}

void kinematics_evaluate(const struct kinematics_problem *problem, uint32_t count,
                         const double *values, double *results, size_t stride)
{
    enum kinematics_path path = KINEMATICS_PATH_COUNT - 1;
    while (!kinematics_path_supported(path)) {
        path--;
    }
    kinematics_evaluate_on(path, problem, count, values, results, stride);
}

void kinematics_record(const struct kinematics_problem *problem, const double *values,
                       double *results, double *rows)
{
    assert(kinematics_value_count(problem) <= kernel_plain_value_max());
    kernel_plain_evaluate(problem, 1, values, results, 1, rows);
}
