// The crash model as one would write it down from the thesis: one design, one equation after the
// other, with the C library's trigonometry and no thought of speed. The kernel must agree with it
// to rounding. It has the kernel's integrators (but for event Verlet) and the kernel's rules, so it
// finds slips of the pen and no wrong idea: that is for reference.h.
#ifndef SOBOX_TESTS_PHYSICS_NAIVE_H
#define SOBOX_TESTS_PHYSICS_NAIVE_H

#include "worker/kinematics/kinematics.h"

// Results of one design as kinematics_evaluate() gives them; values and results have a stride of 1.
void naive_evaluate(const struct kinematics_setup *setup, const double *values, double *results);

#endif
