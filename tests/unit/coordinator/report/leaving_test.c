// A measured curve against its corridor: where it leaves, on which side, by how much.
#include "coordinator/report/leaving.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// The corridor of all tests: from 1 to 3 over the deformations 0 to 4, a step wider in the middle.
static const double deformation[] = {0, 2, 4}, lower[] = {1, 1, 1}, upper[] = {3, 4, 3};

struct expected {
    double from, to;
    bool above;
    double worst, worst_at;
};

static void assert_leaves(const double *x, const double *y, uint32_t count,
                          const struct expected *expected, uint32_t expected_count)
{
    const struct leaving_curves curves = {.x = x,
                                          .y = y,
                                          .count = count,
                                          .deformation = deformation,
                                          .lower = lower,
                                          .upper = upper,
                                          .point_count = 3};
    struct leaving_piece pieces[8];
    double from, to;
    assert_int_equal(leaving_find(&curves, pieces, 8, &from, &to), expected_count);
    for (uint32_t i = 0; i < expected_count; i++) {
        assert_true(fabs(pieces[i].from - expected[i].from) < 1e-12);
        assert_true(fabs(pieces[i].to - expected[i].to) < 1e-12);
        assert_int_equal(pieces[i].above, expected[i].above);
        assert_true(fabs(pieces[i].worst - expected[i].worst) < 1e-12);
        assert_true(fabs(pieces[i].worst_at - expected[i].worst_at) < 1e-12);
    }
}

// A curve on the bounds themselves is inside: designs on a bound are part of the box.
static void curve_inside_or_on_the_bounds_does_not_leave(void **state)
{
    (void)state;
    assert_leaves((double[]){0, 4}, (double[]){2, 2}, 2, NULL, 0);
    assert_leaves((double[]){0, 2, 4}, (double[]){3, 4, 3}, 3, NULL, 0);
    assert_leaves((double[]){0, 4}, (double[]){1, 1}, 2, NULL, 0);
}

// The places at which the lines cross lie between the points of both.
static void crossings_are_found_between_the_points(void **state)
{
    (void)state;
    // A peak over the upper bound: 2 -> 5 -> 2 over 1..3 meets 3 + x/2 at 1.6 and its mirror
    // at 2.4.
    assert_leaves((double[]){1, 2, 3}, (double[]){2, 5, 2}, 3,
                  (struct expected[]){{1.6, 2.4, true, 1, 2}}, 1);
    // A dip below the lower one.
    assert_leaves((double[]){0, 1, 2}, (double[]){2, 0, 2}, 3,
                  (struct expected[]){{0.5, 1.5, false, 1, 1}}, 1);
}

// What is outside at an end of the curve is told up to that end, and each piece by itself.
static void pieces_are_told_one_by_one_in_order(void **state)
{
    (void)state;
    assert_leaves((double[]){0, 1, 2, 3, 4}, (double[]){0, 2, 6, 2, -1}, 5,
                  (struct expected[]){{0, 0.5, false, 1, 0},
                                      {1 + 1.5 / 3.5, 3 - 1.5 / 3.5, true, 2, 2},
                                      {3 + 1.0 / 3, 4, false, 2, 4}},
                  3);
}

// The corridor itself may leave a curve that is straight: the worst place is then its point.
static void worst_place_may_be_a_point_of_the_corridor(void **state)
{
    (void)state;
    assert_leaves((double[]){0, 4}, (double[]){3.5, 3.5}, 2,
                  (struct expected[]){{0, 1, true, 0.5, 0}, {3, 4, true, 0.5, 4}}, 2);
}

// Only what both have is looked at.
static void deformations_of_one_alone_are_not_looked_at(void **state)
{
    (void)state;
    const struct leaving_curves curves = {.x = (double[]){5, 6},
                                          .y = (double[]){9, 9},
                                          .count = 2,
                                          .deformation = deformation,
                                          .lower = lower,
                                          .upper = upper,
                                          .point_count = 3};
    double from, to;
    assert_int_equal(leaving_find(&curves, NULL, 0, &from, &to), 0);
    assert_true(from > to);
    assert_leaves((double[]){-2, -1, 2}, (double[]){90, 2, 2}, 3, NULL, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curve_inside_or_on_the_bounds_does_not_leave),
        cmocka_unit_test(crossings_are_found_between_the_points),
        cmocka_unit_test(pieces_are_told_one_by_one_in_order),
        cmocka_unit_test(worst_place_may_be_a_point_of_the_corridor),
        cmocka_unit_test(deformations_of_one_alone_are_not_looked_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
