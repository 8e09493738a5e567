// Which points of a corridor mean something: the rule on given deformations, and what it says
// against crashes that are simulated here, one by one.
#include "coordinator/report/reach.h"

#include "sample_run.h"

#include "worker/batch/batch.h"

#include <math.h>

static void read_scenario(struct scenario *scenario, const char *yaml)
{
    struct error error = {0};
    if (scenario_read_text(scenario, "reach", yaml, strlen(yaml), NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

// A car that turns around the barrier or slides past it, whose corridors begin at a third of what
// stops it: its last points are out of reach.
static const char TURNING[] = "name: turning\n"
                              "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                              "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                              "springs:\n"
                              "  - name: front\n"
                              "    position: [-0.83, -0.75]\n"
                              "    deformation: [0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4]\n"
                              "    force_x: {lower: 300e3, upper: 700e3}\n"
                              "    force_y: {lower: 20e3, upper: 200e3}\n"
                              "  - name: rail\n"
                              "    position: [-0.83, -0.6]\n"
                              "    deformation: [0.1, 0.5, 0.9, 1.3]\n"
                              "    force_x: {lower: 20e3, upper: 60e3}\n"
                              "    force_y: {lower: 0, upper: 20e3}\n"
                              "response: any\n"
                              "firewall_distance: 0.25\n";

// ---- the rule ----

// The force between two points depends on both, so a point is reached as soon as the one before is
// passed, and not by a spring that stops exactly there.
static void point_is_reached_when_the_one_before_is_passed(void **state)
{
    (void)state;
    static const struct {
        double pressed; // [m]
        uint32_t reached, beyond;
    } cases[] = {
        {0, 0, 0},     {0.05, 0, 0}, {0.1, 1, 0},    {0.1001, 2, 1}, {0.4, 2, 1}, {0.5, 2, 1},
        {0.501, 3, 2}, {0.9, 3, 2},  {0.9001, 4, 4}, {1.3, 4, 4},    {7, 4, 4},
    };
    struct scenario scenario;
    read_scenario(&scenario, TURNING); // rail has points at 0.1, 0.5, 0.9 and 1.3 m
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        const struct reach reach = {.spring_count = 2, .deformation_max = {2, cases[i].pressed}};
        assert_int_equal(reach_points(&reach, &scenario, 0), 8);
        assert_int_equal(reach_points(&reach, &scenario, 1), cases[i].reached);
        assert_int_equal(reach_beyond(&reach, &scenario, 1), cases[i].beyond);
        assert_int_equal(reach_everything(&reach, &scenario), cases[i].reached == 4);
        for (uint32_t k = 0; k < 4; k++) { // behind the 16 variables of front
            assert_int_equal(reach_variable(&reach, &scenario, 16 + k), k < cases[i].reached);
            assert_int_equal(reach_variable(&reach, &scenario, 20 + k), k < cases[i].reached);
        }
    }
    scenario_fini(&scenario);
}

// A first point at 0 is reached by the lightest touch, and not without one.
static void spring_that_is_never_touched_reaches_nothing(void **state)
{
    (void)state;
    struct scenario scenario;
    read_scenario(&scenario, TURNING);
    struct reach reach = {.spring_count = 2};
    assert_int_equal(reach_points(&reach, &scenario, 0), 0);
    reach.deformation_max[0] = 1e-9;
    assert_int_equal(reach_points(&reach, &scenario, 0), 2);
    scenario_fini(&scenario);
}

// Where nobody looked, no point is called out of reach.
static void nothing_is_claimed_before_designs_are_simulated(void **state)
{
    (void)state;
    struct scenario scenario;
    read_scenario(&scenario, TURNING);
    const struct reach reach = {0};
    assert_true(reach_everything(&reach, &scenario));
    assert_int_equal(reach_beyond(&reach, &scenario, 1), 4);
    scenario_fini(&scenario);
}

// ---- against crashes ----

// Outcomes of one design.
static void simulate(const struct model *model, const double *values, double *outcomes)
{
    struct batch_scratch scratch = {0};
    batch_evaluate_designs(model, values, 1, &scratch, outcomes);
    batch_scratch_fini(&scratch);
}

static double uniform(GRand *random, double lower, double upper)
{
    return lower + g_rand_double(random) * (upper - lower);
}

// What the mark promises: whatever the force at points that are not reached, no crash changes. The
// forces there leave the design space by far; designs are drawn by another generator than sobox's.
static void forces_out_of_reach_change_no_crash(void **state)
{
    (void)state;
    struct scenario scenario;
    struct reach reach;
    read_scenario(&scenario, TURNING);
    const struct box *box = &scenario.design_space;
    reach_find(&reach, &scenario, box, 1);
    assert_in_range(reach_points(&reach, &scenario, 0), 3, 7);
    assert_in_range(reach_points(&reach, &scenario, 1), 2, 3);
    struct model *model = model_create(&scenario);
    const uint32_t outcomes = model_outcome_count(model);
    double *design = g_new(double, box->count), *one = g_new(double, outcomes),
           *two = g_new(double, outcomes);
    GRand *random = g_rand_new_with_seed(7);
    for (int i = 0; i < 500; i++) {
        for (uint32_t v = 0; v < box->count; v++)
            design[v] = uniform(random, box->lower[v], box->upper[v]);
        simulate(model, design, one);
        for (uint32_t v = 0; v < box->count; v++)
            if (!reach_variable(&reach, &scenario, v))
                design[v] = uniform(random, 0, 1e6);
        simulate(model, design, two);
        for (uint32_t o = 0; o < outcomes; o++)
            assert_float_equal(two[o], one[o], 1e-6 * (1 + fabs(one[o])));
    }
    g_rand_free(random);
    g_free(two);
    g_free(one);
    g_free(design);
    model_free(model);
    scenario_fini(&scenario);
}

// And the other way round: the last point of each spring that is reached does change some crash,
// here one of a car that is weak along, with lateral curves at some level.
static void force_at_the_last_point_in_reach_changes_a_crash(void **state)
{
    (void)state;
    struct scenario scenario;
    struct reach reach;
    read_scenario(&scenario, TURNING);
    const struct box *box = &scenario.design_space;
    reach_find(&reach, &scenario, box, 1);
    struct model *model = model_create(&scenario);
    double *design = g_new(double, box->count);
    double *one = g_new(double, model_outcome_count(model));
    double *two = g_new(double, model_outcome_count(model));
    const uint32_t last[] = {reach_points(&reach, &scenario, 0) - 1, // variables of F_x
                             2 * 8 + reach_points(&reach, &scenario, 1) - 1};
    for (size_t s = 0; s < G_N_ELEMENTS(last); s++) {
        double change = 0;
        for (double level = 0; level <= 1; level += 0.0625) {
            for (uint32_t v = 0; v < box->count; v++) {
                const bool lateral = scenario.variables[v].direction == SCENARIO_DIRECTION_Y;
                design[v] = box->lower[v] + lateral * level * (box->upper[v] - box->lower[v]);
            }
            simulate(model, design, one);
            design[last[s]] *= 2;
            simulate(model, design, two);
            change = fmax(change, fabs(two[OUTCOME_TRAVEL_X] - one[OUTCOME_TRAVEL_X]));
        }
        assert_true(change > 1e-6);
    }
    g_free(two);
    g_free(one);
    g_free(design);
    model_free(model);
    scenario_fini(&scenario);
}

// The deepest of a car that stops head-on is known without a simulation.
static void deepest_design_is_that_of_the_energy(void **state)
{
    (void)state;
    struct scenario scenario;
    struct reach reach;
    struct box box;
    read_scenario(&scenario, SAMPLE_STOPPED);
    sample_corridor(&box, &scenario.design_space);
    reach_find(&reach, &scenario, &box, 1);
    assert_int_equal(reach.spring_count, 2);
    assert_float_equal(reach.deformation_max[0], SAMPLE_STOPPED_DEEPEST, 5e-3);
    assert_true(reach.deformation_max[1] == 0);
    box_fini(&box);
    scenario_fini(&scenario);
}

// A design is built once and crashes in every case: the deepest case says what is reached. The one
// of twice the mass goes twice as deep.
static void deepest_case_counts(void **state)
{
    (void)state;
    char *yaml = g_strconcat(SAMPLE_STOPPED, "cases:\n  - {name: light}\n",
                             "  - {name: heavy, vehicle: {mass: 3300}}\n", NULL);
    struct scenario scenario;
    struct reach reach;
    struct box box;
    read_scenario(&scenario, yaml);
    assert_int_equal(scenario.case_count, 2);
    sample_corridor(&box, &scenario.design_space);
    reach_find(&reach, &scenario, &box, 1);
    assert_float_equal(reach.deformation_max[0], 2 * SAMPLE_STOPPED_DEEPEST, 5e-3);
    assert_int_equal(reach_points(&reach, &scenario, 0), 5);
    assert_int_equal(reach_points(&reach, &scenario, 1), 0);
    box_fini(&box);
    scenario_fini(&scenario);
    g_free(yaml);
}

// A light turntable whose only force is far from its COG is turned right round, whatever the
// design; the usual car is not. A design that turns in several cases is one design.
static void designs_that_turn_too_far_are_counted_once(void **state)
{
    (void)state;
    static const char SPUN[] = "name: spun\n"
                               "vehicle: {mass: 1650, yaw_inertia: 200, speed: 17.889}\n"
                               "barrier: {face_x: -2.08, edge_y: -0.455}\n"
                               "springs:\n"
                               "  - name: front\n"
                               "    position: [-0.83, -0.75]\n"
                               "    deformation: [0.0, 1.2]\n"
                               "    force_x: {lower: 400e3, upper: 450e3}\n"
                               "    force_y: {lower: 0, upper: 0}\n"
                               "response: any\n"
                               "firewall_distance: 0.25\n";
    static const struct {
        const char *cases;
        uint32_t turned;
    } expected[] = {
        {"", REACH_DESIGNS},
        {"cases: [{name: usual, vehicle.yaw_inertia: 3000}]\n", 0},
        {"cases: [{name: usual, vehicle.yaw_inertia: 3000}, {name: spun}, {name: again}]\n",
         REACH_DESIGNS},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(expected); i++) {
        char *yaml = g_strconcat(SPUN, expected[i].cases, NULL);
        struct scenario scenario;
        struct reach reach;
        read_scenario(&scenario, yaml);
        reach_find(&reach, &scenario, &scenario.design_space, 1);
        assert_int_equal(reach.turned, expected[i].turned);
        scenario_fini(&scenario);
        g_free(yaml);
    }
}

// The same scenario, box and seed find the same again, to the bit.
static void reach_is_found_again(void **state)
{
    (void)state;
    struct scenario scenario;
    struct reach once, again;
    read_scenario(&scenario, TURNING);
    reach_find(&once, &scenario, &scenario.design_space, 5);
    memset(&again, 0x5a, sizeof again);
    reach_find(&again, &scenario, &scenario.design_space, 5);
    assert_memory_equal(&again, &once, sizeof once);
    scenario_fini(&scenario);
}

// A formula has no springs.
static void formula_has_nothing_to_reach(void **state)
{
    (void)state;
    static const char FORMULA[] = "name: sections\n"
                                  "model: two_section_crash\n"
                                  "variables:\n"
                                  "- {name: F1, lower: 100e3, upper: 500e3}\n"
                                  "- {name: F2, lower: 200e3, upper: 600e3}\n"
                                  "- {name: mass, lower: 2000, upper: 2000}\n"
                                  "parameters: {d1: 0.3, d2: 0.3, speed: 15.6}\n"
                                  "constraints: {energy_remaining: {max: 0}}\n";
    struct scenario scenario;
    struct reach reach;
    read_scenario(&scenario, FORMULA);
    reach_find(&reach, &scenario, &scenario.design_space, 1);
    assert_int_equal(reach.spring_count, 0);
    assert_true(reach_variable(&reach, &scenario, 1));
    assert_true(reach_everything(&reach, &scenario));
    scenario_fini(&scenario);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(point_is_reached_when_the_one_before_is_passed),
        cmocka_unit_test(spring_that_is_never_touched_reaches_nothing),
        cmocka_unit_test(nothing_is_claimed_before_designs_are_simulated),
        cmocka_unit_test(forces_out_of_reach_change_no_crash),
        cmocka_unit_test(force_at_the_last_point_in_reach_changes_a_crash),
        cmocka_unit_test(deepest_design_is_that_of_the_energy),
        cmocka_unit_test(deepest_case_counts),
        cmocka_unit_test(designs_that_turn_too_far_are_counted_once),
        cmocka_unit_test(reach_is_found_again),
        cmocka_unit_test(formula_has_nothing_to_reach),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
