#include "common/scenario/scenario.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// A scenario with two springs whose names the outcomes take over.
static void make_two_springs(struct scenario *scenario)
{
    scenario_init(scenario);
    scenario->spring_count = 2;
    scenario->springs = g_new0(struct scenario_spring, 2);
    g_strlcpy(scenario->springs[0].name, "wheel", SCENARIO_NAME_SIZE);
    g_strlcpy(scenario->springs[1].name, "shotgun", SCENARIO_NAME_SIZE);
}

// Constraints, JSON and messages name outcomes by text, so every name leads back to its outcome.
static void every_outcome_is_found_by_its_name(void **state)
{
    (void)state;
    struct scenario scenario;
    make_two_springs(&scenario);
    uint32_t count = scenario_outcome_count(&scenario);
    assert_int_equal(count, OUTCOME_ENERGY_ABSORBED + 4);
    for (uint32_t i = 0; i < count; i++) {
        char name[SCENARIO_OUTCOME_NAME_SIZE];
        assert_int_equal(
            scenario_outcome_find(&scenario, scenario_outcome_name(&scenario, i, name)), i);
        assert_true(strlen(scenario_outcome_unit(&scenario, i)) > 0);
    }
    assert_int_equal(scenario_outcome_find(&scenario, "s_l"), count);
    assert_int_equal(scenario_outcome_find(&scenario, "energy_absorbed"), count);
    assert_int_equal(scenario_outcome_find(&scenario, "energy_absorbed.shotgun"), count - 3);
    assert_int_equal(scenario_outcome_find(&scenario, "deformation_max.shotgun"), count - 1);
    assert_string_equal(scenario_outcome_unit(&scenario, OUTCOME_S_L), "m");
    assert_string_equal(scenario_outcome_unit(&scenario, OUTCOME_ABWP), "1");
    assert_string_equal(scenario_outcome_unit(&scenario, count - 3), "J");
    assert_string_equal(scenario_outcome_unit(&scenario, count - 1), "m");
    scenario_fini(&scenario);
}

// The words of the file are what programs print.
static void enums_answer_with_the_words_of_the_file(void **state)
{
    (void)state;
    assert_string_equal(scenario_response_name(SCENARIO_RESPONSE_GLANCING_OFF), "glancing_off");
    assert_string_equal(scenario_integrator_name(SCENARIO_INTEGRATOR_RUNGE_KUTTA_4),
                        "runge_kutta_4");
    assert_string_equal(scenario_reloading_name(SCENARIO_RELOADING_CRUSHED), "crushed");
    assert_string_equal(scenario_sampling_name(SAMPLING_METHOD_SOBOL), "sobol");
    assert_string_equal(scenario_profile_name(SCENARIO_PROFILE_ROUNDED), "rounded");
    assert_string_equal(scenario_direction_name(SCENARIO_DIRECTION_X), "x");
    assert_string_equal(scenario_direction_name(SCENARIO_DIRECTION_Y), "y");
}

// fini follows every way out, so it takes a zeroed struct and can be called twice.
static void fini_is_safe_on_nothing(void **state)
{
    (void)state;
    struct scenario scenario;
    memset(&scenario, 0, sizeof scenario);
    scenario_fini(&scenario);
    make_two_springs(&scenario);
    scenario_fini(&scenario);
    scenario_fini(&scenario);
    assert_null(scenario.springs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_outcome_is_found_by_its_name),
        cmocka_unit_test(enums_answer_with_the_words_of_the_file),
        cmocka_unit_test(fini_is_safe_on_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
