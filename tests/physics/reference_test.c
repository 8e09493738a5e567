// Every integrator, barrier and rule of reloading against the reference of reference.h, on random
// designs of the shipped design spaces. The kernel converges to the thesis's crash or it does not;
// a twin that shares its rules could not tell.
#include "common/scenario/scenario_read.h"
#include "tests/physics/reference_scenario.h"
#include "tests/physics/sedan.h"
#include "worker/batch/batch.h"
#include "worker/models/small_overlap.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { DESIGNS = 100, VALUE_MAX = 512, RESULT_MAX = KINEMATICS_RESULT_MAX };

static const double reference_step = 2e-5; // [s] at which its own error is some micrometres

static const char *const scenarios[] = {
    "sedan-two-springs", "sedan-ten-springs",      "suv-two-springs",
    "suv-ten-springs",   "sports-car-two-springs", "sports-car-ten-springs",
};
enum { SCENARIOS = sizeof scenarios / sizeof *scenarios };

// Random designs of one scenario, and what they do.
static double values[VALUE_MAX * DESIGNS];
static double results[RESULT_MAX * DESIGNS];
static struct reference_outcome expected[DESIGNS];

static struct scenario read_scenario(const char *name, const char *const *overrides, size_t count)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/deploy/scenarios/%s.yaml", SOBOX_SOURCE_DIR, name);
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_file(&scenario, path, overrides, count, &error) != STATUS_OK) {
        fail_msg("%s", error.text);
    }
    return scenario;
}

static void draw_designs(const struct scenario *scenario, uint64_t seed)
{
    double *value = values;
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const struct scenario_spring *spring = &scenario->springs[i];
        for (int direction = 0; direction < 2; direction++) {
            for (uint32_t point = 0; point < spring->point_count; point++) {
                for (uint32_t design = 0; design < DESIGNS; design++) {
                    *value++ = sedan_between(&seed, spring->force_lower[direction][point],
                                             spring->force_upper[direction][point]);
                }
            }
        }
    }
}

static int compare_numbers(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double other = *(const double *)b;
    return (one > other) - (one < other);
}

// The 99th percentile and the worst of the differences of one result.
static void differences(enum kinematics_result result, size_t offset, double share[2])
{
    double difference[DESIGNS];
    for (uint32_t i = 0; i < DESIGNS; i++) {
        double wanted;
        memcpy(&wanted, (const char *)&expected[i] + offset, sizeof wanted);
        difference[i] = fabs(results[(size_t)result * DESIGNS + i] - wanted);
    }
    qsort(difference, DESIGNS, sizeof *difference, compare_numbers);
    share[0] = difference[(size_t)(0.99 * (DESIGNS - 1))];
    share[1] = difference[DESIGNS - 1];
}

// Verdicts of the scenario's response that are other ones with the reference's motion.
static uint32_t verdicts_changed(const struct scenario *scenario)
{
    static double outcomes[RESULT_MAX * DESIGNS];
    uint32_t changed = 0;
    bool good[2][DESIGNS];
    for (int side = 0; side < 2; side++) {
        memcpy(outcomes, results, sizeof outcomes);
        for (uint32_t i = 0; side == 1 && i < DESIGNS; i++) {
            outcomes[KINEMATICS_LENGTH_LAST * DESIGNS + i] = expected[i].length_last;
            outcomes[KINEMATICS_LENGTH_MIN * DESIGNS + i] = expected[i].length_min;
            outcomes[KINEMATICS_PILLAR_TRAVEL * DESIGNS + i] = expected[i].pillar_travel;
            outcomes[KINEMATICS_PROJECTION_TRAVEL * DESIGNS + i] = expected[i].projection_travel;
            outcomes[KINEMATICS_YAW * DESIGNS + i] = expected[i].yaw;
            outcomes[KINEMATICS_YAW_MAX * DESIGNS + i] = expected[i].yaw_max;
        }
        small_overlap_outcomes(scenario->barrier.overlap, DESIGNS, outcomes, DESIGNS);
        for (uint32_t i = 0; i < DESIGNS; i++) {
            good[side][i] =
                batch_verdict(scenario, outcomes + i, DESIGNS).violation == VERDICT_GOOD;
        }
    }
    for (uint32_t i = 0; i < DESIGNS; i++) {
        changed += good[0][i] != good[1][i];
    }
    return changed;
}

// What an integrator may be off by at a step.
struct claim {
    const char *integrator;
    const char *time_step; // [s]
    double length[2];      // [m] s_L and s_L_min: for 99 % of the designs, for the worst
    double travel;         // [m] of the A-pillar, for 99 %
    double yaw;            // [rad] for 99 %
    uint32_t verdicts;     // of all scenarios' designs that may change
};

static uint32_t assert_claim(const char *name, const char *profile, const char *reloading,
                             const struct claim *claim)
{
    char overrides[4][64];
    snprintf(overrides[0], sizeof overrides[0], "barrier.profile=%s", profile);
    snprintf(overrides[1], sizeof overrides[1], "simulation.reloading=%s", reloading);
    snprintf(overrides[2], sizeof overrides[2], "simulation.integrator=%s", claim->integrator);
    snprintf(overrides[3], sizeof overrides[3], "simulation.time_step=%s", claim->time_step);
    const char *const list[] = {overrides[0], overrides[1], overrides[2], overrides[3]};
    struct scenario scenario = read_scenario(name, list, 4);
    struct kinematics_problem *problem =
        small_overlap_problem(&scenario, NULL, (struct kinematics_omitted){.energies = true});
    memset(results, 0, sizeof results);
    kinematics_evaluate(problem, DESIGNS, values, results, DESIGNS);
    double length[2], least[2], travel[2], yaw[2];
    differences(KINEMATICS_LENGTH_LAST, offsetof(struct reference_outcome, length_last), length);
    differences(KINEMATICS_LENGTH_MIN, offsetof(struct reference_outcome, length_min), least);
    differences(KINEMATICS_PILLAR_TRAVEL, offsetof(struct reference_outcome, pillar_travel),
                travel);
    differences(KINEMATICS_YAW, offsetof(struct reference_outcome, yaw), yaw);
    const uint32_t changed = verdicts_changed(&scenario);
    print_message("%s, %s, %s, %s at %s s: s_L %.3f (worst %.3f) mm, least %.3f (%.3f) mm, "
                  "A-pillar %.3f mm, yaw %.5f, verdicts %u\n",
                  name, profile, reloading, claim->integrator, claim->time_step, 1e3 * length[0],
                  1e3 * length[1], 1e3 * least[0], 1e3 * least[1], 1e3 * travel[0], yaw[0],
                  changed);
    for (int i = 0; i < 2; i++) {
        assert_true(length[i] < claim->length[i]);
        assert_true(least[i] < claim->length[i]);
    }
    assert_true(travel[0] < claim->travel);
    assert_true(yaw[0] < claim->yaw);
    kinematics_free(problem);
    scenario_fini(&scenario);
    return changed;
}

// Holds all integrators against one evaluation of the reference.
static void assert_claims(const char *profile, const char *reloading, const struct claim *claims,
                          size_t claim_count)
{
    uint32_t changed[8] = {0};
    for (size_t i = 0; i < SCENARIOS; i++) {
        char overrides[2][64];
        snprintf(overrides[0], sizeof overrides[0], "barrier.profile=%s", profile);
        snprintf(overrides[1], sizeof overrides[1], "simulation.reloading=%s", reloading);
        const char *const list[] = {overrides[0], overrides[1]};
        struct scenario scenario = read_scenario(scenarios[i], list, 2);
        struct reference_crash crash = reference_crash_of(&scenario);
        crash.step = reference_step;
        draw_designs(&scenario, 5 + i);
        for (uint32_t design = 0; design < DESIGNS; design++) {
            reference_set_forces(&crash, values + design, DESIGNS);
            expected[design] = reference_evaluate(&crash);
        }
        scenario_fini(&scenario);
        for (size_t k = 0; k < claim_count; k++) {
            changed[k] += assert_claim(scenarios[i], profile, reloading, &claims[k]);
        }
    }
    for (size_t k = 0; k < claim_count; k++) {
        if (changed[k] > claims[k].verdicts) {
            fail_msg("%s: %u verdicts change", claims[k].integrator, changed[k]);
        }
    }
}

// On the flat face the schemes that look at whole steps only are of first order, so a tenth of the
// default step is for them what the default one is for event Verlet, and still three times worse.
static const struct claim flat_claims[] = {
    {"event_verlet", "1e-3", {1e-3, 2e-3}, 1e-3, 1e-3, 3},
    {"event_verlet", "2.5e-4", {0.1e-3, 0.3e-3}, 0.1e-3, 1e-4, 2},
    {"central_difference", "1e-4", {3e-3, 5e-3}, 3e-3, 4e-3, 20},
    {"velocity_verlet", "1e-4", {3e-3, 5e-3}, 3e-3, 4e-3, 20},
    {"runge_kutta_4", "1e-4", {3e-3, 5e-3}, 3e-3, 4e-3, 20},
};
enum { CLAIMS = sizeof flat_claims / sizeof *flat_claims };

// A spring on the rounded edge ceases to load shortly before the line is tangent to the arc, at a
// rate that changes without bound.
static const struct claim rounded_claims[] = {
    {"event_verlet", "1e-3", {1.2e-3, 2e-3}, 1.2e-3, 1e-3, 3},
    {"event_verlet", "2.5e-4", {0.1e-3, 0.3e-3}, 0.1e-3, 1e-4, 2},
    {"central_difference", "1e-4", {3e-3, 5e-3}, 5e-3, 4e-3, 20},
    {"velocity_verlet", "1e-4", {3e-3, 5e-3}, 5e-3, 4e-3, 20},
    {"runge_kutta_4", "1e-4", {3e-3, 5e-3}, 5e-3, 4e-3, 20},
};
_Static_assert(sizeof rounded_claims / sizeof *rounded_claims == CLAIMS, "the same schemes");

static void flat_crashes_converge_by_the_thesis_s_rule(void **state)
{
    (void)state;
    assert_claims("flat", "thesis", flat_claims, CLAIMS);
}

static void flat_crashes_converge_crushed(void **state)
{
    (void)state;
    assert_claims("flat", "crushed", flat_claims, CLAIMS);
}

static void rounded_crashes_converge_by_the_thesis_s_rule(void **state)
{
    (void)state;
    assert_claims("rounded", "thesis", rounded_claims, CLAIMS);
}

static void rounded_crashes_converge_crushed(void **state)
{
    (void)state;
    assert_claims("rounded", "crushed", rounded_claims, CLAIMS);
}

// The reference itself: at a fifth of the step nothing changes that could matter to a claim.
static void reference_has_converged(void **state)
{
    (void)state;
    const char *const list[] = {"barrier.profile=rounded", "simulation.reloading=crushed"};
    struct scenario scenario = read_scenario("suv-ten-springs", list, 2);
    struct reference_crash crash = reference_crash_of(&scenario);
    draw_designs(&scenario, 11);
    double greatest = 0.0; // [m], [rad]
    for (uint32_t design = 0; design < 20; design++) {
        reference_set_forces(&crash, values + design, DESIGNS);
        crash.step = reference_step;
        const struct reference_outcome coarse = reference_evaluate(&crash);
        crash.step = 0.2 * reference_step;
        const struct reference_outcome fine = reference_evaluate(&crash);
        greatest = fmax(greatest, fabs(coarse.length_last - fine.length_last));
        greatest = fmax(greatest, fabs(coarse.pillar_travel - fine.pillar_travel));
        greatest = fmax(greatest, fabs(coarse.yaw - fine.yaw));
    }
    print_message("greatest difference %.2g\n", greatest);
    assert_true(greatest < 3e-5);
    scenario_fini(&scenario);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference_has_converged),
        cmocka_unit_test(flat_crashes_converge_by_the_thesis_s_rule),
        cmocka_unit_test(flat_crashes_converge_crushed),
        cmocka_unit_test(rounded_crashes_converge_by_the_thesis_s_rule),
        cmocka_unit_test(rounded_crashes_converge_crushed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
