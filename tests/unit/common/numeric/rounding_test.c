#include "common/numeric/rounding.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void assert_rounded(double step, double lower, double upper, double from, double to)
{
    const double before[2] = {lower, upper};
    assert_true(rounding_inwards(step, &lower, &upper));
    if (lower != from || upper != to || lower < before[0] || upper > before[1])
        fail_msg("%g to %g by %g: expected %.17g to %.17g, found %.17g to %.17g", before[0],
                 before[1], step, from, to, lower, upper);
    // Once more changes nothing.
    assert_true(rounding_inwards(step, &lower, &upper));
    assert_true(lower == from && upper == to);
    assert_true(rounding_is_multiple(lower, step) && rounding_is_multiple(upper, step));
}

static void bounds_move_inwards_only(void **state)
{
    (void)state;
    assert_rounded(10e3, 12.3e3, 48.9e3, 20e3, 40e3);
    assert_rounded(10e3, -48.9e3, -12.3e3, -40e3, -20e3);
    assert_rounded(10e3, -3, 10e3, 0, 10e3);
    assert_rounded(10e3, 20e3, 30e3, 20e3, 30e3);
    double lower = -3, upper = 15e3;
    assert_true(rounding_inwards(10e3, &lower, &upper));
    assert_false(signbit(lower));
}

// Of decimal steps no multiple is exact: a bound that is one stays, to the bit, and none is passed.
static void decimal_multiples_stay(void **state)
{
    (void)state;
    assert_rounded(0.1, 0.3, 0.7, 0.3, 0.7);
    assert_rounded(0.1, 3 * 0.1, 7 * 0.1, 3 * 0.1, 7 * 0.1);
    assert_rounded(1e-4, 1.2e-3, 2.3e-3, 1.2e-3, 2.3e-3);
}

// An interval that would lose its width is left alone.
static void narrow_intervals_are_left(void **state)
{
    (void)state;
    static const double cases[][2] = {{1, 9}, {1, 19}, {10, 19}, {1, 10}, {5, 5}, {10, 10}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double lower = cases[i][0], upper = cases[i][1];
        assert_false(rounding_inwards(10, &lower, &upper));
        assert_true(lower == cases[i][0] && upper == cases[i][1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_move_inwards_only),
        cmocka_unit_test(decimal_multiples_stay),
        cmocka_unit_test(narrow_intervals_are_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
