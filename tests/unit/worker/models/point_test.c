// Designs of models in closed form.
#include "worker/models/point.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { VARIABLES = 3 };

static double lower[VARIABLES] = {0, -2, 7}, upper[VARIABLES] = {10, 2, 7};
static struct scenario_variable variables[VARIABLES] = {
    {.name = "a", .spring = SCENARIO_NO_SPRING},
    {.name = "b", .spring = SCENARIO_NO_SPRING},
    {.name = "fixed", .spring = SCENARIO_NO_SPRING},
};
static const struct scenario scenario = {
    .model = SCENARIO_MODEL_HYPERSPHERE,
    .variables = variables,
    .design_space = {.count = VARIABLES, .lower = lower, .upper = upper},
};

static void places_are_the_middle_and_the_bounds(void **state)
{
    (void)state;
    double values[VARIABLES];
    point_place(values, &scenario, DESIGN_CENTRE);
    assert_true(values[0] == 5 && values[1] == 0 && values[2] == 7);
    point_place(values, &scenario, DESIGN_LOWER);
    assert_true(values[0] == 0 && values[1] == -2 && values[2] == 7);
    point_place(values, &scenario, DESIGN_UPPER);
    assert_true(values[0] == 10 && values[1] == 2 && values[2] == 7);
}

// Rows stand in any order, and a fixed variable has one value only, given or not.
static void rows_stand_in_any_order(void **state)
{
    (void)state;
    static const char text[] = "variable,value\n# a note\nb, -1e0\na,30\n";
    double values[VARIABLES];
    struct error error = {0};
    assert_int_equal(point_parse(values, &scenario, "d.csv", text, strlen(text), &error),
                     STATUS_OK);
    assert_true(values[0] == 30 && values[1] == -1 && values[2] == 7);
}

static void mistakes_are_pointed_at(void **state)
{
    (void)state;
    static const char *const mistakes[][2] = {
        {"spring,branch\n", "d.csv:1:1: expected the header variable,value"},
        {"variable,value\na,1,2\n", "d.csv:2:5: expected 2 fields (variable,value), found 3"},
        {"variable,value\nc,1\n",
         "d.csv:2:1: variable: expected one of the scenario, as a; found \"c\""},
        {"variable,value\na,1\na,2\n", "d.csv:3:1: variable a: expected one value, found two"},
        {"variable,value\na,nan\n",
         "d.csv:2:3: value: expected a finite number [the variable's unit], found \"nan\""},
        {"variable,value\na,1\n", "d.csv:3:1: variable b: expected a value, found none"},
    };
    for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; i++) {
        double values[VARIABLES];
        struct error error = {0};
        assert_int_equal(
            point_parse(values, &scenario, "d.csv", mistakes[i][0], strlen(mistakes[i][0]), &error),
            STATUS_INVALID);
        assert_string_equal(error.text, mistakes[i][1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_are_the_middle_and_the_bounds),
        cmocka_unit_test(rows_stand_in_any_order),
        cmocka_unit_test(mistakes_are_pointed_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
