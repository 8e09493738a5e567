#include "common/sampling/moves.h"

#include "common/numeric/random.h"
#include "common/sampling/sampling.h"

#include <assert.h>
#include <glib.h>
#include <string.h>

// Counters of random numbers for leaps, apart from those of samples (random.h).
static const uint32_t moves_counter = UINT32_C(0x80000000);

// By how much leaps differ from their attack: the chance of each variable, or curve, to move, in
// 256ths. Even leaps move variables, odd ones whole curves.
static const uint8_t moves_leap_chance[MOVES_LEAPS] = {16, 64, 32, 96, 64, 128, 128, 192};

static const uint8_t moves_middle = MOVES_LEVEL_MAX / 2;

void moves_fini(struct moves *moves)
{
    g_free(moves->rows);
    *moves = (struct moves){0};
}

size_t moves_size(const struct moves *moves)
{
    return (size_t)moves->attacks * (1 + moves->variables);
}

static bool is_free(const struct box *box, uint32_t variable)
{
    return box->upper[variable] > box->lower[variable];
}

// The curves that have several free variables, in order; returns how many.
static uint32_t movable_curves(const struct curve_map *curves, const struct box *box,
                               uint32_t *movable)
{
    memset(movable, 0, curves->count * sizeof *movable);
    for (uint32_t v = 0; v < box->count; v++)
        movable[curves->curve[v]] += is_free(box, v);
    uint32_t count = 0;
    for (uint32_t curve = 0; curve < curves->count; curve++) {
        if (movable[curve] > 1)
            movable[count++] = curve;
    }
    return count;
}

// What all moves of a step have in common.
struct layout {
    uint32_t free_count;
    uint32_t *free; // (free_count) variables
    uint32_t curve_count;
    uint32_t *curves; // (curve_count) that are moved as a whole
    uint32_t per_attack;
};

static void layout_init(struct layout *layout, const struct curve_map *curves,
                        const struct box *box)
{
    layout->free = g_new(uint32_t, box->count + 1);
    layout->curves = g_new(uint32_t, curves->count + 1);
    layout->free_count = 0;
    for (uint32_t v = 0; v < box->count; v++) {
        if (is_free(box, v))
            layout->free[layout->free_count++] = v;
    }
    layout->curve_count = movable_curves(curves, box, layout->curves);
    layout->per_attack = 1 + 2 * layout->free_count + 3 * layout->curve_count + MOVES_LEAPS;
}

static void layout_fini(struct layout *layout)
{
    g_free(layout->free);
    g_free(layout->curves);
}

uint32_t moves_count(const struct curve_map *curves, const struct box *box)
{
    struct layout layout;
    layout_init(&layout, curves, box);
    const uint32_t count = layout.per_attack;
    layout_fini(&layout);
    return count;
}

uint8_t moves_target(const struct sampling *sampling, uint32_t per_attack, uint32_t index)
{
    const struct moves *moves = sampling->moves;
    return moves->rows[(size_t)(index / per_attack) * (1 + moves->variables)];
}

static uint8_t flipped(uint8_t level)
{
    return level < moves_middle ? MOVES_LEVEL_MAX : 0;
}

static uint8_t probed(uint8_t level)
{
    return level < moves_middle ? level + MOVES_PROBE : level - MOVES_PROBE;
}

// Random bits for place `at` (a variable or a curve) of a leap: whether it moves, and where to.
static void leap_bits(const struct sampling *sampling, uint32_t index, uint32_t at, uint8_t *chance,
                      uint8_t *level)
{
    const uint32_t key[2] = {(uint32_t)sampling->seed, (uint32_t)(sampling->seed >> 32)};
    const uint32_t counter[4] = {moves_counter | at / 4, index, sampling->step, 0};
    uint32_t block[4];
    random_philox(counter, key, block);
    *chance = (uint8_t)block[at % 4];
    *level = block[at % 4] >> 31 ? MOVES_LEVEL_MAX : 0;
}

static void leap(const struct sampling *sampling, const struct layout *layout, uint32_t index,
                 uint32_t number, uint8_t *levels)
{
    for (uint32_t i = 0; i < layout->free_count; i++) {
        const uint32_t v = layout->free[i];
        uint8_t chance, level;
        leap_bits(sampling, index, number % 2 == 0 ? v : sampling->curves->curve[v], &chance,
                  &level);
        if (chance < moves_leap_chance[number])
            levels[v] = level;
    }
}

static void move_curve(const struct sampling *sampling, const struct layout *layout, uint32_t curve,
                       uint8_t level, uint8_t *levels)
{
    for (uint32_t i = 0; i < layout->free_count; i++) {
        if (sampling->curves->curve[layout->free[i]] == curve)
            levels[layout->free[i]] = level;
    }
}

static void move(const struct sampling *sampling, const struct layout *layout, uint32_t index,
                 uint8_t *levels)
{
    const struct moves *moves = sampling->moves;
    const uint32_t attack = index / layout->per_attack;
    uint32_t number = index % layout->per_attack;
    memcpy(levels, moves->rows + (size_t)attack * (1 + moves->variables) + 1, moves->variables);
    if (number-- == 0)
        return;
    if (number < layout->free_count) {
        uint8_t *level = &levels[layout->free[number]];
        *level = flipped(*level);
        return;
    }
    number -= layout->free_count;
    if (number < layout->free_count) {
        uint8_t *level = &levels[layout->free[number]];
        *level = probed(*level);
        return;
    }
    number -= layout->free_count;
    if (number < 3 * layout->curve_count) {
        const uint8_t level[3] = {0, moves_middle, MOVES_LEVEL_MAX};
        move_curve(sampling, layout, layout->curves[number / 3], level[number % 3], levels);
        return;
    }
    leap(sampling, layout, index, number - 3 * layout->curve_count, levels);
}

double moves_value(double lower, double upper, uint8_t level)
{
    if (level == MOVES_LEVEL_MAX)
        return upper;
    const double value = lower + (upper - lower) * level / MOVES_LEVEL_MAX;
    return value > upper ? upper : value;
}

void moves_levels(const struct sampling *sampling, const struct box *box, uint32_t index,
                  uint8_t *levels)
{
    struct layout layout;
    layout_init(&layout, sampling->curves, box);
    move(sampling, &layout, index, levels);
    layout_fini(&layout);
}

void moves_fill(const struct sampling *sampling, const struct box *box, const uint32_t *index,
                uint32_t count, double *values, size_t stride)
{
    assert(sampling->moves != NULL && sampling->moves->variables == box->count);
    struct layout layout;
    layout_init(&layout, sampling->curves, box);
    g_autofree uint8_t *levels = g_new(uint8_t, box->count);
    for (uint32_t i = 0; i < count; i++) {
        move(sampling, &layout, index[i], levels);
        for (uint32_t v = 0; v < box->count; v++)
            values[v * stride + i] = moves_value(box->lower[v], box->upper[v], levels[v]);
    }
    layout_fini(&layout);
}
