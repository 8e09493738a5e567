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

static const double volume_ln2 = 0.693147180559945309417;

// ln(mantissa) for mantissa in [0.5, 1): 2 artanh((m - 1) / (m + 1)), whose argument is at most a
// third, so that twenty terms are exact to the last digits.
static double ln_of(double mantissa)
{
    const double z = (mantissa - 1) / (mantissa + 1);
    double sum = 0;
    for (int k = 39; k >= 1; k -= 2)
        sum = sum * z * z + 1.0 / k;
    return 2 * z * sum;
}

// exp(x) for x in (-ln 2, 0].
static double exp_of(double x)
{
    double sum = 1;
    for (int k = 20; k >= 1; k--)
        sum = 1 + x / k * sum;
    return sum;
}

struct volume volume_weighted(const struct box *box, const struct box *space, const double *weights)
{
    double sum = 0; // logarithm to base two
    for (uint32_t v = 0; v < space->count; v++) {
        const double whole = space->upper[v] - space->lower[v];
        if (!(whole > 0))
            continue;
        int exponent;
        const double mantissa = frexp((box->upper[v] - box->lower[v]) / whole, &exponent);
        if (!(mantissa > 0))
            return (struct volume){.mantissa = 0};
        sum += weights[v] * (exponent + ln_of(mantissa) / volume_ln2);
    }
    const double exponent = ceil(sum);
    int shift;
    const double mantissa = frexp(exp_of((sum - exponent) * volume_ln2), &shift);
    return (struct volume){.mantissa = mantissa, .exponent = (int64_t)exponent + shift};
}

bool volume_above(struct volume a, struct volume b)
{
    if (a.mantissa == 0 || b.mantissa == 0)
        return a.mantissa > b.mantissa;
    if (a.exponent != b.exponent)
        return a.exponent > b.exponent;
    return a.mantissa > b.mantissa;
}
