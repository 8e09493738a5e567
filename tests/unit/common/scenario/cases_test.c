// Cases: one structure in several cars or crashes.
#include "common/scenario/scenario_read.h"

#include "tests/unit/common/scenario/example.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// The example ends with line 44, so cases begin at line 45.
static enum status read_with(struct scenario *scenario, const char *cases, struct error *error)
{
    char *text = g_strconcat(example, cases, NULL);
    *error = (struct error){0};
    enum status status = scenario_read_text(scenario, "t.yaml", text, strlen(text), NULL, 0, error);
    g_free(text);
    return status;
}

static struct scenario read_valid(const char *cases)
{
    struct scenario scenario;
    struct error error;
    if (read_with(&scenario, cases, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    return scenario;
}

// A case is the whole scenario but for what it overrides: by path, by mapping, by a spring's name
// or index. What it leaves alone must not be lost when a mapping is laid over.
static void a_case_is_the_scenario_with_its_overrides(void **state)
{
    (void)state;
    struct scenario s =
        read_valid("cases:\n"
                   "- name: plain\n"
                   "- name: heavy\n"
                   "  vehicle: {mass: 1900}\n"
                   "  barrier.edge_y: -0.5\n"
                   "  springs: {rail-2: {length: 1.25}, 0: {position: [-0.9, -0.7]}}\n"
                   "  response: any\n"
                   "  simulation.duration: 0.13\n");
    assert_int_equal(s.case_count, 2);
    const struct scenario *plain = &s.cases[0], *heavy = &s.cases[1];
    assert_string_equal(plain->name, "plain");
    assert_true(plain->vehicle.mass == 1650);
    assert_memory_equal(plain->springs, s.springs, 2 * sizeof *s.springs);
    assert_true(heavy->vehicle.mass == 1900);
    assert_true(heavy->vehicle.yaw_inertia == 3000);
    assert_true(heavy->barrier.edge_y == -0.5 && heavy->barrier.overlap == 0.455);
    assert_true(heavy->springs[1].length == 1.25);
    assert_true(heavy->springs[1].position[0] == -1.0);
    assert_true(heavy->springs[0].position[0] == -0.9);
    assert_true(heavy->simulation.duration == 0.13 && heavy->simulation.time_step == 5e-4);
    assert_int_equal(heavy->response, SCENARIO_RESPONSE_ANY);
    // The scenario itself stays what the cases began from.
    assert_true(s.vehicle.mass == 1650 && s.springs[1].length == 1.5);
    assert_null(heavy->text);
    scenario_fini(&s);
}

// A mapping may create what the scenario leaves to its default.
static void a_case_may_set_what_the_scenario_leaves_out(void **state)
{
    (void)state;
    struct scenario s = read_valid("cases:\n- {name: a, springs.0.length: 1.1}\n");
    assert_true(s.cases[0].springs[0].length == 1.1);
    scenario_fini(&s);
}

// Outcomes and constraints of all cases stand one after the other, so that everything that deals
// in their indexes, the byte on the wire included, need not know of cases; names say which case.
static void outcomes_and_constraints_count_over_cases(void **state)
{
    (void)state;
    struct scenario s = read_valid("cases:\n"
                                   "- {name: a, response: any}\n"
                                   "- {name: b, response: rotating, constraints.s_L.max: 0.9}\n");
    const uint32_t own = scenario_outcome_count(&s.cases[0]);
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    assert_int_equal(own, OUTCOME_ENERGY_ABSORBED + 4);
    assert_int_equal(scenario_outcome_count(&s), 2 * own);
    assert_string_equal(scenario_outcome_name(&s, OUTCOME_S_L, name), "a.s_L");
    assert_string_equal(scenario_outcome_name(&s, own + OUTCOME_ABWP, name), "b.AbWP");
    assert_string_equal(scenario_outcome_name(&s, 2 * own - 3, name), "b.energy_absorbed.rail-2");
    assert_string_equal(scenario_outcome_name(&s, 2 * own - 1, name), "b.deformation_max.rail-2");
    assert_string_equal(scenario_outcome_name(&s.cases[1], OUTCOME_ABWP, name), "AbWP");
    assert_string_equal(scenario_outcome_unit(&s, own + OUTCOME_YAW_DEG), "deg");
    assert_int_equal(scenario_outcome_find(&s, "b.s_L"), own + OUTCOME_S_L);
    assert_int_equal(scenario_outcome_find(&s, "s_L"), 2 * own);

    // Of `any` one and three of the user's, of `rotating` two more.
    assert_int_equal(s.constraint_count, 4 + 6);
    assert_int_equal(s.constraints[0].outcome, OUTCOME_S_L_MIN);
    assert_int_equal(s.constraints[4].outcome, own + OUTCOME_S_L_MIN);
    assert_int_equal(s.constraints[5].outcome, own + OUTCOME_ABWP);
    assert_true(s.constraints[3].max == 1.0);
    assert_true(s.constraints[9].max == 0.9);
    assert_int_equal(s.cases[1].constraints[5].outcome, OUTCOME_S_L);
    scenario_fini(&s);
}

// Workers read the text again: it must give the same cases, and other cases another name.
static void cases_travel_with_the_text(void **state)
{
    (void)state;
    struct scenario s = read_valid("cases:\n- {name: a}\n- {name: b, vehicle.mass: 1900}\n");
    struct scenario plain = read_valid("");
    struct scenario again;
    struct error error = {0};
    assert_int_equal(scenario_read_text(&again, "again", s.text, s.text_size, NULL, 0, &error),
                     STATUS_OK);
    assert_int_equal(again.case_count, 2);
    assert_true(again.cases[1].vehicle.mass == 1900);
    assert_memory_equal(&again.digest, &s.digest, sizeof s.digest);
    assert_memory_not_equal(&plain.digest, &s.digest, sizeof s.digest);
    scenario_fini(&again);
    scenario_fini(&plain);
    scenario_fini(&s);
}

// Overrides of the command line reach into a case as anywhere.
static void a_case_can_be_overridden(void **state)
{
    (void)state;
    char *text = g_strconcat(example, "cases:\n- {name: a, vehicle: {mass: 1900}}\n", NULL);
    const char *override = "cases.0.vehicle.mass=2000";
    struct scenario s;
    struct error error = {0};
    assert_int_equal(scenario_read_text(&s, "t.yaml", text, strlen(text), &override, 1, &error),
                     STATUS_OK);
    assert_true(s.cases[0].vehicle.mass == 2000);
    scenario_fini(&s);
    g_free(text);
}

// A mistake is pointed at where the case has it, or, when the value is the scenario's own, there;
// either way the message names the case.
static void mistakes_are_pointed_at(void **state)
{
    (void)state;
    static const char *const mistakes[][2] = {
        {"cases: 3\n", "t.yaml:45:8: cases: expected a list of 1 to 32 cases, found 3"},
        {"cases: []\n", "t.yaml:45:8: cases: expected a list of 1 to 32 cases, found a list of 0"},
        {"cases:\n- 3\n",
         "t.yaml:46:3: cases.0: expected a mapping with the case's name and what it overrides"},
        {"cases:\n- {vehicle.mass: 3}\n",
         "t.yaml:46:3: cases.0: expected a mapping with the case's name and what it overrides"},
        {"cases:\n- {name: a b}\n",
         "t.yaml:46:10: cases.0.name: expected a name of 1 to 63 letters, digits, '_' or '-', "
         "found a b"},
        {"cases:\n- {name: a}\n- {name: a}\n",
         "t.yaml:47:10: cases.1.name: expected a name that no other case has, found a, the name of "
         "cases.0"},
        {"cases:\n- {name: a, search.seed: 3}\n",
         "t.yaml:46:13: cases.0: expected no 'search' in a case: it is that of all cases"},
        {"cases:\n- {name: a, model: ellipse}\n",
         "t.yaml:46:13: cases.0: expected no 'model' in a case: it is that of all cases"},
        {"cases:\n- {name: a, vehicle.mass: -3}\n",
         "t.yaml:46:27: vehicle.mass: expected more than 0 kg, found -3 (in case a)"},
        {"cases:\n- {name: a, vehicle: 3}\n",
         "t.yaml:46:22: vehicle: expected a mapping, found 3 (in case a)"},
        {"cases:\n- {name: a, vehicle: {mas: 3}}\n",
         "t.yaml:46:23: vehicle: unknown key 'mas'; did you mean 'mass'? (in case a)"},
        {"cases:\n- {name: a, simulation: {duration: 1e-4}}\n",
         "t.yaml:29:14: simulation.time_step: expected a time_step of at most the duration of "
         "0.0001 s, found 0.0005 (in case a)"},
        {"cases:\n- {name: a, springs: {back: {length: 1}}}\n",
         "t.yaml:46:23: springs: expected the name of an item or an index from 0 to 1, found "
         "'back' (in case a)"},
        {"cases:\n- {name: a, springs.2.length: 1}\n",
         "t.yaml:46:13: springs: expected the name of an item or an index from 0 to 1, found '2' "
         "(in case a)"},
        {"cases:\n- {name: a, vehicle.mass.kg: 1}\n",
         "t.yaml:46:13: vehicle.mass: expected a mapping to set 'kg' in, found 1650 (in case a)"},
        {"cases:\n- {name: a, springs.0.force_x.lower: [1, 0, 0]}\n",
         "t.yaml:46:3: cases.0: expected the bounds of front.force_x[0] in all cases, 0 to 60000, "
         "found 1 to 60000"},
        {"cases:\n- {name: a, springs.0.deformation: [0, 0.5, 0.9]}\n",
         "t.yaml:46:3: cases.0: expected front.force_x[2] at the deformation of all cases"},
        {"cases:\n- {name: a, springs.0.name: fore}\n",
         "t.yaml:46:3: cases.0: expected the variable front.force_x[0] of all cases, found "
         "fore.force_x[0]"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(mistakes); i++) {
        struct scenario scenario;
        struct error error;
        if (read_with(&scenario, mistakes[i][0], &error) != STATUS_INVALID ||
            strcmp(error.text, mistakes[i][1]) != 0)
            fail_msg("'%s': expected: %s\n found: %s", mistakes[i][0], mistakes[i][1], error.text);
        assert_null(scenario.cases);
    }
}

// 32 cases of 8 constraints are one more than the byte on the wire can name.
static void constraints_of_all_cases_fit_a_byte(void **state)
{
    (void)state;
    GString *cases = g_string_new("cases:\n");
    for (int i = 0; i < SCENARIO_CASE_MAX; i++)
        g_string_append_printf(
            cases, "- {name: c%d, constraints: {AbWP: {max: 9}, AbWAP: {max: 9}}}\n", i);
    struct scenario scenario;
    struct error error;
    assert_int_equal(read_with(&scenario, cases->str, &error), STATUS_INVALID);
    assert_string_equal(error.text, "t.yaml:46:1: cases: expected at most 255 constraints in all "
                                    "cases together");
    g_string_free(cases, TRUE);
}

// Whatever byte is missing, the text is read or refused, and nothing is leaked or overrun.
static void every_prefix_is_read_or_refused(void **state)
{
    (void)state;
    static const char cases[] = "cases:\n- {name: a, springs: {front: {length: 1.25}}}\n"
                                "- name: b\n  vehicle.mass: 2000\n  constraints.s_L.max: 1\n";
    for (size_t size = 0; size < sizeof cases; size++) {
        char *part = g_strndup(cases, size);
        struct scenario scenario;
        struct error error;
        if (read_with(&scenario, part, &error) == STATUS_OK)
            scenario_fini(&scenario);
        else
            assert_true(error.text[0] != '\0');
        g_free(part);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_case_is_the_scenario_with_its_overrides),
        cmocka_unit_test(a_case_may_set_what_the_scenario_leaves_out),
        cmocka_unit_test(outcomes_and_constraints_count_over_cases),
        cmocka_unit_test(cases_travel_with_the_text),
        cmocka_unit_test(a_case_can_be_overridden),
        cmocka_unit_test(mistakes_are_pointed_at),
        cmocka_unit_test(constraints_of_all_cases_fit_a_byte),
        cmocka_unit_test(every_prefix_is_read_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
