// Cars that come to rest at the barrier. Loading is told from the sign of a rate, and of a car that
// stands still rounding decides on it: a scheme that believes it fires the whole force at the car
// every other step, pushes it back, raises its mean deceleration, and of two springs that stand
// together moves the car along the barrier. Held against reference.h, where time is continuous.
#include "tests/physics/reference.h"
#include "tests/physics/sedan.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

enum { CRASHES = 60, SPRINGS = 5, POINTS = 9, VALUES = 2 * SPRINGS * POINTS };

// A car that meets a wide barrier head on with springs at both sides of its COG.
static void wide_crash(struct sedan *sedan, uint32_t spring_count, double time_step,
                       enum kinematics_reloading reloading)
{
    static const double sides[SPRINGS] = {0.3, -0.3, 0.0, 0.15, -0.2};
    sedan_init(sedan, spring_count, POINTS);
    sedan->setup.cog[1] = -1.2;
    sedan->setup.width = 4.0;
    sedan->setup.integrator = KINEMATICS_EVENT_VERLET;
    sedan->setup.reloading = reloading;
    sedan->setup.time_step = time_step;
    for (uint32_t i = 0; i < spring_count; i++) {
        sedan->springs[i].position[0] = -0.83;
        sedan->springs[i].position[1] = spring_count == 1 ? 0.0 : sides[i];
        sedan->springs[i].length = 1.25;
    }
}

// Forces that stop the car, the lateral ones `lateral` times as large.
static void random_forces(uint32_t spring_count, double lateral, uint64_t *seed, double *values)
{
    for (uint32_t i = 0; i < spring_count; i++) {
        for (int direction = 0; direction < 2; direction++) {
            for (uint32_t point = 0; point < POINTS; point++) {
                const double most = (direction == 0 ? 900e3 : lateral * 900e3) / spring_count;
                *values++ = sedan_between(seed, 0.4, 1.0) * most;
            }
        }
    }
}

static struct reference_outcome expect(const struct sedan *sedan, const double *values)
{
    const struct kinematics_setup *setup = &sedan->setup;
    struct reference_crash crash = {
        .mass = setup->mass,
        .yaw_inertia = setup->yaw_inertia,
        .speed = setup->speed,
        .cog = {setup->cog[0], setup->cog[1]},
        .face_x = setup->face_x,
        .edge_y = setup->edge_y,
        .width = setup->width,
        .crushed = setup->reloading == KINEMATICS_RELOADING_CRUSHED,
        .duration = setup->duration,
        .step = 2e-5,
        .spring_count = setup->spring_count,
    };
    for (uint32_t i = 0; i < setup->spring_count; i++) {
        struct reference_spring *spring = &crash.springs[i];
        memcpy(spring->place, sedan->springs[i].position, sizeof spring->place);
        memcpy(spring->deformation, sedan->deformation[i], POINTS * sizeof(double));
        spring->length = sedan->springs[i].length;
        spring->point_count = POINTS;
        for (int direction = 0; direction < 2; direction++) {
            memcpy(spring->force[direction], values, POINTS * sizeof(double));
            values += POINTS;
        }
    }
    return reference_evaluate(&crash);
}

struct errors {
    double length, travel, yaw, mean; // [m], [m], [rad], relative; the greatest
};

static struct errors greatest_errors(uint32_t spring_count, double lateral, double time_step,
                                     enum kinematics_reloading reloading)
{
    struct errors errors = {0};
    uint64_t seed = 31;
    for (int crash = 0; crash < CRASHES; crash++) {
        struct sedan sedan;
        double values[VALUES];
        double results[KINEMATICS_RESULT_MAX];
        wide_crash(&sedan, spring_count, time_step, reloading);
        random_forces(spring_count, lateral, &seed, values);
        struct kinematics_problem *problem = kinematics_create(&sedan.setup);
        kinematics_evaluate(problem, 1, values, results, 1);
        const struct reference_outcome wanted = expect(&sedan, values);
        const double mean = (wanted.velocity[0] + sedan.setup.speed) / wanted.contact_time;
        errors.length =
            fmax(errors.length, fabs(results[KINEMATICS_LENGTH_LAST] - wanted.length_last));
        errors.travel = fmax(
            errors.travel, fabs(results[KINEMATICS_PROJECTION_TRAVEL] - wanted.projection_travel));
        errors.yaw = fmax(errors.yaw, fabs(results[KINEMATICS_YAW] - wanted.yaw));
        errors.mean = fmax(errors.mean, fabs(results[KINEMATICS_ACCELERATION_MEAN] - mean) / mean);
        kinematics_free(problem);
    }
    print_message("%u springs, lateral %g, %s, %g s: s_L %.3f mm, travel %.3f mm, yaw %.5f, mean "
                  "deceleration %.2f %%\n",
                  spring_count, lateral, reloading ? "crushed" : "thesis", time_step,
                  1e3 * errors.length, 1e3 * errors.travel, errors.yaw, 1e2 * errors.mean);
    return errors;
}

static const enum kinematics_reloading rules[] = {KINEMATICS_RELOADING_THESIS,
                                                  KINEMATICS_RELOADING_CRUSHED};

// One spring in line with the COG stops the car dead.
static void head_on_stop_is_a_stop(void **state)
{
    (void)state;
    for (int rule = 0; rule < 2; rule++) {
        const struct errors coarse = greatest_errors(1, 0.0, 1e-3, rules[rule]);
        const struct errors fine = greatest_errors(1, 0.0, 2.5e-4, rules[rule]);
        assert_true(coarse.length < 1e-3 && coarse.mean < 0.02);
        assert_true(fine.length < 0.1e-3 && fine.mean < 0.005);
        assert_true(coarse.travel == 0.0 && coarse.yaw == 0.0);
    }
}

// Springs come to rest one after the other while those that still load turn the car about them;
// their lateral forces push it along the barrier as long as they act.
static void springs_that_stand_together_do_not_push(void **state)
{
    (void)state;
    for (int turn = 0; turn < 4; turn++) {
        const uint32_t springs = turn < 2 ? 2 : SPRINGS;
        const struct errors coarse = greatest_errors(springs, 0.3, 1e-3, rules[turn % 2]);
        const struct errors fine = greatest_errors(springs, 0.3, 2.5e-4, rules[turn % 2]);
        assert_true(coarse.length < 1e-3 && coarse.travel < 2e-3 && coarse.yaw < 1e-3);
        assert_true(fine.length < 0.2e-3 && fine.travel < 0.2e-3 && fine.yaw < 2e-4);
    }
}

// From the step at which a car has stopped to the end nothing acts and nothing moves.
static void steps_of_a_standing_car_do_nothing(void **state)
{
    (void)state;
    uint64_t seed = 32;
    for (int crash = 0; crash < 2 * CRASHES; crash++) {
        struct sedan sedan;
        double values[VALUES];
        double results[KINEMATICS_RESULT_MAX];
        wide_crash(&sedan, 1, 1e-3, rules[crash % 2]);
        random_forces(1, 0.0, &seed, values);
        struct kinematics_problem *problem = kinematics_create(&sedan.setup);
        const uint32_t rows = kinematics_row_count(problem);
        const uint32_t columns = kinematics_column_count(problem);
        double *trajectory = malloc(sizeof *trajectory * rows * columns);
        kinematics_record(problem, values, results, trajectory);
        uint32_t stopped = 0;
        for (uint32_t row = 0; row < rows; row++) {
            const double *now = trajectory + (size_t)row * columns;
            if (stopped == 0 && fabs(now[KINEMATICS_COLUMN_VX]) < 1e-6) {
                stopped = row;
            } else if (stopped > 0) {
                const double *then = trajectory + (size_t)stopped * columns;
                const double force = now[KINEMATICS_COLUMN_SPRING + KINEMATICS_SPRING_FORCE_X];
                assert_true(force == 0.0);
                assert_true(fabs(now[KINEMATICS_COLUMN_X] - then[KINEMATICS_COLUMN_X]) < 1e-9);
            }
        }
        assert_true(stopped > 0 && stopped < rows / 2 + 20);
        free(trajectory);
        kinematics_free(problem);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(head_on_stop_is_a_stop),
        cmocka_unit_test(springs_that_stand_together_do_not_push),
        cmocka_unit_test(steps_of_a_standing_car_do_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
