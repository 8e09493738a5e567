// The kernel in AVX2 with FMA.
#define LANES_PATH_AVX2
#define LANES_VECTORS 2

#include "worker/kinematics/kernel.h"
#include "worker/kinematics/kernel_path.h"

void kernel_avx2_evaluate(const struct kinematics_problem *problem, uint32_t count,
                          const double *values, double *results, size_t stride)
{
    kernel_evaluate(problem, count, values, results, stride, NULL);
}

uint32_t kernel_avx2_value_max(void)
{
    return KERNEL_VALUES;
}
