// The kernel in AVX-512 with one vector in a bundle: half the designs at a time need half the
// first-level cache, which matters more than latency once a bundle's coefficients outgrow it.
#define LANES_PATH_AVX512
#define LANES_VECTORS 1

#include "worker/kinematics/kernel.h"
#include "worker/kinematics/kernel_path.h"

void kernel_avx512_single_evaluate(const struct kinematics_problem *problem, uint32_t count,
                                   const double *values, double *results, size_t stride)
{
    kernel_evaluate(problem, count, values, results, stride, NULL);
}
