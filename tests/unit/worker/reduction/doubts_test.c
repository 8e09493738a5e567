// A crash whose forces and motion are known in closed form, and every slip that makes one of them
// contradict the other: what is told, and whether it ends the work.
#include "worker/reduction/doubts.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { TIMES = 151 };

static const double mass = 1500.0;        // [kg]
static const double yaw_inertia = 2500.0; // [kg m2]
static const double speed = 15.0;         // [m/s]
static const double force_max = 240e3;    // [N]
static const double begin = 0.010;        // [s] of the forces, which end after `length`
static const double length = 0.125;       // [s]
static const double aside = 0.4;          // of the force in x
static const double turning = -0.5;       // [m] lever of the force in x about the COG

static struct scenario scenario;
static struct balance_sample samples[TIMES];
static double times[TIMES];
static double values[MOTION_QUANTITY_COUNT][TIMES];
static struct motion motion;
static struct balance balance;
static struct doubts doubts;

// A sine-squared pulse, its impulse and the impulse's integral, by hand:
// F = f sin2(pi s / L), J = f (s/2 - L sin(2 pi s / L) / (4 pi)),
// K = f (s2/4 + L2 (cos(2 pi s / L) - 1) / (8 pi2)); s = t - begin, kept within 0 .. L.
static double pulse(double time)
{
    const double s = time - begin;
    return s < 0.0 || s > length ? 0.0 : force_max * pow(sin(G_PI * s / length), 2.0);
}

static double pulse_twice(double time)
{
    const double s = fmin(fmax(time - begin, 0.0), length);
    const double turn = 2.0 * G_PI / length;
    const double within = force_max * (0.25 * s * s + (cos(turn * s) - 1.0) / (2.0 * turn * turn));
    return within + 0.5 * force_max * length * fmax(time - begin - length, 0.0);
}

static int set_up(void **state)
{
    (void)state;
    const double inertia[MOTION_QUANTITY_COUNT] = {mass, mass, yaw_inertia};
    const double share[MOTION_QUANTITY_COUNT] = {1.0, aside, turning};
    scenario = (struct scenario){
        .vehicle = {.mass = mass, .yaw_inertia = yaw_inertia, .speed = speed},
    };
    motion = (struct motion){.count = TIMES, .time = times};
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        motion.value[k] = values[k];
    }
    for (int i = 0; i < TIMES; i++) {
        const double time = 1e-3 * i;
        times[i] = samples[i].time = time;
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            samples[i].force[k] = share[k] * pulse(time);
            values[k][i] = share[k] * pulse_twice(time) / inertia[k];
        }
        values[MOTION_X][i] -= speed * time;
    }
    return 0;
}

static void judge(void)
{
    balance_make(&balance, samples, TIMES, 1.0, &motion, &scenario);
    doubts_find(&doubts, &balance, &scenario);
}

static void scale_forces(double factor)
{
    for (int i = 0; i < TIMES; i++) {
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            samples[i].force[k] *= factor;
        }
    }
}

static void scale_motion(int quantity, double factor)
{
    for (int i = 0; i < TIMES; i++) {
        values[quantity][i] *= factor;
    }
}

static void scale_times(double factor)
{
    for (int i = 0; i < TIMES; i++) {
        times[i] *= factor;
        samples[i].time *= factor;
    }
}

// Only one thing is told, with that text, and it ends the work or does not.
static void assert_told(bool impossible, const char *text)
{
    judge();
    for (uint32_t i = 0; i < doubts.count; i++) {
        print_message("%s\n", doubts.text[i]);
    }
    assert_int_equal(doubts.count, 1);
    assert_non_null(strstr(doubts.text[0], text));
    assert_true(doubts.impossible == impossible);
}

// The impulse between the two tenths' means is the whole impulse but what falls into the tenths; by
// the closed form it is K's mean slope over the last less that over the first.
static void balance_of_a_known_crash_closes(void **state)
{
    (void)state;
    judge();
    const double first = pulse_twice(0.015) / 0.015;
    const double last = (pulse_twice(0.150) - pulse_twice(0.135)) / 0.015;
    assert_true(balance.known);
    assert_float_equal(balance.lines[MOTION_X].impulse, last - first, 1e-3 * last);
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        assert_float_equal(balance.lines[k].ratio, 1.0, 1e-3);
        assert_true(balance.lines[k].error < 1e-4);
    }
    assert_float_equal(balance.speed, speed - first / mass, 1e-6);
    assert_int_equal(doubts.count, 0);
    assert_false(doubts.impossible);
}

static void forces_on_the_barrier_close_too(void **state)
{
    (void)state;
    scale_forces(-1.0);
    balance_make(&balance, samples, TIMES, -1.0, &motion, &scenario);
    doubts_find(&doubts, &balance, &scenario);
    assert_float_equal(balance.lines[MOTION_YAW].ratio, 1.0, 1e-3);
    assert_int_equal(doubts.count, 0);
}

// A motion of whole millimetres, and one of eight times: no false alarm.
static void rounded_and_coarse_motions_close(void **state)
{
    (void)state;
    for (int i = 0; i < TIMES; i++) {
        values[MOTION_X][i] = 1e-3 * round(1e3 * values[MOTION_X][i]);
        values[MOTION_Y][i] = 1e-3 * round(1e3 * values[MOTION_Y][i]);
    }
    judge();
    assert_float_equal(balance.lines[MOTION_X].ratio, 1.0, 0.01);
    assert_int_equal(doubts.count, 0);
    for (uint32_t i = 0; i < 8; i++) {
        times[i] = times[21 * i];
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            values[k][i] = values[k][21 * i];
        }
    }
    motion.count = 8;
    judge();
    assert_float_equal(balance.lines[MOTION_X].ratio, 1.0, 0.01);
    assert_int_equal(doubts.count, 0);
}

static void forces_in_other_units_are_told(void **state)
{
    (void)state;
    static const struct {
        double factor;
        bool impossible;
        const char *slip;
    } rows[] = {
        {1e-3, true, "forces in kN"},      {1e3, true, "vehicle.mass in t"},
        {1.0 / 9.80665, false, "kgf"},     {1.0 / 4.44822, false, "lbf"},
        {0.5, false, "half of the cells"}, {0.85, false, "cells, parts or times"},
        {2.0, false, "counted twice"},     {1.15, false, "more than once"},
        {1e-6, true, "both sides"},        {12.0, true, "more than once"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(rows); i++) {
        set_up(NULL);
        scale_forces(rows[i].factor);
        assert_told(rows[i].impossible, rows[i].slip);
        set_up(NULL);
        scenario.vehicle.mass /= rows[i].factor;
        scenario.vehicle.yaw_inertia /= rows[i].factor;
        assert_told(rows[i].impossible, rows[i].slip);
    }
    set_up(NULL);
    scale_forces(-1.0);
    assert_told(true, "opposite sign");
}

static void closure_within_a_tenth_is_not_told(void **state)
{
    (void)state;
    scale_forces(1.08);
    judge();
    assert_int_equal(doubts.count, 0);
    scale_forces(0.92 / 1.08);
    judge();
    assert_int_equal(doubts.count, 0);
}

// What OpenRadioss writes: the cumulated impulse of each part.
static void impulses_for_forces_are_told(void **state)
{
    (void)state;
    double sum[MOTION_QUANTITY_COUNT] = {0};
    for (int i = 0; i < TIMES; i++) {
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            sum[k] += 1e-3 * samples[i].force[k];
            samples[i].force[k] = sum[k];
        }
    }
    assert_told(true, "impulses in N s in place of forces");
}

static void motions_in_other_units_are_told(void **state)
{
    (void)state;
    scale_motion(MOTION_X, 1e3);
    scale_motion(MOTION_Y, 1e3);
    assert_told(true, "in mm?");
    set_up(NULL);
    scale_motion(MOTION_X, -1.0);
    assert_told(true, "x_m of opposite sign");
    set_up(NULL);
    scale_times(1e3);
    assert_told(true, "in ms?");
    set_up(NULL);
    for (int i = 0; i < TIMES; i++) {
        times[i] *= 1e3; // those of the forces stay
    }
    assert_told(true, "same instant");
    set_up(NULL);
    scale_motion(MOTION_YAW, 180.0 / G_PI);
    assert_told(true, "in degrees?");
}

// A small yaw in degrees stays below a full turn; its momentum tells it.
static void small_yaw_in_degrees_is_told(void **state)
{
    (void)state;
    for (int i = 0; i < TIMES; i++) {
        samples[i].force[MOTION_YAW] *= 0.1;
    }
    scale_motion(MOTION_YAW, 0.1 * 180.0 / G_PI);
    assert_told(false, "yaw_rad in degrees");
}

static void other_speeds_and_places_are_told(void **state)
{
    (void)state;
    scenario.vehicle.speed = 64.4;
    assert_told(false, "vehicle.speed");
    set_up(NULL);
    scenario.vehicle.speed = 1e3 * speed;
    assert_told(true, "begins at");
    set_up(NULL);
    scenario.vehicle.cog[0] = 0.3;
    assert_told(false, "x_m begins with");
    set_up(NULL);
    for (int i = 0; i < TIMES; i++) {
        values[MOTION_YAW][i] += 0.1;
    }
    assert_told(false, "yaw_rad begins with");
}

static void axes_that_differ_are_told(void **state)
{
    (void)state;
    scale_motion(MOTION_Y, -1.0);
    assert_told(false, "y of forces or motion of opposite sign");
    set_up(NULL);
    scale_motion(MOTION_YAW, -1.0);
    assert_told(false, "yaw_rad or the nodes' y_m of opposite sign");
    set_up(NULL);
    for (int i = 0; i < TIMES; i++) {
        samples[i].force[MOTION_Y] = 0.0;
    }
    assert_told(false, "no lateral forces");
    set_up(NULL);
    scenario.vehicle.yaw_inertia *= 2.0;
    assert_told(false, "vehicle.yaw_inertia");
}

static void forces_at_other_times_are_told(void **state)
{
    (void)state;
    // By 12 ms later: the pulse ends within the last tenth, which changes little.
    for (int i = TIMES - 1; i >= 0; i--) {
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            samples[i].force[k] = i >= 12 ? samples[i - 12].force[k] : 0.0;
        }
    }
    assert_told(false, "late");
    set_up(NULL);
    for (int i = 0; i < TIMES; i++) {
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            samples[i].force[k] = i + 12 < TIMES ? samples[i + 12].force[k] : 0.0;
        }
    }
    assert_told(false, "early");
}

static void forces_that_are_cut_off_are_told(void **state)
{
    (void)state;
    balance_make(&balance, samples, 91, 1.0, &motion, &scenario);
    doubts_find(&doubts, &balance, &scenario);
    assert_int_equal(doubts.count, 1);
    assert_non_null(strstr(doubts.text[0], "cut off"));
    assert_false(doubts.impossible);
}

// A car that nothing stopped has no momentum to compare with.
static void motion_without_a_crash_is_told(void **state)
{
    (void)state;
    for (int i = 0; i < TIMES; i++) {
        values[MOTION_X][i] = -speed * times[i];
    }
    assert_told(true, "ends before the crash");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(balance_of_a_known_crash_closes, set_up),
        cmocka_unit_test_setup(forces_on_the_barrier_close_too, set_up),
        cmocka_unit_test_setup(rounded_and_coarse_motions_close, set_up),
        cmocka_unit_test_setup(forces_in_other_units_are_told, set_up),
        cmocka_unit_test_setup(closure_within_a_tenth_is_not_told, set_up),
        cmocka_unit_test_setup(impulses_for_forces_are_told, set_up),
        cmocka_unit_test_setup(motions_in_other_units_are_told, set_up),
        cmocka_unit_test_setup(small_yaw_in_degrees_is_told, set_up),
        cmocka_unit_test_setup(other_speeds_and_places_are_told, set_up),
        cmocka_unit_test_setup(axes_that_differ_are_told, set_up),
        cmocka_unit_test_setup(forces_at_other_times_are_told, set_up),
        cmocka_unit_test_setup(forces_that_are_cut_off_are_told, set_up),
        cmocka_unit_test_setup(motion_without_a_crash_is_told, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
