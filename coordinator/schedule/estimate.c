#include "coordinator/schedule/estimate.h"

#include <math.h>

void estimate_add(struct estimate *estimate, double value, double least)
{
    if (!estimate->measured) {
        *estimate = (struct estimate){.mean = value, .deviation = value / 2, .measured = true};
        return;
    }
    value = fmin(value, fmax(2 * estimate_bound(estimate), least));
    estimate->deviation += (fabs(value - estimate->mean) - estimate->deviation) / 4;
    estimate->mean += (value - estimate->mean) / 8;
}

double estimate_bound(const struct estimate *estimate)
{
    return estimate->mean + 4 * estimate->deviation;
}
