#include "common/sampling/sampling.h"

#include "common/numeric/random.h"
#include "common/sampling/sobol.h"
#include "common/sampling/stratum.h"
#include "common/sampling/uniform.h"

#include <assert.h>

// With fewer samples than this wanted of a block, one by one is faster.
enum { SAMPLING_DENSE = 8 };

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
static void stratify(const struct sampling *sampling, uint32_t variable, const uint32_t *index,
                     uint32_t count, double *unit)
{
    struct stratum stratum;
    stratum_init(&stratum, sampling, variable);
    const double strata = (double)sampling->samples;
    for (uint32_t i = 0; i < count; i++)
        unit[i] = ((double)stratum_of(&stratum, index[i]) + unit[i]) / strata;
}

// The random numbers of samples index[0] .. index[count - 1], all less than UNIFORM_BLOCK behind
// the first: of a whole block at once, or of few one by one.
static void draw(const struct sampling *sampling, uint32_t pair, const uint32_t *index,
                 uint32_t count, double unit[2][UNIFORM_BLOCK])
{
    if (count < SAMPLING_DENSE) {
        const uint32_t key[2] = {(uint32_t)sampling->seed, (uint32_t)(sampling->seed >> 32)};
        for (uint32_t i = 0; i < count; i++) {
            const uint32_t counter[4] = {pair / 2, index[i], sampling->step, 0};
            uint32_t block[4];
            random_philox(counter, key, block);
            unit[0][i] = random_unit(block[0], block[1]);
            unit[1][i] = random_unit(block[2], block[3]);
        }
        return;
    }
    uniform_block(sampling, pair, index[0], unit[0], unit[1]);
    // Ascending, so that no number is overwritten before it is moved.
    for (uint32_t i = 0; i < count; i++) {
        unit[0][i] = unit[0][index[i] - index[0]];
        unit[1][i] = unit[1][index[i] - index[0]];
    }
}

// Samples of one block from random numbers: see draw().
static void pick_block(const struct sampling *sampling, const struct box *box,
                       const uint32_t *index, uint32_t count, double *values, size_t stride)
{
    double unit[2][UNIFORM_BLOCK];
    for (uint32_t pair = 0; pair < box->count; pair += 2) {
        draw(sampling, pair, index, count, unit);
        for (uint32_t variable = pair; variable < pair + 2 && variable < box->count; variable++) {
            double *numbers = unit[variable - pair];
            if (sampling->method == SAMPLING_METHOD_LATIN_HYPERCUBE)
                stratify(sampling, variable, index, count, numbers);
            spread(numbers, count, box->lower[variable], box->upper[variable],
                   values + variable * stride);
        }
    }
}

// Turns a random number into the level of a curve at an extreme: the lower bound, the upper bound,
// or one level, a third each.
static void to_extremes(uint32_t count, double *unit)
{
    for (uint32_t i = 0; i < count; i++) {
        const double three = 3 * unit[i];
        unit[i] = three < 1 ? 0 : three < 2 ? 1 : three - 2;
    }
}

// Samples of one block whose curves stand at one level each: the random numbers belong to curves,
// or to groups of them, as they belong to variables elsewhere.
static void pick_curves(const struct sampling *sampling, const struct box *box,
                        const uint32_t *index, uint32_t count, double *values, size_t stride)
{
    const struct curve_map *curves = sampling->curves;
    assert(curves != NULL && curves->variables == box->count);
    const bool levels = sampling->method == SAMPLING_METHOD_LEVELS;
    const uint32_t slot_count = levels ? curves->group_count : curves->count;
    const uint32_t *slot = levels ? curves->group : curves->curve;
    double unit[2][UNIFORM_BLOCK];
    for (uint32_t pair = 0; pair < slot_count; pair += 2) {
        draw(sampling, pair, index, count, unit);
        if (sampling->method == SAMPLING_METHOD_EXTREMES) {
            to_extremes(count, unit[0]);
            to_extremes(count, unit[1]);
        }
        for (uint32_t variable = 0; variable < box->count; variable++) {
            if (slot[variable] / 2 == pair / 2)
                spread(unit[slot[variable] % 2], count, box->lower[variable], box->upper[variable],
                       values + variable * stride);
        }
    }
}

static void pick(const struct sampling *sampling, const struct box *box, const uint32_t *index,
                 uint32_t count, double *values, size_t stride)
{
    if (sampling->method == SAMPLING_METHOD_MOVES)
        moves_fill(sampling, box, index, count, values, stride);
    else if (sampling_of_curves(sampling->method))
        pick_curves(sampling, box, index, count, values, stride);
    else
        pick_block(sampling, box, index, count, values, stride);
}

// Any number of samples from Sobol points: preparing a variable costs more than a point of it.
static void pick_sobol(const struct sampling *sampling, const struct box *box,
                       const uint32_t *index, uint32_t first, uint32_t count, double *values,
                       size_t stride)
{
    for (uint32_t variable = 0; variable < box->count; variable++) {
        struct sobol sobol;
        sobol_init(&sobol, sampling, variable);
        double *column = values + variable * stride;
        for (uint32_t i = 0; i < count; i++)
            column[i] = sobol_of(&sobol, index != NULL ? index[i] : first + i);
        spread(column, count, box->lower[variable], box->upper[variable], column);
    }
}

void sampling_pick(const struct sampling *sampling, const struct box *box, const uint32_t *index,
                   uint32_t count, double *values, size_t stride)
{
    assert(stride >= count);
    if (sampling->method == SAMPLING_METHOD_SOBOL) {
        pick_sobol(sampling, box, index, 0, count, values, stride);
        return;
    }
    uint32_t near;
    for (uint32_t done = 0; done < count; done += near) {
        for (near = 1; done + near < count && index[done + near] - index[done] < UNIFORM_BLOCK;)
            near++;
        pick(sampling, box, index + done, near, values + done, stride);
    }
}

void sampling_fill(const struct sampling *sampling, const struct box *box, uint32_t first,
                   uint32_t count, double *values, size_t stride)
{
    assert(stride >= count);
    assert(sampling->method != SAMPLING_METHOD_LATIN_HYPERCUBE ||
           (uint64_t)first + count <= sampling->samples);
    if (sampling->method == SAMPLING_METHOD_SOBOL) {
        pick_sobol(sampling, box, NULL, first, count, values, stride);
        return;
    }
    for (uint32_t done = 0; done < count; done += UNIFORM_BLOCK) {
        const uint32_t left = count - done;
        const uint32_t block = left < UNIFORM_BLOCK ? left : UNIFORM_BLOCK;
        uint32_t index[UNIFORM_BLOCK];
        for (uint32_t i = 0; i < block; i++)
            index[i] = first + done + i;
        pick(sampling, box, index, block, values + done, stride);
    }
}
