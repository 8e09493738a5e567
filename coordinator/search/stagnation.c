#include "coordinator/search/stagnation.h"

#include <glib.h>
#include <math.h>

void stagnation_init(struct stagnation *stagnation, uint32_t window)
{
    *stagnation = (struct stagnation){.window = window,
                                      .volumes = g_new0(struct volume, 2 * (size_t)window + 1)};
}

void stagnation_fini(struct stagnation *stagnation)
{
    g_free(stagnation->volumes);
    *stagnation = (struct stagnation){0};
}

void stagnation_reset(struct stagnation *stagnation)
{
    stagnation->steps = 0;
}

// The product of the volumes of `count` steps from `first` on.
static struct volume product(const struct stagnation *stagnation, uint32_t first, uint32_t count)
{
    struct volume product = {.mantissa = 0.5, .exponent = 1};
    for (uint32_t i = first; i < first + count; i++) {
        const struct volume *volume = &stagnation->volumes[i % (2 * stagnation->window)];
        int shift;
        product.mantissa = frexp(product.mantissa * volume->mantissa, &shift);
        product.exponent += volume->exponent + shift;
    }
    return product;
}

bool stagnation_note(struct stagnation *stagnation, struct volume volume)
{
    const uint32_t window = stagnation->window;
    if (window == 0)
        return false;
    stagnation->volumes[stagnation->steps++ % (2 * window)] = volume;
    if (stagnation->steps < 2 * window)
        return false;
    const uint32_t first = stagnation->steps - 2 * window;
    return !volume_above(product(stagnation, first + window, window),
                         product(stagnation, first, window));
}
