// The entry of each path's kernel. Inside this folder only: kinematics.c chooses among them.
#ifndef SOBOX_WORKER_KINEMATICS_KERNEL_PATH_H
#define SOBOX_WORKER_KINEMATICS_KERNEL_PATH_H

#include "worker/kinematics/kinematics.h"

// kinematics_evaluate() on one path. `rows` is for the plain path, with one design: NULL, or where
// its trajectory goes.
void kernel_plain_evaluate(const struct kinematics_problem *problem, uint32_t count,
                           const double *values, double *results, size_t stride, double *rows);
void kernel_avx2_evaluate(const struct kinematics_problem *problem, uint32_t count,
                          const double *values, double *results, size_t stride);
void kernel_avx512_evaluate(const struct kinematics_problem *problem, uint32_t count,
                            const double *values, double *results, size_t stride);
void kernel_avx512_single_evaluate(const struct kinematics_problem *problem, uint32_t count,
                                   const double *values, double *results, size_t stride);

// Forces of a design beyond which a path has no room and a narrower one is taken.
uint32_t kernel_plain_value_max(void);
uint32_t kernel_avx2_value_max(void);
uint32_t kernel_avx512_value_max(void);

#endif
