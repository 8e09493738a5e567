#include "common/numeric/rounding.h"

#include <math.h>

static const double rounding_slack = 1e-9; // in steps

bool rounding_is_multiple(double value, double step)
{
    const double steps = value / step;
    return fabs(steps - floor(steps + 0.5)) <= rounding_slack;
}

bool rounding_inwards(double step, double *lower, double *upper)
{
    // Zero is added lest it be a negative one.
    const double from =
        rounding_is_multiple(*lower, step) ? *lower : ceil(*lower / step) * step + 0;
    const double to = rounding_is_multiple(*upper, step) ? *upper : floor(*upper / step) * step + 0;
    if (!(from < to) || !(to - from > step / 2))
        return false;
    *lower = from;
    *upper = to;
    return true;
}
