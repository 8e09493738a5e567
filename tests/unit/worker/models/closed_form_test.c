// Models in closed form against values worked out by hand.
#include "common/scenario/scenario_read.h"
#include "worker/models/model.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { VARIABLE_MAX = 16, OUTCOME_MAX = 8 };

static struct scenario read_valid(const char *text)
{
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_text(&scenario, "t.yaml", text, strlen(text), NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    return scenario;
}

// Evaluates `count` designs, design after design in `designs`.
static void evaluate(const struct scenario *scenario, uint32_t count, const double *designs,
                     double outcomes[OUTCOME_MAX * MODEL_BLOCK])
{
    static double values[VARIABLE_MAX * MODEL_BLOCK];
    struct model *model = model_create(scenario);
    const uint32_t variables = model_variable_count(model);
    assert_int_equal(variables, scenario->design_space.count);
    assert_true(variables <= VARIABLE_MAX);
    assert_int_equal(model_outcome_count(model), scenario_outcome_count(scenario));
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t v = 0; v < variables; v++)
            values[v * MODEL_BLOCK + i] = designs[i * variables + v];
    }
    model_evaluate(model, count, values, outcomes);
    model_free(model);
}

static void assert_near(double found, double expected)
{
    if (!(fabs(found - expected) <= 1e-12 * fmax(1, fabs(expected))))
        fail_msg("expected %.17g, found %.17g", expected, found);
}

// One design, all its outcomes.
static void assert_outcomes(const char *text, const double *design, const double *expected)
{
    struct scenario scenario = read_valid(text);
    double outcomes[OUTCOME_MAX * MODEL_BLOCK];
    evaluate(&scenario, 1, design, outcomes);
    for (uint32_t i = 0; i < scenario_outcome_count(&scenario); i++)
        assert_near(outcomes[i * MODEL_BLOCK], expected[i]);
    scenario_fini(&scenario);
}

#define VARIABLE(name) "{name: " name ", lower: -9e6, upper: 9e6}"

// 3-4-12 has the norm 13; the ball's radius is sqrt(3) / 2.
static void hypersphere_is_the_distance_from_the_ball(void **state)
{
    (void)state;
    assert_outcomes("name: s\nmodel: hypersphere\nvariables: [" VARIABLE("a") "," VARIABLE(
                        "b") "," VARIABLE("c") "]\nconstraints: {distance: {max: 0}}\n",
                    (const double[]){3, -4, 12}, (const double[]){13 - sqrt(3) / 2});
    // The corner of the unit cube is where the ball begins, in any number of dimensions.
    assert_outcomes("name: s\nmodel: hypersphere\nvariables: [" VARIABLE("a") "," VARIABLE(
                        "b") "," VARIABLE("c") "," VARIABLE("d") "]\nconstraints: {distance: "
                                                                 "{max: 0}}\n",
                    (const double[]){.5, -.5, .5, .5}, (const double[]){0});
}

#define ELLIPSE(angle)                                                          \
    "name: s\nmodel: ellipse\nvariables: [" VARIABLE("x") "," VARIABLE(         \
        "y") "]\nparameters: {center: [1, 2], semi_axes: [2, 1], angle: " angle \
             "}\nconstraints: {level: {max: 1}}\n"

// The ends of the axes lie on the ellipse, wherever they point. A wrong sense of rotation would
// mirror it.
static void ellipse_is_one_at_the_ends_of_its_axes(void **state)
{
    (void)state;
    const double h = sqrt(0.5);
    assert_outcomes(ELLIPSE("0"), (const double[]){3, 2}, (const double[]){1});
    assert_outcomes(ELLIPSE("0"), (const double[]){1, 3}, (const double[]){1});
    assert_outcomes(ELLIPSE("90"), (const double[]){1, 4}, (const double[]){1});
    assert_outcomes(ELLIPSE("45"), (const double[]){1 + 2 * h, 2 + 2 * h}, (const double[]){1});
    assert_outcomes(ELLIPSE("45"), (const double[]){1 - h, 2 + h}, (const double[]){1});
    assert_outcomes(ELLIPSE("-45"), (const double[]){1 + 2 * h, 2 - 2 * h}, (const double[]){1});
    assert_outcomes(ELLIPSE("30"), (const double[]){1 + sqrt(3), 3}, // two along 30 degrees
                    (const double[]){1});
    assert_outcomes(ELLIPSE("45"), (const double[]){1, 2}, (const double[]){0});
}

static void linear_is_the_matrix_times_the_design(void **state)
{
    (void)state;
    assert_outcomes("name: s\nmodel: linear\nvariables: [" VARIABLE("x") "," VARIABLE(
                        "y") "]\nparameters: {matrix: [[1, 2], [-3, 0.5], [0, 0]]}\n"
                             "constraints: {row_1: {max: 0}}\n",
                    (const double[]){7, 10}, (const double[]){27, -16, 0});
}

// Zero at (1, 1, 1); 100 (4 - 4)^2 + 1 + 100 (20 - 16)^2 + 9 at (2, 4, 20).
static void rosenbrock_sums_over_neighbours(void **state)
{
    (void)state;
    static const char text[] = "name: s\nmodel: rosenbrock\nvariables: [" VARIABLE(
        "x") "," VARIABLE("y") "," VARIABLE("z") "]\nconstraints: {value: {max: 20}}\n";
    assert_outcomes(text, (const double[]){1, 1, 1}, (const double[]){0});
    assert_outcomes(text, (const double[]){2, 4, 20}, (const double[]){1 + 1600 + 9});
}

// 2000 kg at 15.6 m/s have 243,360 J; 400 kN and 500 kN over 0.3 m each take 270,000 J.
static void two_sections_take_energy_in_order(void **state)
{
    (void)state;
    static const double expected[] = {243360 - 270000, 250, -100e3};
    assert_outcomes("name: s\nmodel: two_section_crash\nvariables: [" VARIABLE("F1") "," VARIABLE(
                        "F2") "]\nparameters: {mass: 2000, d1: 0.3, d2: 0.3, speed: 15.6}\n"
                              "constraints: {order: {max: 0}}\n",
                    (const double[]){400e3, 500e3}, expected);
    // The same crash with other inputs as variables.
    assert_outcomes(
        "name: s\nmodel: two_section_crash\nvariables: [" VARIABLE("speed") "," VARIABLE(
            "mass") "," VARIABLE("F2") "]\nparameters: {F1: 400e3, d1: 0.3, d2: 0.3}\n"
                                       "constraints: {order: {max: 0}}\n",
        (const double[]){15.6, 2000, 500e3}, expected);
}

// The order is that of the worst neighbours, here the last two; the deceleration that of the
// greatest force, here in the middle.
static void ordered_crash_finds_the_worst_neighbours(void **state)
{
    (void)state;
    assert_outcomes("name: s\nmodel: ordered_crash\nvariables: [" VARIABLE("F_1") "," VARIABLE(
                        "F_2") "," VARIABLE("F_3") "]\nparameters: {lengths: [0.1, 0.2, 0.3], "
                                                   "mass: 1000, speed: 10}\n"
                                                   "constraints: {order_max: {max: 0}}\n",
                    (const double[]){100e3, 300e3, 250e3},
                    (const double[]){50e3 - 10e3 - 60e3 - 75e3, 50e3, 300});
}

// Two triangles: path 1 rises to 100 kN, path 2 falls from 60 kN, each over 0.6 m. The trapezoid
// rule is exact for them.
static void corridor_crash_adds_its_paths(void **state)
{
    (void)state;
    assert_outcomes(
        "name: s\nmodel: corridor_crash\nvariables: [" VARIABLE("a1") "," VARIABLE(
            "a2") "," VARIABLE("a3") "," VARIABLE("b1") "," VARIABLE("b2") "," VARIABLE("b3") "]\n"
                                                                                              "para"
                                                                                              "mete"
                                                                                              "rs: "
                                                                                              "{len"
                                                                                              "gth:"
                                                                                              " 0."
                                                                                              "6, "
                                                                                              "poin"
                                                                                              "ts: "
                                                                                              "3, "
                                                                                              "ener"
                                                                                              "gy: "
                                                                                              "50e3"
                                                                                              "}\n"
                                                                                              "cons"
                                                                                              "trai"
                                                                                              "nts:"
                                                                                              " {"
                                                                                              "forc"
                                                                                              "e_"
                                                                                              "max:"
                                                                                              " {"
                                                                                              "max:"
                                                                                              " 1e5"
                                                                                              "}}"
                                                                                              "\n",
        (const double[]){0, 50e3, 100e3, 60e3, 30e3, 0},
        (const double[]){50e3 - 0.5 * 0.6 * 100e3 - 0.5 * 0.6 * 60e3, 100e3});
}

// A design's outcomes have the same bits alone and among others: the blocks of a search are filled
// differently on every cluster.
static void neighbours_do_not_matter(void **state)
{
    (void)state;
    struct scenario s = read_valid(ELLIPSE("33.3"));
    double designs[2 * MODEL_BLOCK], together[OUTCOME_MAX * MODEL_BLOCK];
    double alone[OUTCOME_MAX * MODEL_BLOCK];
    for (uint32_t i = 0; i < 2 * MODEL_BLOCK; i++)
        designs[i] = 0.37 * i - 11.3;
    evaluate(&s, MODEL_BLOCK, designs, together);
    for (uint32_t i = 0; i < MODEL_BLOCK; i++) {
        evaluate(&s, 1, designs + 2 * i, alone);
        assert_memory_equal(&alone[0], &together[i], sizeof(double));
    }
    scenario_fini(&s);
}

// These bits are the same on every machine: angles do not go through the system's libm.
static void ellipse_has_golden_bits(void **state)
{
    (void)state;
    struct scenario s = read_valid(ELLIPSE("33.3"));
    double outcomes[OUTCOME_MAX * MODEL_BLOCK];
    evaluate(&s, 1, (const double[]){1.7, 0.3}, outcomes);
    assert_true(outcomes[0] == 0x1.a4fee7dcc56fep+1);
    scenario_fini(&s);
}

// A division by a mass of zero is no number, and the batch must see it.
static void no_number_stays_no_number(void **state)
{
    (void)state;
    struct scenario s = read_valid("name: s\nmodel: two_section_crash\nvariables: [" VARIABLE(
        "F2") "," VARIABLE("mass") "]\nparameters: {F1: 1, d1: 0.3, d2: 0.3, speed: 1}\n"
                                   "constraints: {order: {max: 0}}\n");
    double outcomes[OUTCOME_MAX * MODEL_BLOCK];
    evaluate(&s, 2, (const double[]){1, 0, 0, 0}, outcomes);
    assert_true(isinf(outcomes[1 * MODEL_BLOCK]));
    assert_true(isnan(outcomes[1 * MODEL_BLOCK + 1]));
    scenario_fini(&s);
}

// With cases the outcomes of each stand one after the other, as the scenario names them.
static void cases_are_evaluated_one_after_the_other(void **state)
{
    (void)state;
    struct scenario s =
        read_valid("name: s\nmodel: two_section_crash\nvariables: [" VARIABLE("F1") "," VARIABLE(
            "F2") "]\nparameters: {mass: 2000, d1: 0.3, d2: 0.3, speed: 15.6}\n"
                  "constraints: {order: {max: 0}}\n"
                  "cases:\n- {name: light, parameters.mass: 1000}\n- {name: heavy}\n");
    static const double expected[] = {121680 - 270000, 500, -100e3, 243360 - 270000, 250, -100e3};
    double outcomes[OUTCOME_MAX * MODEL_BLOCK];
    evaluate(&s, 1, (const double[]){400e3, 500e3}, outcomes);
    for (uint32_t i = 0; i < 6; i++)
        assert_near(outcomes[i * MODEL_BLOCK], expected[i]);
    assert_int_equal(scenario_outcome_find(&s, "heavy.decel_max"), 4);
    scenario_fini(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hypersphere_is_the_distance_from_the_ball),
        cmocka_unit_test(ellipse_is_one_at_the_ends_of_its_axes),
        cmocka_unit_test(linear_is_the_matrix_times_the_design),
        cmocka_unit_test(rosenbrock_sums_over_neighbours),
        cmocka_unit_test(two_sections_take_energy_in_order),
        cmocka_unit_test(ordered_crash_finds_the_worst_neighbours),
        cmocka_unit_test(corridor_crash_adds_its_paths),
        cmocka_unit_test(neighbours_do_not_matter),
        cmocka_unit_test(ellipse_has_golden_bits),
        cmocka_unit_test(no_number_stays_no_number),
        cmocka_unit_test(cases_are_evaluated_one_after_the_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
