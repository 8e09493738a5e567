// The kernel in plain C, for any machine and for recording trajectories.
#define LANES_PATH_PLAIN
#define LANES_VECTORS 1

#include "worker/kinematics/kernel.h"
#include "worker/kinematics/kernel_path.h"

void kernel_plain_evaluate(const struct kinematics_problem *problem, uint32_t count,
                           const double *values, double *results, size_t stride, double *rows)
{
    kernel_evaluate(problem, count, values, results, stride, rows);
}

uint32_t kernel_plain_value_max(void)
{
    return KERNEL_VALUES;
}
