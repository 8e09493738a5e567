// The estimator follows RFC 6298's rules.
#include "coordinator/schedule/estimate.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// The first measurement R sets the mean to R and the deviation to R/2, so the bound is 3 R.
static void first_measurement_bounds_at_three_times(void **state)
{
    (void)state;
    struct estimate estimate = {0};
    assert_float_equal(estimate_bound(&estimate), 0, 0);
    estimate_add(&estimate, 10, 0);
    assert_true(estimate.measured);
    assert_float_equal(estimate_bound(&estimate), 30, 0);
}

// Section 2.3's formulas on one further measurement, by hand: deviation 3/4 5 + 1/4 |10 - 18| =
// 5.75, mean 7/8 10 + 1/8 18 = 11.
static void second_measurement_is_weighted(void **state)
{
    (void)state;
    struct estimate estimate = {0};
    estimate_add(&estimate, 10, 0);
    estimate_add(&estimate, 18, 0);
    assert_float_equal(estimate.mean, 11, 1e-12);
    assert_float_equal(estimate.deviation, 5.75, 1e-12);
}

// Equal measurements let the bound come down to the mean; a changed level is followed.
static void bound_follows_the_level(void **state)
{
    (void)state;
    struct estimate estimate = {0};
    for (int i = 0; i < 100; i++)
        estimate_add(&estimate, 2, 0);
    assert_float_equal(estimate_bound(&estimate), 2, 1e-6);
    for (int i = 0; i < 3; i++)
        estimate_add(&estimate, 20, 0);
    assert_true(estimate_bound(&estimate) > 20);
}

// One measurement far off counts as twice the bound, so that the next ones are soon believed; one
// that was allowed for by the caller counts whole.
static void outlier_counts_as_twice_the_bound(void **state)
{
    (void)state;
    struct estimate estimate = {.mean = 2, .deviation = 1, .measured = true};
    struct estimate allowed = estimate;
    estimate_add(&estimate, 1000, 0);
    assert_float_equal(estimate.mean, 2 + (12 - 2) / 8.0, 1e-12);
    assert_float_equal(estimate.deviation, 1 + (10 - 1) / 4.0, 1e-12);
    estimate_add(&allowed, 1000, 2000);
    assert_float_equal(allowed.mean, 2 + (1000 - 2) / 8.0, 1e-12);
}

// What has become longer for good is followed, twice as far each time.
static void new_level_is_reached_by_doubling(void **state)
{
    (void)state;
    struct estimate estimate = {.mean = 1, .measured = true};
    for (int i = 0; i < 8; i++)
        estimate_add(&estimate, 200, 0);
    assert_true(estimate_bound(&estimate) > 200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_measurement_bounds_at_three_times),
        cmocka_unit_test(second_measurement_is_weighted),
        cmocka_unit_test(bound_follows_the_level),
        cmocka_unit_test(outlier_counts_as_twice_the_bound),
        cmocka_unit_test(new_level_is_reached_by_doubling),
    };
    return cmocka_run_group_tests_name("estimate", tests, NULL, NULL);
}
