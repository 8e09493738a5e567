#include "worker/models/motion.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static enum status parse(struct motion *motion, const char *text, struct error *error)
{
    return motion_parse(motion, 0.15, "m.csv", text, strlen(text), error);
}

// Columns in another order, and columns of somebody else's.
static void columns_are_found_by_name(void **state)
{
    (void)state;
    struct motion motion;
    struct error error;
    assert_int_equal(parse(&motion, "y_m,note_m,time_s\n1,9,0\n2,9,0.15\n", &error), STATUS_OK);
    assert_int_equal(motion.count, 2);
    assert_true(motion.time[1] == 0.15);
    assert_true(motion.value[MOTION_Y][1] == 2.0);
    assert_null(motion.value[MOTION_X]);
    assert_null(motion.value[MOTION_YAW]);
    motion_fini(&motion);
}

static void what_is_wrong_is_named_with_its_place(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *place;
        const char *says;
    } cases[] = {
        {"", "m.csv:1:1: ", "header"},
        {"time_s\n0\n1\n", "m.csv:1:1: ", "x_m, y_m, yaw_rad"},
        {"x_m\n0\n1\n", "m.csv:1:1: ", "time_s"},
        {"time_s,x_m\n0\n", "m.csv:2:2: ", "found 1"},
        {"time_s,x_m\n0,1,2\n", "m.csv:2:5: ", "found 3"},
        {"time_s,x_m\n0,1\n", "m.csv:3:1: ", "at least 2 times"},
        {"time_s,x_m\n0,1\n0,1\n", "m.csv:3:1: ", "more than 0 s"},
        {"time_s,x_m\n0.1,1\n0.05,1\n", "m.csv:3:1: ", "more than 0.1 s"},
        {"time_s,x_m\n-0.1,1\n0.05,1\n", "m.csv:2:1: ", "0 to 0.15 s"},
        {"time_s,x_m\n0,1\n0.2,1\n", "m.csv:3:1: ", "0 to 0.15 s"},
        {"time_s,x_m\n0,one\n", "m.csv:2:3: ", "finite"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct motion motion;
        struct error error = {0};
        assert_int_equal(parse(&motion, cases[i].text, &error), STATUS_INVALID);
        assert_null(motion.time);
        if (strncmp(error.text, cases[i].place, strlen(cases[i].place)) != 0 ||
            strstr(error.text, cases[i].says) == NULL) {
            fail_msg("expected %s... %s, found %s", cases[i].place, cases[i].says, error.text);
        }
    }
}

// A straight line sampled at other times is met exactly; a shifted one misses by the shift.
static void error_is_the_mean_distance_at_the_reference_times(void **state)
{
    (void)state;
    struct motion motion;
    struct error error;
    assert_int_equal(
        parse(&motion, "time_s,x_m,y_m\n0,0,0.5\n0.033,0.33,0.83\n0.15,1.5,0.5\n", &error),
        STATUS_OK);
    double rows[4][2] = {{0.0, 0.0}, {0.05, 0.5}, {0.10, 1.0}, {0.15, 1.5}};
    const double x = motion_error(&motion, MOTION_X, &rows[0][0], &rows[0][1], 4, 2);
    const double y = motion_error(&motion, MOTION_Y, &rows[0][0], &rows[0][1], 4, 2);
    assert_true(fabs(x) < 1e-15);
    assert_true(fabs(y - (0.5 + 0.5 + 1.0) / 3.0) < 1e-15);
    motion_fini(&motion);
}

// The last reference time may lie past the last step by a rounding error: the end value holds.
static void times_at_the_very_end_are_met(void **state)
{
    (void)state;
    struct motion motion;
    struct error error;
    assert_int_equal(parse(&motion, "time_s,x_m\n0,0\n0.15000000000000002,1\n", &error), STATUS_OK);
    const double time[2] = {0.0, 0.15};
    const double value[2] = {0.0, 1.0};
    assert_true(motion_error(&motion, MOTION_X, time, value, 2, 1) < 1e-15);
    motion_fini(&motion);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(columns_are_found_by_name),
        cmocka_unit_test(what_is_wrong_is_named_with_its_place),
        cmocka_unit_test(error_is_the_mean_distance_at_the_reference_times),
        cmocka_unit_test(times_at_the_very_end_are_met),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
