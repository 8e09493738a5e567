#include "worker/components/points.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { SAMPLES = 501 };

static double deformation[SAMPLES];
static double force[SCENARIO_DIRECTION_COUNT][SAMPLES];
static struct reference curve;
static struct points_choice choice;

// A curve of 1 m, sampled every 2 mm: 50 kN up to 0.2 m, a rise to 300 kN at 0.4 m, level from
// there; across a tenth of it.
static int set_up(void **state)
{
    (void)state;
    for (int i = 0; i < SAMPLES; i++) {
        const double s = 0.002 * i;
        deformation[i] = s;
        force[0][i] = 50e3 + 250e3 * fmin(fmax((s - 0.2) / 0.2, 0.0), 1.0);
        force[1][i] = 0.1 * force[0][i];
    }
    curve = (struct reference){
        .name = "rail",
        .count = SAMPLES,
        .deformation = deformation,
        .force = {force[0], force[1]},
    };
    return 0;
}

static void choose(const double *ends, uint32_t end_count, double tolerance, uint32_t point_max)
{
    struct error error = {0};
    const struct points_rule rule = {tolerance, point_max};
    if (points_choose(&choice, &curve, ends, end_count, &rule, &error) != STATUS_OK) {
        fail_msg("%s", error.text);
    }
}

static void assert_points(const double *expected, uint32_t count)
{
    assert_int_equal(choice.count, count);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(fabs(choice.deformation[i] - expected[i]) < 1e-12);
    }
}

// Corners need points, straight pieces need none.
static void corners_become_points(void **state)
{
    (void)state;
    choose(NULL, 0, 0.01, 32);
    assert_points((const double[]){0.0, 0.2, 0.4, 1.0}, 4);
    assert_true(choice.miss < 1e-9 && choice.misplaced[0] < 1e-9 && choice.misplaced[1] < 1e-9);
    assert_int_equal(choice.of, SAMPLES);
}

// With three points the one at 0.4 m is kept, which leaves the corner at 0.2 m: 125 of 300 kN, and
// 25 kJ between the curve and the line, of 225 kJ.
static void what_too_few_points_miss_is_told(void **state)
{
    (void)state;
    choose(NULL, 0, 0.01, 3);
    assert_points((const double[]){0.0, 0.4, 1.0}, 3);
    assert_true(fabs(choice.miss - 125.0 / 300.0) < 1e-6);
    assert_true(fabs(choice.misplaced[0] - 25.0 / 225.0) < 1e-6);
}

// Where components begin and end are points, whether the curve needs them, has a sample there, or
// reaches so far.
static void ends_of_components_are_points(void **state)
{
    (void)state;
    choose((const double[]){0.1, 0.4001, 0.70125, 1.2}, 4, 0.01, 32);
    assert_points((const double[]){0.0, 0.1, 0.2, 0.4001, 0.70125, 1.0, 1.2}, 7);
    choose((const double[]){0.0, 0.99995}, 2, 0.5, 32);
    assert_true(choice.deformation[choice.count - 1] == 0.99995);
}

// A narrow peak beside a long plateau misses little force and much energy when it is cut: small
// force everywhere, so that the greatest one says nothing about it.
static void energy_counts_beside_force(void **state)
{
    (void)state;
    for (int i = 0; i < SAMPLES; i++) {
        const double s = deformation[i];
        force[0][i] = s < 0.02 ? 1000e3 * s / 0.02 : fmax(0.0, 1000e3 * (0.04 - s) / 0.02);
        force[0][i] += 40e3 * sin(3.14159265358979 * s);
        force[1][i] = 0.0;
    }
    choose(NULL, 0, 0.05, 32);
    assert_true(choice.miss <= 0.05);
    assert_true(choice.misplaced[0] <= 0.05);
    assert_true(choice.count > 4);
    assert_true(choice.misplaced[1] == 0.0);
}

static void more_ends_than_points_are_refused(void **state)
{
    (void)state;
    struct error error = {0};
    const double ends[] = {0.1, 0.2, 0.3};
    assert_int_equal(
        points_choose(&choice, &curve, ends, 3, &(struct points_rule){0.05, 4}, &error),
        STATUS_INVALID);
    assert_non_null(strstr(error.text, "spring rail: its components begin and end at 3 places"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(corners_become_points, set_up),
        cmocka_unit_test_setup(what_too_few_points_miss_is_told, set_up),
        cmocka_unit_test_setup(ends_of_components_are_points, set_up),
        cmocka_unit_test_setup(energy_counts_beside_force, set_up),
        cmocka_unit_test_setup(more_ends_than_points_are_refused, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
