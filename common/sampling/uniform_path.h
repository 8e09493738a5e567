// The ways to draw a block of random numbers, one for each width of vector registers: uniform.c
// takes the widest that the machine has. Inside this folder only.
#ifndef SOBOX_COMMON_SAMPLING_UNIFORM_PATH_H
#define SOBOX_COMMON_SAMPLING_UNIFORM_PATH_H

#include "common/sampling/uniform.h"

typedef void uniform_path(const struct sampling *sampling, uint32_t variable, uint32_t first,
                          double *restrict even, double *restrict odd);

uniform_path uniform_plain;  // any machine
uniform_path uniform_avx2;   // x86-64 only
uniform_path uniform_avx512; // likewise

#endif
