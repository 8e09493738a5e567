// Engineering judgement (Heuijerjans 2016, section 7.1): what more force must do to a crash.
#include "tests/physics/sedan.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { LEVELS = 64, RESULTS = KINEMATICS_WORK + 2 * SEDAN_SPRING_MAX };

static double values[4 * LEVELS];
static double results[RESULTS * LEVELS];

// A row of crashes with constant forces, from weak to strong.
static void evaluate(double x_weak, double x_strong, double y_weak, double y_strong,
                     double duration)
{
    struct sedan sedan;
    sedan_init(&sedan, 1, 2);
    sedan.setup.duration = duration;
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    for (int i = 0; i < LEVELS; i++) {
        const double share = (double)i / (LEVELS - 1);
        for (int point = 0; point < 2; point++) {
            values[point * LEVELS + i] = x_weak + share * (x_strong - x_weak);
            values[(2 + point) * LEVELS + i] = y_weak + share * (y_strong - y_weak);
        }
    }
    kinematics_evaluate(problem, LEVELS, values, results, LEVELS);
    kinematics_free(problem);
}

static void assert_grows(enum kinematics_result result)
{
    for (int i = 1; i < LEVELS; i++) {
        assert_true(results[result * LEVELS + i] > results[result * LEVELS + i - 1]);
    }
}

// "If the local x force of the spring is increased [...] the axial movement of the COG should
// decrease. Similarly, the rotational angle should increase in the CCW direction." Travel is
// negative, so less of it is a greater number.
static void more_axial_force_means_less_travel_and_more_yaw(void **state)
{
    (void)state;
    evaluate(20e3, 300e3, 0.0, 0.0, 0.060);
    assert_grows(KINEMATICS_TRAVEL_X);
    assert_grows(KINEMATICS_YAW);
    assert_grows(KINEMATICS_DELTA_VX);
    assert_grows(KINEMATICS_ACCELERATION_MAX);
    evaluate(20e3, 300e3, 60e3, 60e3, 0.060);
    assert_grows(KINEMATICS_TRAVEL_X);
    assert_grows(KINEMATICS_YAW);
}

// "When increasing the local y force [...] the lateral movement of the COG should increase."
static void more_lateral_force_means_more_lateral_travel(void **state)
{
    (void)state;
    evaluate(150e3, 150e3, 0.0, 150e3, 0.060);
    assert_grows(KINEMATICS_TRAVEL_Y);
    assert_grows(KINEMATICS_DELTA_VY);
    evaluate(150e3, 150e3, 0.0, 40e3, 0.150);
    assert_grows(KINEMATICS_TRAVEL_Y);
}

// Enough lateral force and the car leaves the barrier: the A-pillar clears the overlap.
static void lateral_force_decides_between_rotating_and_glancing_off(void **state)
{
    (void)state;
    const double overlap = 0.455;
    evaluate(250e3, 250e3, 0.0, 200e3, 0.150);
    assert_true(results[KINEMATICS_PROJECTION_TRAVEL * LEVELS] < overlap);
    assert_true(results[KINEMATICS_PILLAR_TRAVEL * LEVELS + LEVELS - 1] > overlap);
    assert_true(results[KINEMATICS_YAW * LEVELS] > results[KINEMATICS_YAW * LEVELS + LEVELS - 1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(more_axial_force_means_less_travel_and_more_yaw),
        cmocka_unit_test(more_lateral_force_means_more_lateral_travel),
        cmocka_unit_test(lateral_force_decides_between_rotating_and_glancing_off),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
