#include "coordinator/search/growth.h"

#include "tests/unit/coordinator/search/cloud_of.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// A growth tied to the design space alone would swallow a narrow corridor in a wide space.
static void box_grows_by_its_own_width(void **state)
{
    (void)state;
    const struct growth growth = {.rate = 0.1};
    struct box space = box_cube(1, 0, 100);
    struct box box = box_cube(1, 40, 50);
    growth_apply(&growth, &box, &space, &box);
    assert_true(box.lower[0] == 39 && box.upper[0] == 51);
    box_fini(&space);
    box_fini(&box);
}

// A point has no width; it grows as if it had a fiftieth of the design space, and never beyond it.
static void point_grows_within_the_space(void **state)
{
    (void)state;
    const struct growth growth = {.rate = 0.5};
    struct box space = box_cube(2, 0, 100);
    struct box box = box_cube(2, 50, 50);
    box.lower[1] = box.upper[1] = 99.5;
    growth_apply(&growth, &box, &space, &box);
    assert_true(box.lower[0] == 49 && box.upper[0] == 51);
    assert_true(box.lower[1] == 98.5 && box.upper[1] == 100);
    box_fini(&space);
    box_fini(&box);
}

// Steering against a region in which the good share falls with the rate comes to rest where 70 to
// 80 % are good, from far too much as from far too little.
static void rate_settles_where_three_quarters_are_good(void **state)
{
    (void)state;
    static const double starts[] = {5, 1e-3};
    for (int i = 0; i < 2; i++) {
        struct growth growth = {.rate = starts[i]};
        double share = 0;
        for (int step = 0; step < 60; step++) {
            share = 1 / (1 + 4 * growth.rate);
            growth_steer(&growth, share);
        }
        assert_true(share > 0.6 && share < 0.85);
    }
}

// Only bad samples: the rate falls until it is exhausted, so that a search cannot hang on it.
static void rate_is_exhausted_by_bad_samples(void **state)
{
    (void)state;
    struct growth growth;
    growth_init(&growth);
    assert_true(growth_too_much(0));
    assert_false(growth_too_much(0.5));
    int steps = 0;
    while (!growth_exhausted(&growth) && steps < 100) {
        growth_steer(&growth, 0);
        steps++;
    }
    assert_true(steps > 5 && steps < 30);
    growth_steer(&growth, 1);
    assert_false(growth_exhausted(&growth));
}

// The rate at which a point becomes a box is far too much for the box.
static void box_grows_calmly(void **state)
{
    (void)state;
    struct growth growth;
    growth_init(&growth);
    growth_calm(&growth);
    assert_true(growth.rate < 0.5);
    const double calm = growth.rate;
    growth_steer(&growth, 0);
    const double steered = growth.rate;
    growth_calm(&growth);
    assert_true(steered < calm && growth.rate == steered);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_grows_by_its_own_width),
        cmocka_unit_test(point_grows_within_the_space),
        cmocka_unit_test(rate_settles_where_three_quarters_are_good),
        cmocka_unit_test(box_grows_calmly),
        cmocka_unit_test(rate_is_exhausted_by_bad_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
