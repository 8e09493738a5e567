#include "common/numeric/statistics.h"

#include <assert.h>
#include <math.h>

// A number with a wide exponent: value * 2^exponent. share^samples leaves the range of a double
// long before the sums it belongs to do.
struct scaled {
    double value;
    int64_t exponent;
};

static struct scaled scaled_normal(double value, int64_t exponent)
{
    int shift;
    double mantissa = frexp(value, &shift);
    return (struct scaled){.value = mantissa, .exponent = exponent + shift};
}

// share^samples by repeated squaring. Multiplications only, here and below: they are rounded the
// same on every machine, so the bound may decide what a search does next.
static struct scaled power(double share, uint64_t samples)
{
    struct scaled result = {.value = 1, .exponent = 0};
    struct scaled square = scaled_normal(share, 0);
    for (; samples != 0; samples >>= 1) {
        if (samples & 1)
            result = scaled_normal(result.value * square.value, result.exponent + square.exponent);
        square = scaled_normal(square.value * square.value, 2 * square.exponent);
    }
    return result;
}

// The probability that at most `bad` of `samples` are bad when a share `share` is good.
static double tail(uint64_t samples, uint64_t bad, double share)
{
    struct scaled first = power(share, samples);
    int64_t exponent = first.exponent;
    double term = first.value;
    double sum = term;
    const double odds = (1 - share) / share;
    for (uint64_t k = 0; k < bad; k++) {
        term *= (double)(samples - k) / (double)(k + 1) * odds;
        sum += term;
        if (sum > 0x1p500) {
            sum *= 0x1p-500;
            term *= 0x1p-500;
            exponent += 500;
        }
    }
    // Beyond these the answer is 0 or (rounded) 1 whatever the mantissa.
    if (exponent < -2000)
        return 0;
    return exponent > 2000 ? 1 : ldexp(sum, (int)exponent);
}

double statistics_share_lower(uint64_t samples, uint64_t bad, double confidence)
{
    assert(bad <= samples);
    assert(confidence > 0 && confidence < 1);
    if (bad == samples)
        return 0;
    // The bound is the share at which so few bad ones would be just unlikely enough. The tail grows
    // with the share, so bisection finds it; the lower end is returned, to stay on the safe side.
    const double limit = 1 - confidence;
    double low = 0;
    double high = 1;
    for (;;) {
        double middle = low + (high - low) / 2;
        if (middle <= low || middle >= high)
            return low;
        if (tail(samples, bad, middle) <= limit)
            low = middle;
        else
            high = middle;
    }
}
