#include "coordinator/search/volume.h"

#include <math.h>

struct volume volume_of(const struct box *box, const struct box *space)
{
    struct volume volume = {.mantissa = 0.5, .exponent = 1};
    for (uint32_t v = 0; v < space->count; v++) {
        double whole = space->upper[v] - space->lower[v];
        if (!(whole > 0))
            continue;
        int shift;
        volume.mantissa =
            frexp(volume.mantissa * ((box->upper[v] - box->lower[v]) / whole), &shift);
        volume.exponent += shift;
        if (!(volume.mantissa > 0))
            return (struct volume){.mantissa = 0};
    }
    return volume;
}

bool volume_above(struct volume a, struct volume b)
{
    if (a.mantissa == 0 || b.mantissa == 0)
        return a.mantissa > b.mantissa;
    if (a.exponent != b.exponent)
        return a.exponent > b.exponent;
    return a.mantissa > b.mantissa;
}
