#include "tests/physics/sedan.h"
#include "worker/kinematics/kinematics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

enum { STRIDE = 64, VALUE_MAX = 2048, RESULT_MAX = KINEMATICS_RESULT_MAX };

// Room for a block of designs.
static double values[VALUE_MAX * STRIDE];
static double results[RESULT_MAX * STRIDE];
static double others[RESULT_MAX * STRIDE];

static uint64_t bits(double number)
{
    uint64_t same;
    memcpy(&same, &number, sizeof same);
    return same;
}

static void assert_same_bits(const double *a, const double *b, uint32_t result_count,
                             uint32_t count, const char *what)
{
    for (uint32_t result = 0; result < result_count; result++) {
        for (uint32_t i = 0; i < count; i++) {
            const double x = a[result * STRIDE + i];
            const double y = b[result * STRIDE + i];
            if (bits(x) != bits(y)) {
                fail_msg("%s: result %u of design %u: %.17g and %.17g", what, result, i, x, y);
            }
        }
    }
}

// A random problem with integrator, profile and reloading taken in turn, and a block of forces.
static struct kinematics_problem *random_problem(uint64_t *seed, uint32_t turn)
{
    struct sedan sedan;
    sedan_randomize(&sedan, seed);
    sedan.setup.integrator = (enum kinematics_integrator)(turn % 4);
    sedan.setup.profile = (enum kinematics_profile)(turn / 4 % 2);
    sedan.setup.reloading = (enum kinematics_reloading)(turn / 8 % 2);
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    sedan_forces(&sedan, kinematics_value_count(problem), seed, STRIDE, values, STRIDE);
    return problem;
}

// A random problem of those that have variants of the kernel to themselves: a flat barrier and load
// branches only. Integrator, first point and work are taken in turn.
static struct kinematics_problem *plain_problem(uint64_t *seed, uint32_t turn)
{
    static const enum kinematics_integrator integrators[] = {
        KINEMATICS_CENTRAL_DIFFERENCE, KINEMATICS_EVENT_VERLET, KINEMATICS_VELOCITY_VERLET};
    struct sedan sedan;
    sedan_randomize(&sedan, seed);
    sedan.setup.integrator = integrators[turn % 3];
    sedan.setup.profile = KINEMATICS_PROFILE_FLAT;
    sedan.setup.omitted.energies = turn / 6 % 2 == 1;
    sedan.setup.omitted.deformations = turn / 12 % 2 == 1;
    for (uint32_t i = 0; i < sedan.setup.spring_count; i++) {
        sedan.springs[i].unload.point_count = 0;
        if (turn / 3 % 2 == 0) {
            sedan.deformation[i][0] = sedan.deformation[i][1] - 0.4;
        }
    }
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    sedan_forces(&sedan, kinematics_value_count(problem), seed, STRIDE, values, STRIDE);
    return problem;
}

// The usual problem, which has its own variant of the kernel: nothing but load branches from 0.
static struct kinematics_problem *usual_problem(uint64_t *seed, uint32_t springs, uint32_t points)
{
    struct sedan sedan;
    sedan_init(&sedan, springs, points);
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    sedan_forces(&sedan, kinematics_value_count(problem), seed, STRIDE, values, STRIDE);
    return problem;
}

static void assert_paths_agree(const struct kinematics_problem *problem)
{
    kinematics_evaluate_on(KINEMATICS_PATH_PLAIN, problem, STRIDE, values, results, STRIDE);
    for (int path = 1; path < KINEMATICS_PATH_COUNT; path++) {
        if (kinematics_path_supported((enum kinematics_path)path)) {
            kinematics_evaluate_on((enum kinematics_path)path, problem, STRIDE, values, others,
                                   STRIDE);
            assert_same_bits(results, others, kinematics_result_count(problem), STRIDE,
                             kinematics_path_name((enum kinematics_path)path));
        }
    }
}

// How many random problems to compare the paths on: few for a test that runs with all others, or as
// many as SOBOX_PATH_DESIGNS asks for (1000000 takes some minutes).
static uint32_t path_problems(void)
{
    const char *designs = getenv("SOBOX_PATH_DESIGNS");
    return designs != NULL ? (uint32_t)strtoul(designs, NULL, 10) / STRIDE : 240;
}

// A minimum that takes the other operand of two equal ones, a fused operation too many, a lane that
// strays: one bit in one of these designs would differ. Results of a search must not depend on the
// machine that computed them.
static void all_paths_give_the_same_bits(void **state)
{
    (void)state;
    uint64_t seed = 1;
    for (uint32_t turn = 0; turn < path_problems(); turn++) {
        struct kinematics_problem *problem =
            turn % 2 == 0 ? random_problem(&seed, turn / 2) : plain_problem(&seed, turn / 2);
        assert_paths_agree(problem);
        kinematics_free(problem);
    }
    for (uint32_t points = 2; points <= SEDAN_POINT_MAX; points++) {
        struct kinematics_problem *problem = usual_problem(&seed, 1 + points % 5, points);
        assert_paths_agree(problem);
        kinematics_free(problem);
    }
}

// Springs and points enough for every path to change its way: 8 x 32 points are 512 forces.
static void paths_agree_on_large_problems(void **state)
{
    (void)state;
    enum { POINTS = 32 };
    uint64_t seed = 10;
    double deformation[POINTS];
    for (uint32_t i = 0; i < POINTS; i++) {
        deformation[i] = 0.04 * i;
    }
    for (uint32_t springs = 1; springs <= SEDAN_SPRING_MAX; springs++) {
        struct sedan sedan;
        sedan_init(&sedan, springs, 2);
        for (uint32_t i = 0; i < springs; i++) {
            sedan.springs[i].load = (struct kinematics_curve){deformation, POINTS};
        }
        struct kinematics_problem *problem = kinematics_create(&sedan.setup);
        sedan_forces(&sedan, kinematics_value_count(problem), &seed, STRIDE, values, STRIDE);
        assert_paths_agree(problem);
        kinematics_free(problem);
    }
}

// Each design alone, and in blocks of every size and position, against the whole block. The short
// cuts of the kernel look at neighbours; they must not change anything.
static void result_does_not_depend_on_lane_or_neighbours(void **state)
{
    (void)state;
    uint64_t seed = 2;
    for (uint32_t turn = 0; turn < 24; turn++) {
        struct kinematics_problem *problem =
            turn % 2 == 0 ? random_problem(&seed, turn / 2) : plain_problem(&seed, turn / 2);
        const uint32_t result_count = kinematics_result_count(problem);
        kinematics_evaluate(problem, STRIDE, values, results, STRIDE);
        for (uint32_t count = 1; count <= STRIDE; count += 1 + count / 3) {
            for (uint32_t first = 0; first + count <= STRIDE; first += count + 5) {
                kinematics_evaluate(problem, count, values + first, others + first, STRIDE);
                assert_same_bits(results + first, others + first, result_count, count, "block");
            }
        }
        kinematics_free(problem);
    }
}

// Columns beyond the designs may be somebody else's or hold signalling garbage.
static void columns_beyond_the_designs_are_left_alone(void **state)
{
    (void)state;
    uint64_t seed = 3;
    struct kinematics_problem *problem = usual_problem(&seed, 2, 3);
    for (uint32_t i = 0; i < RESULT_MAX * STRIDE; i++) {
        results[i] = -7.0;
    }
    const uint32_t count = 11;
    kinematics_evaluate(problem, count, values, results, STRIDE);
    for (uint32_t result = 0; result < kinematics_result_count(problem); result++) {
        assert_true(results[result * STRIDE + count - 1] != -7.0);
        for (uint32_t i = count; i < STRIDE; i++) {
            assert_true(results[result * STRIDE + i] == -7.0);
        }
    }
    kinematics_free(problem);
}

// More forces than a wide path has room for: a narrower one must step in unasked.
static void large_problems_are_evaluated_too(void **state)
{
    (void)state;
    enum { POINTS = 5000 };
    struct sedan sedan;
    sedan_init(&sedan, 1, 2);
    static double deformation[POINTS];
    static double forces[2 * POINTS];
    for (uint32_t i = 0; i < POINTS; i++) {
        deformation[i] = 1.2 * i / (POINTS - 1);
        forces[i] = 200e3;
        forces[POINTS + i] = 100e3;
    }
    const double level[4] = {200e3, 200e3, 100e3, 100e3};
    struct kinematics_problem *small = kinematics_create(&sedan.setup);
    sedan.springs[0].load = (struct kinematics_curve){deformation, POINTS};
    struct kinematics_problem *large = kinematics_create(&sedan.setup);
    kinematics_evaluate(small, 1, level, results, 1);
    kinematics_evaluate(large, 1, forces, others, 1);
    for (uint32_t i = 0; i < kinematics_result_count(small); i++) {
        assert_true(fabs(results[i] - others[i]) <= 1e-9 * fabs(results[i]));
    }
    kinematics_free(large);
    kinematics_free(small);
}

// What the trajectory shows must be what the search judged. A recorded design takes every step, one
// that is judged leaves out those of a car that flies free.
static void recorded_design_has_the_same_results(void **state)
{
    (void)state;
    uint64_t seed = 4;
    for (uint32_t turn = 0; turn < 240; turn++) {
        struct kinematics_problem *problem =
            turn % 2 == 0 ? random_problem(&seed, turn / 2) : plain_problem(&seed, turn / 2);
        const uint32_t row_count = kinematics_row_count(problem);
        const uint32_t column_count = kinematics_column_count(problem);
        double single[VALUE_MAX];
        double recorded[RESULT_MAX * STRIDE];
        for (uint32_t value = 0; value < kinematics_value_count(problem); value++) {
            single[value] = values[value * STRIDE];
        }
        double *rows = malloc(sizeof *rows * row_count * column_count);
        kinematics_record(problem, single, recorded, rows);
        kinematics_evaluate(problem, 1, values, results, STRIDE);
        for (uint32_t result = 0; result < kinematics_result_count(problem); result++) {
            assert_true(bits(recorded[result]) == bits(results[result * STRIDE]));
        }
        const double *last = rows + (size_t)(row_count - 1) * column_count;
        assert_true(last[KINEMATICS_COLUMN_YAW] == recorded[KINEMATICS_YAW]);
        assert_true(fabs(last[KINEMATICS_COLUMN_X] - rows[KINEMATICS_COLUMN_X] -
                         recorded[KINEMATICS_TRAVEL_X]) < 1e-12);
        assert_true(last[KINEMATICS_COLUMN_VY] == recorded[KINEMATICS_DELTA_VY]);
        free(rows);
        kinematics_free(problem);
    }
}

// A design that leaves the finite numbers is bad in every result, so that no constraint can take it
// for good, and leaves its neighbours alone.
static void motion_that_is_not_finite_poisons_every_result(void **state)
{
    (void)state;
    uint64_t seed = 5;
    struct kinematics_problem *problem = usual_problem(&seed, 2, 3);
    const uint32_t result_count = kinematics_result_count(problem);
    kinematics_evaluate(problem, STRIDE, values, results, STRIDE);
    values[1 * STRIDE + 5] = 1e305;
    values[1 * STRIDE + 6] = NAN;
    values[1 * STRIDE + 7] = INFINITY;
    for (int path = 0; path < KINEMATICS_PATH_COUNT; path++) {
        if (!kinematics_path_supported((enum kinematics_path)path)) {
            continue;
        }
        kinematics_evaluate_on((enum kinematics_path)path, problem, STRIDE, values, others, STRIDE);
        for (uint32_t result = 0; result < result_count; result++) {
            for (uint32_t i = 5; i < 8; i++) {
                assert_true(isnan(others[result * STRIDE + i]));
            }
        }
        assert_same_bits(results, others, result_count, 5, "before");
        assert_same_bits(results + 8, others + 8, result_count, STRIDE - 8, "behind");
    }
    kinematics_free(problem);
}

static uint64_t hash(uint64_t before, double number)
{
    return (before ^ bits(number)) * UINT64_C(0x100000001b3); // FNV-1a, a word at a time
}

static uint64_t hash_results(uint64_t before, const struct kinematics_problem *problem)
{
    kinematics_evaluate(problem, STRIDE, values, results, STRIDE);
    for (uint32_t result = 0; result < kinematics_result_count(problem); result++) {
        for (uint32_t i = 0; i < STRIDE; i++) {
            before = hash(before, results[result * STRIDE + i]);
        }
    }
    return before;
}

// The bits of some thousand designs, for every compiler, optimization level and machine. They
// change when the arithmetic of the kernel changes, and then on purpose: a search begun before
// cannot be continued to the same bits after.
static void results_have_the_golden_bits(void **state)
{
    (void)state;
    uint64_t seed = 6;
    uint64_t golden = UINT64_C(0xcbf29ce484222325);
    for (uint32_t turn = 0; turn < 60; turn++) {
        struct kinematics_problem *problem = random_problem(&seed, turn);
        golden = hash_results(golden, problem);
        kinematics_free(problem);
        problem = usual_problem(&seed, 1 + turn % 5, 2 + turn % 8);
        golden = hash_results(golden, problem);
        kinematics_free(problem);
        problem = plain_problem(&seed, turn);
        golden = hash_results(golden, problem);
        kinematics_free(problem);
    }
    if (golden != UINT64_C(0x14a07f2d744a6ee9)) {
        fail_msg("the hash of the results is 0x%016llx", (unsigned long long)golden);
    }
}

// Results that are omitted are 0 and move nothing: no bit of anything else may change, whatever the
// kernel keeps for them on the way.
static void what_is_omitted_changes_nothing_else(void **state)
{
    (void)state;
    uint64_t seed = 11;
    for (uint32_t turn = 0; turn < 32; turn++) {
        struct sedan sedan;
        sedan_randomize(&sedan, &seed);
        sedan.setup.integrator = (enum kinematics_integrator)(turn % 4);
        for (uint32_t i = 0; turn % 8 < 4 && i < sedan.setup.spring_count; i++) {
            sedan.springs[i].unload.point_count = 0;
        }
        struct kinematics_problem *with = kinematics_create(&sedan.setup);
        sedan.setup.omitted = (struct kinematics_omitted){.energies = turn / 8 % 2 == 0,
                                                          .deformations = turn / 16 % 2 == 0};
        struct kinematics_problem *without = kinematics_create(&sedan.setup);
        sedan_forces(&sedan, kinematics_value_count(with), &seed, STRIDE, values, STRIDE);
        kinematics_evaluate(with, STRIDE, values, results, STRIDE);
        kinematics_evaluate(without, STRIDE, values, others, STRIDE);
        assert_same_bits(results, others, KINEMATICS_LATERAL_WORK, STRIDE, "omitted");
        for (uint32_t i = KINEMATICS_LATERAL_WORK; i < kinematics_result_count(with); i++) {
            const bool deformation = i >= kinematics_deformation_row(with, 0);
            const bool omitted = deformation ? sedan.setup.omitted.deformations //
                                             : sedan.setup.omitted.energies;
            assert_true(bits(others[i * STRIDE]) == bits(omitted ? 0.0 : results[i * STRIDE]));
        }
        kinematics_free(without);
        kinematics_free(with);
    }
}

// Two ways to one number: the first spring's least length and its greatest deformation, in every
// integrator, slipped off within a step or not.
static void first_spring_has_its_least_length_at_its_greatest_deformation(void **state)
{
    (void)state;
    uint64_t seed = 12;
    for (uint32_t turn = 0; turn < 48; turn++) {
        struct sedan sedan;
        sedan_randomize(&sedan, &seed);
        sedan.setup.integrator = (enum kinematics_integrator)(turn % 4);
        struct kinematics_problem *problem = kinematics_create(&sedan.setup);
        const uint32_t row = kinematics_deformation_row(problem, 0);
        sedan_forces(&sedan, kinematics_value_count(problem), &seed, STRIDE, values, STRIDE);
        kinematics_evaluate(problem, STRIDE, values, results, STRIDE);
        for (uint32_t i = 0; i < STRIDE; i++) {
            const double least = results[KINEMATICS_LENGTH_MIN * STRIDE + i];
            assert_true(results[row * STRIDE + i] >= 0.0);
            assert_true(bits(least) == bits(sedan.springs[0].length - results[row * STRIDE + i]));
            assert_true(least <= results[KINEMATICS_LENGTH_LAST * STRIDE + i]);
        }
        kinematics_free(problem);
    }
}

// A zero force over the whole curve must be exactly none: the coefficients may not leave a rest.
static void design_without_forces_flies_straight(void **state)
{
    (void)state;
    uint64_t seed = 7;
    struct kinematics_problem *problem = usual_problem(&seed, 5, 9);
    memset(values, 0, sizeof values);
    kinematics_evaluate(problem, STRIDE, values, results, STRIDE);
    assert_true(results[KINEMATICS_YAW * STRIDE] == 0.0);
    assert_true(results[KINEMATICS_TRAVEL_Y * STRIDE] == 0.0);
    assert_true(fabs(results[KINEMATICS_DELTA_VX * STRIDE]) < 1e-14);
    assert_true(fabs(results[KINEMATICS_TRAVEL_X * STRIDE] + 17.889 * 0.150) < 1e-12);
    assert_true(results[KINEMATICS_WORK * STRIDE] == 0.0);
    kinematics_free(problem);
}

// A barrier that the vehicle misses: lengths stay as they were and nothing is averaged over
// nothing.
static void vehicle_that_misses_keeps_its_length(void **state)
{
    (void)state;
    struct sedan sedan;
    sedan_init(&sedan, 1, 3);
    sedan.setup.edge_y = -0.9;
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    const double level[6] = {1e5, 1e5, 1e5, 1e5, 1e5, 1e5};
    kinematics_evaluate(problem, 1, level, results, 1);
    assert_true(results[KINEMATICS_LENGTH_LAST] == 1.25);
    assert_true(results[KINEMATICS_LENGTH_MIN] == 1.25);
    assert_true(results[KINEMATICS_ACCELERATION_MEAN] == 0.0);
    assert_true(results[KINEMATICS_WORK] == 0.0);
    kinematics_free(problem);
}

// A force so weak that the A-pillar passes the face: the length is signed, so the design is bad,
// not folded back into a good one.
static void length_is_negative_behind_the_face(void **state)
{
    (void)state;
    struct sedan sedan;
    sedan_init(&sedan, 1, 3);
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    const double level[6] = {1e4, 1e4, 1e4, 0.0, 0.0, 0.0};
    kinematics_evaluate(problem, 1, level, results, 1);
    assert_true(results[KINEMATICS_LENGTH_LAST] < 0.0);
    assert_true(results[KINEMATICS_LENGTH_MIN] <= results[KINEMATICS_LENGTH_LAST]);
    kinematics_free(problem);
}

// A rounded edge of no radius is the flat face, but for the few roundings of another formula.
static void rounded_edge_of_no_radius_is_flat(void **state)
{
    (void)state;
    uint64_t seed = 8;
    struct sedan sedan;
    sedan_init(&sedan, 3, 4);
    sedan.setup.edge_radius = 0.0;
    struct kinematics_problem *flat = kinematics_create(&sedan.setup);
    sedan.setup.profile = KINEMATICS_PROFILE_ROUNDED;
    struct kinematics_problem *rounded = kinematics_create(&sedan.setup);
    sedan_forces(&sedan, kinematics_value_count(flat), &seed, STRIDE, values, STRIDE);
    kinematics_evaluate(flat, STRIDE, values, results, STRIDE);
    kinematics_evaluate(rounded, STRIDE, values, others, STRIDE);
    assert_same_bits(results, others, kinematics_result_count(flat), STRIDE, "flat");
    kinematics_free(rounded);
    kinematics_free(flat);
}

// Both schemes are the same when nothing acts at time 0.
static void verlet_is_central_difference_when_nothing_acts_at_first(void **state)
{
    (void)state;
    uint64_t seed = 9;
    struct sedan sedan;
    sedan_init(&sedan, 3, 4);
    struct kinematics_problem *central = kinematics_create(&sedan.setup);
    sedan.setup.integrator = KINEMATICS_VELOCITY_VERLET;
    struct kinematics_problem *verlet = kinematics_create(&sedan.setup);
    sedan_forces(&sedan, kinematics_value_count(central), &seed, STRIDE, values, STRIDE);
    kinematics_evaluate(central, STRIDE, values, results, STRIDE);
    kinematics_evaluate(verlet, STRIDE, values, others, STRIDE);
    assert_same_bits(results, others, kinematics_result_count(central), STRIDE, "verlet");
    kinematics_free(verlet);
    kinematics_free(central);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_paths_give_the_same_bits),
        cmocka_unit_test(paths_agree_on_large_problems),
        cmocka_unit_test(result_does_not_depend_on_lane_or_neighbours),
        cmocka_unit_test(columns_beyond_the_designs_are_left_alone),
        cmocka_unit_test(large_problems_are_evaluated_too),
        cmocka_unit_test(recorded_design_has_the_same_results),
        cmocka_unit_test(motion_that_is_not_finite_poisons_every_result),
        cmocka_unit_test(results_have_the_golden_bits),
        cmocka_unit_test(what_is_omitted_changes_nothing_else),
        cmocka_unit_test(first_spring_has_its_least_length_at_its_greatest_deformation),
        cmocka_unit_test(design_without_forces_flies_straight),
        cmocka_unit_test(vehicle_that_misses_keeps_its_length),
        cmocka_unit_test(length_is_negative_behind_the_face),
        cmocka_unit_test(rounded_edge_of_no_radius_is_flat),
        cmocka_unit_test(verlet_is_central_difference_when_nothing_acts_at_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
