#include "worker/components/polyline.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const double x[] = {0.0, 0.1, 0.2, 0.3, 0.4, 0.5};
static const double peak[] = {0.0, 50.0, 100.0, 50.0, 0.0, 0.0};
static const double nothing[] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
static const struct polyline line = {x, {peak, nothing}, 6};

// The corners are found and nothing else: points on the straight pieces are not needed.
static void corners_are_kept(void **state)
{
    (void)state;
    const struct polyline_rule rule = {{100.0, INFINITY}, 1e-9, 6};
    bool kept[6] = {false};
    assert_int_equal(polyline_thin(&line, &rule, kept), 4);
    assert_true(kept[0] && !kept[1] && kept[2] && !kept[3] && kept[4] && kept[5]);
    assert_true(polyline_miss(&line, &rule, kept) < 1e-12);
    assert_true(polyline_misplaced(&line, 0, kept) < 1e-12);
}

// With three points the polyline falls from the peak to the end, and misses by a third of 100 at
// 0.4; the energy in between is 10 of the triangle's 20, of which 5 lie elsewhere.
static void what_is_missed_is_measured(void **state)
{
    (void)state;
    const struct polyline_rule rule = {{100.0, INFINITY}, 1e-9, 3};
    bool kept[6] = {false};
    assert_int_equal(polyline_thin(&line, &rule, kept), 3);
    assert_true(kept[2]);
    assert_true(fabs(polyline_miss(&line, &rule, kept) - 1.0 / 3.0) < 1e-12);
    assert_true(fabs(polyline_misplaced(&line, 0, kept) - 5.0 / 20.0) < 1e-12);
    assert_true(polyline_misplaced(&line, 1, kept) == 0.0);
}

// A miss within the tolerance is left, in units of each ordinate's scale.
static void tolerance_ends_the_splitting(void **state)
{
    (void)state;
    const struct polyline_rule loose = {{100.0, INFINITY}, 0.4, 6};
    bool kept[6] = {false};
    assert_int_equal(polyline_thin(&line, &loose, kept), 3);
    const struct polyline_rule careless = {{1000.0, INFINITY}, 0.4, 6};
    bool ends[6] = {false};
    assert_int_equal(polyline_thin(&line, &careless, ends), 2);
}

// What the caller marked stays, also beyond the room there is.
static void marked_points_stay(void **state)
{
    (void)state;
    const struct polyline_rule rule = {{100.0, 100.0}, 0.0, 2};
    bool kept[6] = {[1] = true, [3] = true};
    assert_int_equal(polyline_thin(&line, &rule, kept), 4);
    assert_true(kept[0] && kept[1] && !kept[2] && kept[3] && !kept[4] && kept[5]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners_are_kept),
        cmocka_unit_test(what_is_missed_is_measured),
        cmocka_unit_test(tolerance_ends_the_splitting),
        cmocka_unit_test(marked_points_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
