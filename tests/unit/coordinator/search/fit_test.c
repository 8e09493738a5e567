#include "coordinator/search/fit.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

// The share of the unit square's designs that are bad: a stripe x > 0.8 of which one in ten is.
static bool in_stripe(double x, uint32_t i)
{
    return x > 0.8 && random_uniform(4, 0, 0, i, 9) < 0.1;
}

static bool right_of_line(double x, uint32_t i)
{
    (void)i;
    return x > 0.6;
}

struct square {
    struct box space;
    struct survey survey;
    struct cloud good;
};

static void look_at_square(struct square *square, bool bad_at(double x, uint32_t i))
{
    square->space = box_cube(2, 0, 1);
    survey_init(&square->survey, &square->space);
    cloud_init(&square->good, 2);
    struct cloud bad;
    cloud_init(&bad, 2);
    for (uint32_t i = 0; i < 4000; i++) {
        const double point[2] = {random_uniform(3, 0, 0, i, 0), random_uniform(3, 0, 0, i, 1)};
        cloud_add(bad_at(point[0], i) ? &bad : &square->good, point, 1, 1);
    }
    survey_add(&square->survey, &square->space, 4000, &bad, 100000);
    cloud_fini(&bad);
}

static void leave_square(struct square *square)
{
    survey_fini(&square->survey);
    cloud_fini(&square->good);
    box_fini(&square->space);
}

// One bad design in fifty leaves the square whole; one in five hundred does not.
static void bad_samples_are_left_inside_where_they_may_be(void **state)
{
    (void)state;
    struct square square;
    look_at_square(&square, in_stripe);
    struct box fitted = box_cube(2, 0, 1);
    const struct box start = box_cube(2, 0.2, 0.5);
    struct fit_options options = {.good = &square.good, .bad_share = 0.03, .threads = 1};
    assert_true(fit(&square.survey, &square.space, &start, &options, &fitted));
    // But for the last of them, a hair from the edge.
    assert_true(fitted.upper[0] > 0.99 && fitted.lower[0] == 0);
    assert_true(fitted.lower[1] == 0 && fitted.upper[1] == 1);
    options.bad_share = 0.002;
    assert_true(fit(&square.survey, &square.space, &start, &options, &fitted));
    assert_true(fitted.upper[0] > 0.79 && fitted.upper[0] < 0.84);
    assert_true(fitted.lower[0] == 0 && fitted.lower[1] == 0 && fitted.upper[1] == 1);
    leave_square(&square);
    box_fini(&fitted);
    box_fini((struct box *)&start);
}

// A sharp edge is found to within what the samples show, and a point to keep stays inside.
static void edges_are_found_and_points_kept(void **state)
{
    (void)state;
    struct square square;
    look_at_square(&square, right_of_line);
    struct box fitted = box_cube(2, 0, 1);
    struct box start = box_cube(2, 0.2, 0.5);
    struct fit_options options = {.good = &square.good, .bad_share = 0.001, .threads = 1};
    assert_true(fit(&square.survey, &square.space, &start, &options, &fitted));
    assert_true(fabs(fitted.upper[0] - 0.6) < 0.002);
    const double keep[2] = {0.9, 0.3};
    options.keep = keep;
    start.upper[0] = 0.95;
    // It lies among bad designs: no such box is as good as wanted.
    assert_false(fit(&square.survey, &square.space, &start, &options, &fitted));
    assert_true(box_contains(&fitted, keep));
    leave_square(&square);
    box_fini(&fitted);
    box_fini(&start);
}

// The same bits for any number of threads.
static void threads_change_nothing(void **state)
{
    (void)state;
    struct square square;
    look_at_square(&square, in_stripe);
    struct box start = box_cube(2, 0.2, 0.5);
    struct box fitted[2] = {box_cube(2, 0, 1), box_cube(2, 0, 1)};
    for (int i = 0; i < 2; i++) {
        const struct fit_options options = {
            .good = &square.good, .bad_share = 0.005, .threads = 1 + 3 * i};
        assert_true(fit(&square.survey, &square.space, &start, &options, &fitted[i]));
    }
    assert_true(box_equal(&fitted[0], &fitted[1]));
    leave_square(&square);
    box_fini(&start);
    box_fini(&fitted[0]);
    box_fini(&fitted[1]);
}

// Nothing was looked at, nothing good is known: the start is what there is.
static void without_samples_start_stays(void **state)
{
    (void)state;
    struct box space = box_cube(2, 0, 1);
    struct box start = box_cube(2, 0.2, 0.5);
    struct box fitted = box_cube(2, 0, 0.1);
    struct survey survey;
    struct cloud none;
    survey_init(&survey, &space);
    cloud_init(&none, 2);
    const struct fit_options options = {.good = &none, .bad_share = 0.01, .threads = 1};
    assert_false(fit(&survey, &space, &start, &options, &fitted));
    assert_true(box_equal(&fitted, &start));
    survey_fini(&survey);
    cloud_fini(&none);
    box_fini(&space);
    box_fini(&start);
    box_fini(&fitted);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_samples_are_left_inside_where_they_may_be),
        cmocka_unit_test(edges_are_found_and_points_kept),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(without_samples_start_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
