// Rounding intervals inwards to multiples of a step, so that a corridor can be written into a
// requirement and still lies inside the one that was found.
//
//     found       |------------------------|
//     multiples   :       :       :       :       :
//     rounded             |---------------|
#ifndef SOBOX_COMMON_NUMERIC_ROUNDING_H
#define SOBOX_COMMON_NUMERIC_ROUNDING_H

#include <stdbool.h>

// Whether a value is a multiple of `step` (> 0), but for what arithmetic and decimals do to it: a
// thousand-millionth of a step.
bool rounding_is_multiple(double value, double step);

// Moves the lower bound up and the upper one down to multiples of `step` (> 0); one that is a
// multiple stays as it is, to the bit. False, and the interval is left alone, when no width would
// be left.
bool rounding_inwards(double step, double *lower, double *upper);

#endif
