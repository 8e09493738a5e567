#include "coordinator/search/frame.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { ALL = 4 };

// Variable 1 is fixed by the design space; 3 is held to one value; 2 is held at its lower bound.
static double lower[ALL] = {0, 5, 0, 0};
static double upper[ALL] = {10, 5, 10, 10};
static double hold_lower[ALL] = {NAN, NAN, 2, 7};
static double hold_upper[ALL] = {NAN, NAN, NAN, 7};

static struct scenario held_scenario(void)
{
    return (struct scenario){
        .design_space = {.count = ALL, .lower = lower, .upper = upper},
        .search = {.hold = {.lower = hold_lower, .upper = hold_upper}},
    };
}

// What has no width, by the design space or because it is held, is not searched.
static void fixed_and_held_variables_are_left_out(void **state)
{
    (void)state;
    const struct scenario scenario = held_scenario();
    struct frame frame;
    frame_init(&frame, &scenario);
    assert_int_equal(frame.space.count, 2);
    assert_int_equal(frame.variables[0], 0);
    assert_int_equal(frame.variables[1], 2);
    assert_true(frame.space.lower[1] == 2 && frame.space.upper[1] == 10);
    assert_true(frame.all.lower[3] == 7 && frame.all.upper[3] == 7);
    assert_true(frame.all.lower[2] == 0); // the measure of widths stays the design space
    frame_fini(&frame);
}

static void widened_box_has_every_variable_in_its_place(void **state)
{
    (void)state;
    const struct scenario scenario = held_scenario();
    struct frame frame;
    frame_init(&frame, &scenario);
    double box_lower[2] = {1, 3};
    double box_upper[2] = {2, 4};
    const struct box box = {.count = 2, .lower = box_lower, .upper = box_upper};
    struct box wide;
    box_init(&wide, ALL);
    frame_widen(&frame, &box, &wide);
    const double expected[ALL][2] = {{1, 2}, {5, 5}, {3, 4}, {7, 7}};
    for (int v = 0; v < ALL; v++) {
        assert_true(wide.lower[v] == expected[v][0]);
        assert_true(wide.upper[v] == expected[v][1]);
    }
    box_fini(&wide);
    frame_fini(&frame);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fixed_and_held_variables_are_left_out),
        cmocka_unit_test(widened_box_has_every_variable_in_its_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
