#include "worker/models/model.h"
#include "worker/models/small_overlap.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { POINTS = 3, OUTCOMES = OUTCOME_ENERGY_ABSORBED + 2 };

static struct scenario_spring spring;
static struct scenario scenario;

// A sedan with one pair of springs, put together by hand as the reader of scenarios would.
static int set_up(void **state)
{
    (void)state;
    spring = (struct scenario_spring){
        .name = "front",
        .position = {-0.83, -0.75},
        .length = 1.25,
        .point_count = POINTS,
        .deformation = {0.0, 0.6, 1.2},
    };
    for (int point = 0; point < POINTS; point++) {
        spring.force_upper[SCENARIO_DIRECTION_X][point] = 500e3;
        spring.force_upper[SCENARIO_DIRECTION_Y][point] = 160e3;
    }
    scenario = (struct scenario){
        .vehicle = {.mass = 1650.0, .yaw_inertia = 3000.0, .speed = 17.889},
        .barrier = {.face_x = -2.08, .edge_y = -0.455, .width = 1.15, .overlap = 0.455},
        .springs = &spring,
        .spring_count = 1,
        .simulation = {.duration = 0.150, .time_step = 1e-3},
    };
    return 0;
}

// Outcomes of the design in the middle, by the way of sobox-simulate.
static void simulate(double *outcomes)
{
    struct design design;
    design_init_place(&design, &scenario, DESIGN_CENTRE);
    struct kinematics_problem *problem =
        small_overlap_problem(&scenario, &design, (struct kinematics_omitted){0});
    double values[2 * POINTS];
    assert_int_equal(kinematics_value_count(problem), 2 * POINTS);
    small_overlap_values(&design, values);
    kinematics_evaluate(problem, 1, values, outcomes, 1);
    small_overlap_outcomes(scenario.barrier.overlap, 1, outcomes, 1);
    kinematics_free(problem);
    design_fini(&design);
}

// The outcomes of a block of designs in the middle are these, to the bit.
static void assert_outcomes(void (*evaluate)(const struct model *, uint32_t, const double *,
                                             double *),
                            const double *single)
{
    struct model *model = model_create(&scenario);
    assert_int_equal(model_variable_count(model), 2 * POINTS);
    assert_int_equal(model_outcome_count(model), OUTCOMES);
    static double values[2 * POINTS * MODEL_BLOCK];
    static double outcomes[OUTCOMES * MODEL_BLOCK];
    const uint32_t count = 37;
    for (int point = 0; point < POINTS; point++) {
        for (uint32_t i = 0; i < count; i++) {
            values[point * MODEL_BLOCK + i] = 250e3;
            values[(POINTS + point) * MODEL_BLOCK + i] = 80e3;
        }
    }
    evaluate(model, count, values, outcomes);
    for (int outcome = 0; outcome < OUTCOMES; outcome++) {
        for (uint32_t i = 0; i < count; i++) {
            assert_memory_equal(&outcomes[outcome * MODEL_BLOCK + i], &single[outcome],
                                sizeof *single);
        }
    }
    model_free(model);
}

// The search and the program for one design must get the same bits from the same forces; of the
// energies those that a constraint bounds, so that nothing is judged by what was left out.
static void model_and_single_design_agree(void **state)
{
    (void)state;
    double single[OUTCOMES];
    simulate(single);
    assert_true(single[OUTCOME_ENERGY_ABSORBED] > 0.0);
    assert_outcomes(model_evaluate, single);
    const double deepest = single[OUTCOME_ENERGY_ABSORBED + 1];
    assert_true(deepest > 0.0);
    single[OUTCOME_ENERGY_ABSORBED + 1] = 0.0; // no constraint bounds it
    struct scenario_constraint energy = {
        .outcome = OUTCOME_ENERGY_ABSORBED, .min = -INFINITY, .max = 300e3, .scale = 300e3};
    scenario.constraints = &energy;
    scenario.constraint_count = 1;
    assert_outcomes(model_evaluate_judged, single);
    energy.outcome = OUTCOME_ENERGY_BALANCE;
    assert_outcomes(model_evaluate_judged, single);
    single[OUTCOME_ENERGY_ABSORBED + 1] = deepest;
    single[OUTCOME_LATERAL_WORK] = single[OUTCOME_ENERGY_BALANCE] = 0.0;
    single[OUTCOME_ENERGY_ABSORBED] = 0.0;
    energy.outcome = OUTCOME_ENERGY_ABSORBED + 1; // the greatest deformation
    assert_outcomes(model_evaluate_judged, single);
    energy.outcome = OUTCOME_S_L;
    single[OUTCOME_ENERGY_ABSORBED + 1] = 0.0;
    assert_outcomes(model_evaluate_judged, single);
}

// Signs and units as outcome.h states them: forwards is positive, yaw in degrees, accelerations in
// g, lateral travels in overlaps.
static void outcomes_have_the_stated_signs_and_units(void **state)
{
    (void)state;
    double outcomes[OUTCOMES];
    simulate(outcomes);
    assert_true(outcomes[OUTCOME_TRAVEL_X] > 0.5 && outcomes[OUTCOME_TRAVEL_X] < 2.7);
    assert_true(outcomes[OUTCOME_TRAVEL_Y] > 0.0);
    assert_true(outcomes[OUTCOME_DELTA_VX] > 0.0);
    assert_true(outcomes[OUTCOME_DECEL_MAX_G] > 10.0 && outcomes[OUTCOME_DECEL_MAX_G] < 40.0);
    assert_true(outcomes[OUTCOME_DECEL_MEAN_G] > 5.0);
    assert_true(outcomes[OUTCOME_DECEL_MEAN_G] < outcomes[OUTCOME_DECEL_MAX_G]);
    assert_true(outcomes[OUTCOME_YAW_MAX_DEG] >= fabs(outcomes[OUTCOME_YAW_DEG]));
    // The A-pillar's lateral travel in metres is the COG's plus what the turn adds.
    const double yaw = outcomes[OUTCOME_YAW_DEG] * 0.017453292519943295;
    const double travel = outcomes[OUTCOME_TRAVEL_Y] - 0.83 * sin(yaw) - 0.75 * (cos(yaw) - 1.0);
    assert_true(fabs(outcomes[OUTCOME_ABWAP] * 0.455 - travel) < 1e-12);
    const double lost = 0.5 * 1650.0 * 17.889 * 17.889 - outcomes[OUTCOME_KINETIC_ENERGY];
    assert_true(fabs(outcomes[OUTCOME_ENERGY_ABSORBED] - lost) < 1e-6);
}

// Each word of the scenario reaches the kinematics: another integrator or profile is another
// result.
static void integrator_and_profile_are_passed_on(void **state)
{
    (void)state;
    double usual[OUTCOMES];
    double other[OUTCOMES];
    simulate(usual);
    scenario.simulation.integrator = SCENARIO_INTEGRATOR_RUNGE_KUTTA_4;
    simulate(other);
    assert_true(usual[OUTCOME_S_L] != other[OUTCOME_S_L]);
    assert_true(fabs(usual[OUTCOME_S_L] - other[OUTCOME_S_L]) < 0.05);
    scenario.simulation.integrator = SCENARIO_INTEGRATOR_VELOCITY_VERLET;
    spring.length = 1.30; // in contact from the start, where the schemes differ
    simulate(other);
    scenario.simulation.integrator = SCENARIO_INTEGRATOR_CENTRAL_DIFFERENCE;
    simulate(usual);
    assert_true(usual[OUTCOME_S_L] != other[OUTCOME_S_L]);
    scenario.barrier.profile = SCENARIO_PROFILE_ROUNDED;
    scenario.barrier.edge_radius = 0.15;
    simulate(other);
    assert_true(usual[OUTCOME_S_L] != other[OUTCOME_S_L]);
}

// A design from a file has its own points and an unload branch: the spring pushes the car back.
static void unload_branch_pushes_back(void **state)
{
    (void)state;
    static const char load[] = "spring,branch,deformation_m,force_x_N,force_y_N\n"
                               "front,load,0,400e3,0\nfront,load,1,400e3,0\n";
    static const char unload[] = "spring,branch,deformation_m,force_x_N,force_y_N\n"
                                 "front,load,0,400e3,0\nfront,load,1,400e3,0\n"
                                 "front,unload,0,100e3,0\nfront,unload,1,100e3,0\n";
    scenario.springs[0].position[1] = 0.0; // straight on: no yaw, no lateral force
    scenario.barrier.edge_y = 0.5;
    const char *const texts[] = {load, unload};
    double outcomes[2][OUTCOMES];
    for (int i = 0; i < 2; i++) {
        struct design design;
        struct error error;
        assert_int_equal(
            design_parse(&design, &scenario, "d.csv", texts[i], strlen(texts[i]), &error),
            STATUS_OK);
        struct kinematics_problem *problem =
            small_overlap_problem(&scenario, &design, (struct kinematics_omitted){0});
        double values[8];
        small_overlap_values(&design, values);
        kinematics_evaluate(problem, 1, values, outcomes[i], 1);
        kinematics_free(problem);
        design_fini(&design);
    }
    assert_true(outcomes[1][OUTCOME_DELTA_VX] > outcomes[0][OUTCOME_DELTA_VX] + 1.0);
}

// The rule of reloading reaches the kinematics. The spring stops the car and then draws it back on
// the barrier: by the thesis's rule it resists at once with its full force, crushed only beyond the
// deformation at which the car stood.
static void reloading_is_passed_on(void **state)
{
    (void)state;
    static const char text[] = "spring,branch,deformation_m,force_x_N,force_y_N\n"
                               "front,load,0,400e3,0\nfront,load,1,400e3,0\n"
                               "front,unload,0,-200e3,0\nfront,unload,1,-200e3,0\n";
    scenario.springs[0].position[1] = 0.0; // straight on: no yaw, no lateral force
    scenario.barrier.edge_y = 0.5;
    double outcomes[2][OUTCOMES];
    struct design design;
    struct error error;
    assert_int_equal(design_parse(&design, &scenario, "d.csv", text, strlen(text), &error),
                     STATUS_OK);
    for (int rule = 0; rule < 2; rule++) {
        scenario.simulation.reloading = (enum scenario_reloading)rule;
        struct kinematics_problem *problem =
            small_overlap_problem(&scenario, &design, (struct kinematics_omitted){0});
        double values[8];
        small_overlap_values(&design, values);
        kinematics_evaluate(problem, 1, values, outcomes[rule], 1);
        kinematics_free(problem);
    }
    design_fini(&design);
    print_message("s_L %.4f and %.4f m\n", outcomes[0][OUTCOME_S_L], outcomes[1][OUTCOME_S_L]);
    assert_true(outcomes[SCENARIO_RELOADING_THESIS][OUTCOME_TRAVEL_X] !=
                outcomes[SCENARIO_RELOADING_CRUSHED][OUTCOME_TRAVEL_X]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(model_and_single_design_agree, set_up),
        cmocka_unit_test_setup(outcomes_have_the_stated_signs_and_units, set_up),
        cmocka_unit_test_setup(integrator_and_profile_are_passed_on, set_up),
        cmocka_unit_test_setup(reloading_is_passed_on, set_up),
        cmocka_unit_test_setup(unload_branch_pushes_back, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
