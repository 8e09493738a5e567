// The kernel against the plain transcription of the model (naive.c): two ways to the same numbers.
#include "tests/physics/naive.h"
#include "tests/physics/sedan.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

enum { CRASHES = 4000, VALUE_MAX = 1024, RESULT_MAX = KINEMATICS_WORK + 2 * SEDAN_SPRING_MAX };

// Agreement relative to the size that the result has in any crash: a travel of some mm is as exact
// as one of 2 m.
static const double tolerance = 1e-9;

static double result_size(const struct kinematics_setup *setup, uint32_t result)
{
    switch (result) {
    case KINEMATICS_DELTA_VX:
    case KINEMATICS_DELTA_VY:
        return setup->speed;
    case KINEMATICS_ACCELERATION_MAX:
    case KINEMATICS_ACCELERATION_MEAN:
        return 100.0; // m/s2
    default:
        if (result >= KINEMATICS_WORK + setup->spring_count) {
            return 1.0; // m
        }
        return result >= KINEMATICS_KINETIC_ENERGY ? 0.5 * setup->mass * setup->speed * setup->speed
                                                   : 1.0;
    }
}

static double greatest_difference(const struct kinematics_setup *setup, const double *a,
                                  const double *b)
{
    double greatest = 0.0;
    for (uint32_t i = 0; i < KINEMATICS_WORK + 2 * setup->spring_count; i++) {
        // Where the vehicle turned past 90 degrees the projection is at the tangent's mercy.
        const double size = result_size(setup, i) * fmax(1.0, fabs(b[i]));
        greatest = fmax(greatest, fabs(a[i] - b[i]) / size);
    }
    return greatest;
}

static void assert_agreement(enum kinematics_integrator integrator,
                             enum kinematics_reloading reloading)
{
    uint64_t seed = 20 + (uint64_t)integrator;
    double values[VALUE_MAX];
    double results[RESULT_MAX];
    double expected[RESULT_MAX];
    for (int crash = 0; crash < CRASHES; crash++) {
        struct sedan sedan;
        sedan_randomize(&sedan, &seed);
        sedan.setup.integrator = integrator;
        sedan.setup.reloading = reloading;
        struct kinematics_problem *problem = kinematics_create(&sedan.setup);
        sedan_forces(&sedan, kinematics_value_count(problem), &seed, 1, values, 1);
        kinematics_evaluate(problem, 1, values, results, 1);
        naive_evaluate(&sedan.setup, values, expected);
        const double difference = greatest_difference(&sedan.setup, results, expected);
        if (!(difference < tolerance)) {
            print_error("crash %d: ", crash);
            for (uint32_t i = 0; i < kinematics_result_count(problem); i++) {
                print_error("%.17g %.17g\n", results[i], expected[i]);
            }
            fail_msg("difference %g", difference);
        }
        kinematics_free(problem);
    }
}

// Every feature of the model at random, integrator by integrator. A wrong sign, a force too late by
// a step or a curve read past its end would show in one crash of thousands.
static void central_difference_agrees_with_the_equations(void **state)
{
    (void)state;
    assert_agreement(KINEMATICS_CENTRAL_DIFFERENCE, KINEMATICS_RELOADING_THESIS);
    assert_agreement(KINEMATICS_CENTRAL_DIFFERENCE, KINEMATICS_RELOADING_CRUSHED);
}

static void velocity_verlet_agrees_with_the_equations(void **state)
{
    (void)state;
    assert_agreement(KINEMATICS_VELOCITY_VERLET, KINEMATICS_RELOADING_THESIS);
    assert_agreement(KINEMATICS_VELOCITY_VERLET, KINEMATICS_RELOADING_CRUSHED);
}

static void runge_kutta_agrees_with_the_equations(void **state)
{
    (void)state;
    assert_agreement(KINEMATICS_RUNGE_KUTTA_4, KINEMATICS_RELOADING_THESIS);
    assert_agreement(KINEMATICS_RUNGE_KUTTA_4, KINEMATICS_RELOADING_CRUSHED);
}

// Event Verlet looks into its steps, which naive.c does not. Both come to the same crash all the
// same: with a step of 0.1 ms here and Runge-Kutta with 5 us there, which still sees events at
// whole steps only. Some crashes in a hundred hang on whether a spring just meets or just misses.
static void event_verlet_comes_to_the_same_crash(void **state)
{
    (void)state;
    enum { FEW = 200 };
    uint64_t seed = 24;
    double values[VALUE_MAX];
    double results[RESULT_MAX];
    double expected[RESULT_MAX];
    int close = 0;
    for (int crash = 0; crash < FEW; crash++) {
        struct sedan sedan;
        sedan_randomize(&sedan, &seed);
        sedan.setup.integrator = KINEMATICS_EVENT_VERLET;
        sedan.setup.reloading = (enum kinematics_reloading)(crash % 2);
        sedan.setup.time_step = 1e-4;
        struct kinematics_problem *problem = kinematics_create(&sedan.setup);
        sedan_forces(&sedan, kinematics_value_count(problem), &seed, 1, values, 1);
        kinematics_evaluate(problem, 1, values, results, 1);
        sedan.setup.integrator = KINEMATICS_RUNGE_KUTTA_4;
        sedan.setup.time_step = 5e-6;
        naive_evaluate(&sedan.setup, values, expected);
        const double apart =
            fmax(fabs(results[KINEMATICS_TRAVEL_Y] - expected[KINEMATICS_TRAVEL_Y]),
                 fabs(results[KINEMATICS_LENGTH_MIN] - expected[KINEMATICS_LENGTH_MIN]));
        close += apart < 0.5e-3; // [m]
        kinematics_free(problem);
    }
    print_message("%d of %d crashes agree\n", close, (int)FEW);
    assert_true(close >= 0.97 * FEW);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(central_difference_agrees_with_the_equations),
        cmocka_unit_test(velocity_verlet_agrees_with_the_equations),
        cmocka_unit_test(event_verlet_comes_to_the_same_crash),
        cmocka_unit_test(runge_kutta_agrees_with_the_equations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
