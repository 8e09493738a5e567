// A consistency check, not a validation: curves of one pair of springs are made by differentiating
// the velocities that IIHS measured, and the model, which integrates them again, must give back the
// motion that they came from. The error is what the way through eight points of force over
// deformation costs. The check says nothing of how near the model comes to a car: the yaw, which
// was not measured, goes unseen, and three times the yaw inertia passes as well, which the last
// test shows. prediction_test.c asks what the model knows of cars that gave no curve.
#include "tests/physics/measured.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static const char *const groups[] = {"all", "glancing_off", "rotating"};

enum { GROUPS = sizeof groups / sizeof *groups };

// Twice what was found, of motions of 1.6 m and 0.6 m.
static const double error_x_max = 0.028;
static const double error_y_max = 0.013;

static const double overlap = 0.455; // [m]

// Simulates a group with its own curves. Paths for the picture (consistency.gnuplot) go to the
// folder named by SOBOX_MEASURED_PATHS.
static void simulate(const char *group, struct measured_change change,
                     struct measured_outcome *outcome)
{
    const char *folder = getenv("SOBOX_MEASURED_PATHS");
    char path[4096];
    struct measured measured;
    snprintf(path, sizeof path, "%s/%s.csv", folder != NULL ? folder : "", group);
    measured_read("iihs_small_overlap.csv", group, &measured);
    measured_simulate(&measured, &measured, change, folder != NULL ? path : NULL, outcome);
}

static void curves_give_the_motion_back_that_they_came_from(void **state)
{
    (void)state;
    for (size_t i = 0; i < GROUPS; i++) {
        struct measured_outcome outcome;
        simulate(groups[i], (struct measured_change){1.0, 1.0}, &outcome);
        print_message("%-12s mean absolute error %4.1f mm in x, %4.1f mm in y; AbWAP %.2f, "
                      "s_L_min %.3f m\n",
                      groups[i], 1e3 * outcome.error_x, 1e3 * outcome.error_y,
                      outcome.travel / overlap, outcome.length);
        assert_true(outcome.error_x < error_x_max);
        assert_true(outcome.error_y < error_y_max);
    }
}

// The groups were told apart by their velocities; the model must tell them apart by the outcome
// that defines the response: cars that glance off bring their A-pillar past the barrier.
static void cars_that_glance_off_bring_the_pillar_past_the_barrier(void **state)
{
    (void)state;
    struct measured_outcome glancing_off;
    struct measured_outcome rotating;
    simulate("glancing_off", (struct measured_change){1.0, 1.0}, &glancing_off);
    simulate("rotating", (struct measured_change){1.0, 1.0}, &rotating);
    assert_true(glancing_off.travel > overlap);
    assert_true(rotating.travel < overlap);
}

// What the check sees and what it does not: a tenth more mass breaks it, three times the yaw
// inertia changes the errors by millimetres.
static void check_sees_the_mass_and_not_the_yaw_inertia(void **state)
{
    (void)state;
    struct measured_outcome heavier;
    struct measured_outcome slower_to_turn;
    simulate("all", (struct measured_change){1.1, 1.0}, &heavier);
    simulate("all", (struct measured_change){1.0, 3.0}, &slower_to_turn);
    print_message("all: a tenth more mass %.1f mm in x, %.1f mm in y; three times the yaw inertia "
                  "%.1f mm, %.1f mm\n",
                  1e3 * heavier.error_x, 1e3 * heavier.error_y, 1e3 * slower_to_turn.error_x,
                  1e3 * slower_to_turn.error_y);
    assert_true(heavier.error_x > error_x_max);
    assert_true(slower_to_turn.error_x < error_x_max);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_give_the_motion_back_that_they_came_from),
        cmocka_unit_test(cars_that_glance_off_bring_the_pillar_past_the_barrier),
        cmocka_unit_test(check_sees_the_mass_and_not_the_yaw_inertia),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
