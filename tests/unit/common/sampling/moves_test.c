#include "common/sampling/moves.h"

#include "common/sampling/sampling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

// Variables 0 .. 2 are one curve, 3 and 4 another one, of which 4 is fixed, and 5 is the third one.
enum {
    VARIABLES = 6,
    FREE = 5,
    MOVABLE = 1, // curves with more than one free variable
    ATTACKS = 2,
    PER_ATTACK = 1 + 2 * FREE + 3 * MOVABLE + MOVES_LEAPS,
    SAMPLES = ATTACKS * PER_ATTACK,
    FIXED = 4,
    FIXED_LEVEL = 9, // of the attacks, in the fixed variable
};

static double lower[VARIABLES] = {0, -1e5, 3, 1e-3, 7, -7};
static double upper[VARIABLES] = {1, 450e3, 4, 2e-3, 7, -6.5};
static const struct box box = {.count = VARIABLES, .lower = lower, .upper = upper};

static uint32_t curve[VARIABLES] = {0, 0, 0, 1, 1, 2};
static const struct curve_map curves = {
    .variables = VARIABLES, .count = 3, .curve = curve, .group_count = 3, .group = curve};

static uint8_t rows[ATTACKS * (1 + VARIABLES)] = {
    4, 0, MOVES_LEVEL_MAX, 127, 30, FIXED_LEVEL, 0, 9, 10, 200, 0, 254, FIXED_LEVEL, 126,
};
static const struct moves moves = {.variables = VARIABLES, .attacks = ATTACKS, .rows = rows};
static const uint32_t free_variables[FREE] = {0, 1, 2, 3, 5};

static struct sampling sampling_of(uint64_t seed, uint32_t step)
{
    return (struct sampling){.seed = seed,
                             .step = step,
                             .samples = SAMPLES,
                             .method = SAMPLING_METHOD_MOVES,
                             .curves = &curves,
                             .moves = &moves};
}

static const uint8_t *levels_of(uint32_t attack)
{
    return rows + (size_t)attack * (1 + VARIABLES) + 1;
}

// What sample `move` of an attack is made of, with its levels.
static void levels_at(uint32_t attack, uint32_t move, uint8_t levels[VARIABLES])
{
    const struct sampling sampling = sampling_of(42, 17);
    moves_levels(&sampling, &box, attack * PER_ATTACK + move, levels);
}

// Asserts that a move changes one variable of its attack and no other.
static void assert_moves_one(uint32_t attack, uint32_t move, uint32_t variable, uint8_t level)
{
    uint8_t levels[VARIABLES], expected[VARIABLES];
    memcpy(expected, levels_of(attack), VARIABLES);
    expected[variable] = level;
    levels_at(attack, move, levels);
    assert_memory_equal(levels, expected, VARIABLES);
}

// The number of samples an attack takes is part of the protocol: workers work it out alone.
static void attack_takes_a_sample_a_move(void **state)
{
    (void)state;
    assert_int_equal(moves_count(&curves, &box), PER_ATTACK);
    assert_int_equal(moves_size(&moves), sizeof rows);
}

static void first_move_is_the_attack_itself(void **state)
{
    (void)state;
    for (uint32_t attack = 0; attack < ATTACKS; attack++) {
        uint8_t levels[VARIABLES];
        levels_at(attack, 0, levels);
        assert_memory_equal(levels, levels_of(attack), VARIABLES);
    }
}

// A flip takes one variable to the bound that it is farther from; in the middle that is the lower.
static void flip_takes_one_variable_to_its_other_bound(void **state)
{
    (void)state;
    static const uint8_t flipped[ATTACKS][FREE] = {
        {MOVES_LEVEL_MAX, 0, 0, MOVES_LEVEL_MAX, MOVES_LEVEL_MAX},
        {MOVES_LEVEL_MAX, 0, MOVES_LEVEL_MAX, 0, MOVES_LEVEL_MAX}};
    for (uint32_t attack = 0; attack < ATTACKS; attack++) {
        for (uint32_t f = 0; f < FREE; f++)
            assert_moves_one(attack, 1 + f, free_variables[f], flipped[attack][f]);
    }
}

// A probe goes inwards by MOVES_PROBE levels, so that it never leaves the interval.
static void probe_takes_one_variable_inwards(void **state)
{
    (void)state;
    for (uint32_t attack = 0; attack < ATTACKS; attack++) {
        for (uint32_t f = 0; f < FREE; f++) {
            const uint8_t level = levels_of(attack)[free_variables[f]];
            const uint8_t probed = level < 127 ? level + MOVES_PROBE : level - MOVES_PROBE;
            assert_moves_one(attack, 1 + FREE + f, free_variables[f], probed);
        }
    }
}

// Only the first curve has several free variables; the others are moved by flips.
static void curve_moves_take_all_of_a_curve_to_one_level(void **state)
{
    (void)state;
    static const uint8_t level[3] = {0, 127, MOVES_LEVEL_MAX};
    for (uint32_t i = 0; i < 3; i++) {
        uint8_t levels[VARIABLES], expected[VARIABLES];
        memcpy(expected, levels_of(1), VARIABLES);
        memset(expected, level[i], 3);
        levels_at(1, 1 + 2 * FREE + i, levels);
        assert_memory_equal(levels, expected, VARIABLES);
    }
}

// The fixed variable keeps its level in each sample of the step, and its value.
static void fixed_variable_is_never_moved(void **state)
{
    (void)state;
    const struct sampling sampling = sampling_of(42, 17);
    double values[VARIABLES * SAMPLES];
    sampling_fill(&sampling, &box, 0, SAMPLES, values, SAMPLES);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        uint8_t levels[VARIABLES];
        moves_levels(&sampling, &box, i, levels);
        assert_int_equal(levels[FIXED], FIXED_LEVEL);
        assert_true(values[FIXED * SAMPLES + i] == lower[FIXED]);
    }
}

// Leaps put what they move on bounds, odd ones whole curves; and they do move something.
static void leaps_go_to_bounds(void **state)
{
    (void)state;
    uint32_t moved = 0;
    for (uint32_t leap = 0; leap < MOVES_LEAPS; leap++) {
        uint8_t levels[VARIABLES];
        levels_at(1, 1 + 2 * FREE + 3 * MOVABLE + leap, levels);
        uint32_t moved_of_curve = 0;
        for (uint32_t v = 0; v < VARIABLES; v++) {
            const bool same = levels[v] == levels_of(1)[v];
            assert_true(same || levels[v] == 0 || levels[v] == MOVES_LEVEL_MAX);
            moved += !same;
            moved_of_curve += v < 3 && levels[v] != levels_of(1)[v];
        }
        if (leap % 2 == 1 && moved_of_curve > 0)
            assert_true(levels[0] == levels[1] && levels[1] == levels[2]);
    }
    assert_in_range(moved, 4, MOVES_LEAPS * FREE - 4);
}

// Leaps are drawn by counter: another step or seed leaps elsewhere, the same one to the same place.
static void leaps_follow_seed_and_step(void **state)
{
    (void)state;
    static const struct {
        uint64_t seed;
        uint32_t step;
    } others[] = {{43, 17}, {42, 18}, {42 + (UINT64_C(1) << 32), 17}};
    const struct sampling sampling = sampling_of(42, 17);
    for (size_t other = 0; other < sizeof others / sizeof *others; other++) {
        const struct sampling changed = sampling_of(others[other].seed, others[other].step);
        uint32_t differ = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            uint8_t one[VARIABLES], again[VARIABLES], two[VARIABLES];
            moves_levels(&sampling, &box, i, one);
            moves_levels(&sampling, &box, i, again);
            moves_levels(&changed, &box, i, two);
            assert_memory_equal(one, again, VARIABLES);
            const bool leap = i % PER_ATTACK >= PER_ATTACK - MOVES_LEAPS;
            assert_true(leap || memcmp(one, two, VARIABLES) == 0);
            differ += memcmp(one, two, VARIABLES) != 0;
        }
        assert_true(differ > MOVES_LEAPS / 2);
    }
}

// The bounds are met exactly, and rounding takes no level out of the interval.
static void levels_span_the_interval(void **state)
{
    (void)state;
    static const double ends[][2] = {{0, 1}, {0.1, 0.3}, {-1e5, 450e3}, {1e-3, 1.0000001e-3}};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        const double low = ends[i][0], high = ends[i][1];
        assert_true(moves_value(low, high, 0) == low);
        assert_true(moves_value(low, high, MOVES_LEVEL_MAX) == high);
        for (int level = 1; level <= MOVES_LEVEL_MAX; level++) {
            const double value = moves_value(low, high, (uint8_t)level);
            assert_true(value > moves_value(low, high, (uint8_t)(level - 1)) && value <= high);
        }
    }
    assert_true(moves_value(0, 1, MOVES_LEVEL_MAX / 2) == 0.5);
}

// Workers take any part of a step: each must make the samples that the others would.
static void any_cut_of_a_step_gives_the_same_designs(void **state)
{
    (void)state;
    const struct sampling sampling = sampling_of(42, 17);
    double whole[VARIABLES * SAMPLES];
    sampling_fill(&sampling, &box, 0, SAMPLES, whole, SAMPLES);
    for (uint32_t size = 1; size <= SAMPLES; size = 2 * size + 1) {
        for (uint32_t first = 0; first < SAMPLES; first += size) {
            const uint32_t count = first + size < SAMPLES ? size : SAMPLES - first;
            double part[VARIABLES * SAMPLES];
            sampling_fill(&sampling, &box, first, count, part, count);
            for (uint32_t v = 0; v < VARIABLES; v++)
                assert_memory_equal(part + (size_t)v * count, whole + v * SAMPLES + first,
                                    count * sizeof *part);
        }
    }
}

// The coordinator makes single samples again, such as the worst one; they are what levels say.
static void picked_samples_are_those_of_the_step(void **state)
{
    (void)state;
    const struct sampling sampling = sampling_of(7, 3);
    double whole[VARIABLES * SAMPLES], picked[VARIABLES * SAMPLES];
    uint32_t index[SAMPLES], count = 0;
    for (uint32_t i = 0; i < SAMPLES; i += 1 + i % 3)
        index[count++] = i;
    sampling_fill(&sampling, &box, 0, SAMPLES, whole, SAMPLES);
    sampling_pick(&sampling, &box, index, count, picked, SAMPLES);
    for (uint32_t i = 0; i < count; i++) {
        uint8_t levels[VARIABLES];
        moves_levels(&sampling, &box, index[i], levels);
        for (uint32_t v = 0; v < VARIABLES; v++) {
            assert_true(picked[v * SAMPLES + i] == whole[v * SAMPLES + index[i]]);
            assert_true(picked[v * SAMPLES + i] == moves_value(lower[v], upper[v], levels[v]));
        }
    }
}

// All samples of an attack want the margin of its constraint.
static void samples_of_an_attack_share_its_target(void **state)
{
    (void)state;
    const struct sampling sampling = sampling_of(42, 17);
    for (uint32_t i = 0; i < SAMPLES; i++)
        assert_int_equal(moves_target(&sampling, PER_ATTACK, i), i < PER_ATTACK ? 4 : 9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attack_takes_a_sample_a_move),
        cmocka_unit_test(first_move_is_the_attack_itself),
        cmocka_unit_test(flip_takes_one_variable_to_its_other_bound),
        cmocka_unit_test(probe_takes_one_variable_inwards),
        cmocka_unit_test(curve_moves_take_all_of_a_curve_to_one_level),
        cmocka_unit_test(fixed_variable_is_never_moved),
        cmocka_unit_test(leaps_go_to_bounds),
        cmocka_unit_test(leaps_follow_seed_and_step),
        cmocka_unit_test(levels_span_the_interval),
        cmocka_unit_test(any_cut_of_a_step_gives_the_same_designs),
        cmocka_unit_test(picked_samples_are_those_of_the_step),
        cmocka_unit_test(samples_of_an_attack_share_its_target),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
