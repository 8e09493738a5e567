#include "worker/sampling/sampling.h"

#include "common/numeric/random.h"
#include "worker/sampling/sobol.h"
#include "worker/sampling/stratum.h"
#include "worker/sampling/uniform.h"

#include <assert.h>

// Lays numbers of [0, 1) over an interval. The product rounds, so the sum may land above the upper
// bound by a bit; a fixed variable keeps its lower bound exactly.
static void spread(const double *unit, uint32_t count, double lower, double upper, double *values)
{
    const double width = upper - lower;
    for (uint32_t i = 0; i < count; i++) {
        double value = lower + unit[i] * width;
        values[i] = value > upper ? upper : value;
    }
}

// Moves each number into the stratum that its sample has in this variable.
static void stratify(const struct sampling *sampling, uint32_t variable, uint32_t first,
                     uint32_t count, double *unit)
{
    struct stratum stratum;
    stratum_init(&stratum, sampling, variable);
    const double strata = (double)sampling->samples;
    for (uint32_t i = 0; i < count; i++)
        unit[i] = ((double)stratum_of(&stratum, first + i) + unit[i]) / strata;
}

// Samples first .. first + count - 1 (at most UNIFORM_BLOCK) from random numbers.
static void fill_block(const struct sampling *sampling, const struct box *box, uint32_t first,
                       uint32_t count, double *values, size_t stride)
{
    double unit[2][UNIFORM_BLOCK];
    for (uint32_t pair = 0; pair < box->count; pair += 2) {
        uniform_block(sampling, pair, first, unit[0], unit[1]);
        for (uint32_t variable = pair; variable < pair + 2 && variable < box->count; variable++) {
            double *numbers = unit[variable - pair];
            if (sampling->method == SCENARIO_SAMPLING_LATIN_HYPERCUBE)
                stratify(sampling, variable, first, count, numbers);
            spread(numbers, count, box->lower[variable], box->upper[variable],
                   values + variable * stride);
        }
    }
}

// Any number of samples from Sobol points: preparing a variable costs more than a point of it.
static void fill_sobol(const struct sampling *sampling, const struct box *box, uint32_t first,
                       uint32_t count, double *values, size_t stride)
{
    for (uint32_t variable = 0; variable < box->count; variable++) {
        struct sobol sobol;
        sobol_init(&sobol, sampling, variable);
        double *column = values + variable * stride;
        for (uint32_t i = 0; i < count; i++)
            column[i] = sobol_of(&sobol, first + i);
        spread(column, count, box->lower[variable], box->upper[variable], column);
    }
}

void sampling_fill(const struct sampling *sampling, const struct box *box, uint32_t first,
                   uint32_t count, double *values, size_t stride)
{
    assert(stride >= count);
    assert(sampling->method != SCENARIO_SAMPLING_LATIN_HYPERCUBE ||
           (uint64_t)first + count <= sampling->samples);
    if (sampling->method == SCENARIO_SAMPLING_SOBOL) {
        fill_sobol(sampling, box, first, count, values, stride);
        return;
    }
    for (uint32_t done = 0; done < count; done += UNIFORM_BLOCK) {
        uint32_t left = count - done;
        fill_block(sampling, box, first + done, left < UNIFORM_BLOCK ? left : UNIFORM_BLOCK,
                   values + done, stride);
    }
}
