// What scenarios of models in closed form mean, and what their mistakes are told.
#include "common/scenario/formula.h"
#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define VARIABLES(list) "variables: [" list "]\n"
#define VARIABLE(name) "{name: " name ", lower: -1, upper: 2}"

static struct scenario read_valid(const char *text)
{
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_text(&scenario, "t.yaml", text, strlen(text), NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    return scenario;
}

static void assert_refused(const char *text, const char *message)
{
    struct scenario scenario;
    struct error error = {0};
    enum status status =
        scenario_read_text(&scenario, "t.yaml", text, strlen(text), NULL, 0, &error);
    if (status != STATUS_INVALID || strcmp(error.text, message) != 0)
        fail_msg("expected: %s\n found: %s", message, error.text);
    assert_null(scenario.variables);
}

static void assert_input(const struct scenario *scenario, uint32_t input, uint32_t variable,
                         double value)
{
    assert_true(input < scenario->formula.input_count);
    assert_int_equal(scenario->formula.inputs[input].variable, variable);
    if (variable == SCENARIO_CONSTANT)
        assert_true(scenario->formula.inputs[input].value == value);
}

// Variables keep the order of the file and belong to no spring: a report that took index 0 for a
// spring would read past the end of none.
static void variables_belong_to_no_spring(void **state)
{
    (void)state;
    struct scenario s = read_valid("name: s\nmodel: hypersphere\n" VARIABLES(
        VARIABLE("b") ", {name: a, lower: 3, upper: 3}") "constraints: {distance: {max: 0}}\n");
    assert_int_equal(s.model, SCENARIO_MODEL_HYPERSPHERE);
    assert_int_equal(s.spring_count, 0);
    assert_int_equal(s.design_space.count, 2);
    assert_string_equal(s.variables[0].name, "b");
    assert_string_equal(s.variables[1].name, "a");
    assert_int_equal(s.variables[0].spring, SCENARIO_NO_SPRING);
    assert_true(s.design_space.lower[0] == -1 && s.design_space.upper[0] == 2);
    assert_int_equal(box_free_count(&s.design_space), 1);
    assert_int_equal(s.formula.input_count, 2);
    assert_input(&s, 0, 0, 0);
    assert_input(&s, 1, 1, 0);
    scenario_fini(&s);
}

// The same model serves with a mass that is given and with one that is searched for: the inputs
// keep the model's order whatever the order of the file.
static void an_input_is_a_variable_or_a_parameter(void **state)
{
    (void)state;
    struct scenario s = read_valid("name: s\nmodel: two_section_crash\n" VARIABLES(
        VARIABLE("mass") "," VARIABLE("F2")) "parameters: {d2: 0.4, speed: 10, F1: 2e5, d1: "
                                             "0.3}\n"
                                             "constraints: {order: {max: 0}}\n");
    assert_int_equal(s.formula.input_count, FORMULA_TWO_SECTION_INPUT_COUNT);
    assert_input(&s, FORMULA_TWO_SECTION_F1, SCENARIO_CONSTANT, 2e5);
    assert_input(&s, FORMULA_TWO_SECTION_F2, 1, 0);
    assert_input(&s, FORMULA_TWO_SECTION_MASS, 0, 0);
    assert_input(&s, FORMULA_TWO_SECTION_D1, SCENARIO_CONSTANT, 0.3);
    assert_input(&s, FORMULA_TWO_SECTION_D2, SCENARIO_CONSTANT, 0.4);
    assert_input(&s, FORMULA_TWO_SECTION_SPEED, SCENARIO_CONSTANT, 10);
    scenario_fini(&s);
}

// Lists and matrices arrive row by row; there is an outcome for every row.
static void matrix_gives_an_outcome_a_row(void **state)
{
    (void)state;
    struct scenario s = read_valid("name: s\nmodel: linear\n" VARIABLES(
        VARIABLE("x") "," VARIABLE("y")) "parameters: {matrix: [[1, 2], [3, 4], [5, 6]]}\n"
                                         "constraints: {row_3: {max: 0}, row_1: {min: 1}}\n");
    assert_int_equal(s.formula.rows, 3);
    for (int i = 0; i < 6; i++)
        assert_true(s.formula.constants[i] == i + 1);
    assert_int_equal(scenario_outcome_count(&s), 3);
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    assert_string_equal(scenario_outcome_name(&s, 1, name), "row_2");
    assert_int_equal(s.constraint_count, 2);
    assert_int_equal(s.constraints[0].outcome, 2);
    assert_int_equal(s.constraints[1].outcome, 0);
    // A bound of zero gives no measure; |5| 2 + |6| 2 is as far as the row can be.
    assert_true(s.constraints[0].scale == 22);
    assert_true(s.constraints[1].scale == 1);
    scenario_fini(&s);
}

// A limit among the parameters is a constraint like any other, before the user's.
static void limits_are_constraints(void **state)
{
    (void)state;
    struct scenario s = read_valid("name: s\nmodel: ordered_crash\n" VARIABLES(
        VARIABLE("F_2") "," VARIABLE("F_1")) "parameters: {lengths: [0.1, 0.2], mass: 1000, "
                                             "speed: 15, decel_limit: 300}\n"
                                             "constraints: {order_max: {max: 0}}\n");
    assert_int_equal(s.constraint_count, 2);
    assert_int_equal(s.constraints[0].outcome, FORMULA_ORDERED_DECEL_MAX);
    assert_true(s.constraints[0].max == 300 && s.constraints[0].min == -INFINITY);
    assert_int_equal(s.constraints[1].outcome, FORMULA_ORDERED_ORDER_MAX);
    assert_input(&s, FORMULA_ORDERED_FORCE, 1, 0);
    assert_input(&s, FORMULA_ORDERED_FORCE + 1, 0, 0);
    assert_true(s.formula.constants[1] == 0.2);
    scenario_fini(&s);

    s = read_valid("name: s\nmodel: corridor_crash\n" VARIABLES(
        VARIABLE("a") "," VARIABLE("energy") "," VARIABLE("b") "," VARIABLE("c") "," VARIABLE(
            "d")) "parameters: {length: 0.6, points: 2, force_limit: 6e5}\n");
    assert_int_equal(s.constraint_count, 1);
    assert_int_equal(s.constraints[0].outcome, FORMULA_CORRIDOR_FORCE_MAX);
    assert_input(&s, FORMULA_CORRIDOR_ENERGY, 1, 0);
    // Forces are the variables of no other meaning, path by path.
    assert_input(&s, FORMULA_CORRIDOR_FORCE, 0, 0);
    assert_input(&s, FORMULA_CORRIDOR_FORCE + 1, 2, 0);
    assert_input(&s, FORMULA_CORRIDOR_FORCE + 3, 4, 0);
    scenario_fini(&s);
}

// What travels to workers is read there again: it must say the same.
static void canonical_text_is_the_same_formula(void **state)
{
    (void)state;
    struct scenario s = read_valid("name: s\nmodel: ellipse\n" VARIABLES(
        VARIABLE("x") "," VARIABLE("y")) "parameters: {center: [1, 2], semi_axes: [3, 4], angle: "
                                         "30}\nconstraints: {level: {max: 1}}\n");
    assert_true(s.formula.constants[FORMULA_ELLIPSE_ANGLE_DEG] == 30);
    struct scenario again = read_valid(s.text);
    assert_string_equal(again.text, s.text);
    assert_memory_equal(&again.digest, &s.digest, sizeof s.digest);
    assert_memory_equal(again.formula.constants, s.formula.constants, 5 * sizeof(double));
    scenario_fini(&again);
    scenario_fini(&s);
}

// Each mistake has its place, and says what would be right.
static void mistakes_are_pointed_at(void **state)
{
    (void)state;
    static const char *const mistakes[][2] = {
        {"name: s\nmodel: hypersphere\nvariables: 3\nconstraints: {}\n",
         "t.yaml:3:12: variables: expected a list of 1 to 4096 variables with name, lower and "
         "upper, found 3"},
        {"name: s\nmodel: hypersphere\nsprings: []\nvariables: []\n",
         "t.yaml:3:1: unknown key 'springs'; expected one of name, model, variables, parameters, "
         "constraints, search, cases"},
        {"name: s\nmodel: hypersphere\nvariables:\n- {name: x, lower: 2, upper: 1}\n",
         "t.yaml:4:30: variables.0.upper: expected at least the lower bound of 2, found 1"},
        {"name: s\nmodel: hypersphere\nvariables:\n- {name: x, lower: 1, upper: 1}\n",
         "t.yaml:4:1: variables: every variable is fixed: expected at least one with its lower "
         "bound below its upper"},
        {"name: s\nmodel: hypersphere\nvariables:\n- {name: x, lower: 0, upper: 1}\n"
         "- {name: x, lower: 0, upper: 1}\n",
         "t.yaml:5:10: variables.1.name: expected a name that no other variable has, found x a "
         "second time"},
        {"name: s\nmodel: hypersphere\nvariables: [{name: a.b, lower: 0, upper: 1}]\n",
         "t.yaml:3:20: variables.0.name: expected a name of 1 to 63 letters, digits, '_' or '-', "
         "found a.b"},
        {"name: s\nmodel: hypersphere\nvariables: [{name: x, lower: 0, upper: 1}]\n",
         "t.yaml:1:1: missing key 'constraints': expected at least one constraint, as distance: "
         "{max: 0}"},
        {"name: s\nmodel: hypersphere\nvariables: [{name: x, lower: 0, upper: 1}]\n"
         "constraints: {level: {max: 1}}\n",
         "t.yaml:4:15: constraints: unknown outcome 'level'; expected one of distance"},
        {"name: s\nmodel: hypersphere\nvariables: [{name: x, lower: 0, upper: 1}]\n"
         "parameters: {radius: 1}\n",
         "t.yaml:4:14: parameters: unknown parameter 'radius': model hypersphere has none"},
        {"name: s\nmodel: rosenbrock\nvariables: [{name: x, lower: 0, upper: 1}]\n",
         "t.yaml:3:12: variables: expected at least 2 variables, found 1"},
        {"name: s\nmodel: ellipse\nvariables: [{name: z, lower: 0, upper: 1}]\n",
         "t.yaml:3:20: variables.0.name: unknown variable 'z'; did you mean 'x'?"},
        {"name: s\nmodel: ellipse\nvariables: [{name: x, lower: 0, upper: 1}]\n",
         "t.yaml:1:1: missing parameter 'y': expected a number, or a variable of that name"},
        {"name: s\nmodel: ellipse\nvariables: [{name: x, lower: 0, upper: 1}]\n"
         "parameters: {x: 1, y: 1}\n",
         "t.yaml:4:17: parameters.x: expected a variable or a parameter: there is a variable x "
         "too"},
        {"name: s\nmodel: ellipse\nvariables: [{name: x, lower: 0, upper: 1}]\n"
         "parameters: {y: 1, center: 0}\n",
         "t.yaml:4:28: parameters.center: expected a list of 2 numbers, found 0"},
        {"name: s\nmodel: ellipse\nvariables: [{name: x, lower: 0, upper: 1}]\n"
         "parameters: {y: 1, center: [0, 0], semi_axes: [1, 0], angle: 0}\n",
         "t.yaml:4:51: parameters.semi_axes.1: expected more than 0, found 0"},
        {"name: s\nmodel: ellipse\nvariables: [{name: x, lower: 0, upper: 1}]\n"
         "parameters: {y: 1, center: [0, 0], semi_axes: [1, 1]}\n",
         "t.yaml:4:13: parameters: missing key 'angle': expected a number in degrees"},
        {"name: s\nmodel: linear\nvariables: [{name: x, lower: 0, upper: 1}]\n"
         "parameters: {matrix: [[1], [1, 2]]}\n",
         "t.yaml:4:28: parameters.matrix.1: expected a list of 1 numbers, one a variable, found a "
         "list of 2"},
        {"name: s\nmodel: two_section_crash\nvariables: [{name: F1, lower: 0, upper: 1}]\n"
         "parameters: {mas: 1}\n",
         "t.yaml:4:14: parameters: unknown parameter 'mas'; did you mean 'mass'?"},
        {"name: s\nmodel: two_section_crash\nvariables: [{name: F1, lower: 0, upper: 1}]\n"
         "parameters: {F2: 1, mass: -1}\n",
         "t.yaml:4:27: parameters.mass: expected more than 0 kg, found -1"},
        {"name: s\nmodel: two_section_crash\nvariables: [{name: F1, lower: 0, upper: 1}]\n"
         "parameters: 5\n",
         "t.yaml:4:13: parameters: expected a mapping with the parameters of model "
         "two_section_crash, found 5"},
        {"name: s\nmodel: ordered_crash\nvariables: [{name: F_1, lower: 0, upper: 1}]\n"
         "parameters: {lengths: [1]}\n",
         "t.yaml:4:23: parameters.lengths: expected a list of 2 to 4096 numbers, found a list of "
         "1"},
        {"name: s\nmodel: corridor_crash\nvariables: [{name: a, lower: 0, upper: 1}]\n"
         "parameters: {length: 1, energy: 1, points: 2}\n",
         "t.yaml:3:12: variables: expected a force for each of 2 points of each path, path by "
         "path, found 1 forces"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(mistakes); i++)
        assert_refused(mistakes[i][0], mistakes[i][1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(variables_belong_to_no_spring),
        cmocka_unit_test(an_input_is_a_variable_or_a_parameter),
        cmocka_unit_test(matrix_gives_an_outcome_a_row),
        cmocka_unit_test(limits_are_constraints),
        cmocka_unit_test(canonical_text_is_the_same_formula),
        cmocka_unit_test(mistakes_are_pointed_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
