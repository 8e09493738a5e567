// The scenarios that come with the program.
#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const char *const names[] = {
    "sedan-two-springs", "sedan-ten-springs",      "suv-two-springs",
    "suv-ten-springs",   "sports-car-two-springs", "sports-car-ten-springs",
};
static const char *const responses[] = {"response=any", "response=rotating",
                                        "response=glancing_off"};

static struct scenario read_shipped(const char *name, const char *override)
{
    char *path = g_strdup_printf(SOBOX_SOURCE_DIR "/deploy/scenarios/%s.yaml", name);
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_file(&scenario, path, &override, override != NULL, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    g_free(path);
    return scenario;
}

// All 18 cases are accepted, named after their file, and of the size their name promises.
static void shipped_scenarios_are_valid(void **state)
{
    (void)state;
    for (size_t i = 0; i < G_N_ELEMENTS(names); i++) {
        for (size_t j = 0; j < G_N_ELEMENTS(responses); j++) {
            struct scenario scenario = read_shipped(names[i], responses[j]);
            bool two = g_str_has_suffix(names[i], "two-springs");
            assert_string_equal(scenario.name, names[i]);
            assert_int_equal(scenario.spring_count, two ? 1 : 5);
            assert_int_equal(scenario.design_space.count, two ? 18 : 30);
            assert_int_equal(scenario.response, j);
            scenario_fini(&scenario);
        }
    }
}

// The places follow from the car: bumper at the face, a quarter of the width overlapping, every
// spring between the barrier's edge and the car's side, every component crushed before its rigid
// end is reached. A slip of a digit in a file would break one of these.
static void shipped_geometry_is_a_small_overlap(void **state)
{
    (void)state;
    for (size_t i = 0; i < G_N_ELEMENTS(names); i++) {
        struct scenario scenario = read_shipped(names[i], NULL);
        // A quarter of the width overlaps, so the edge lies half way from the COG to the side.
        double edge = scenario.barrier.edge_y, side = 2 * edge;
        // The A-pillar stands inside the side; 1 says that it has passed the barrier's end.
        double overlap = edge - scenario.springs[0].position[1];
        assert_true(fabs(scenario.barrier.overlap - overlap) < 1e-9);
        for (uint32_t s = 0; s < scenario.spring_count; s++) {
            const struct scenario_spring *spring = &scenario.springs[s];
            assert_true(spring->position[1] < edge);
            assert_true(spring->position[1] > side);
            assert_true(spring->deformation[spring->point_count - 1] < spring->length);
        }
        scenario_fini(&scenario);
    }
}

// Every problem with a known answer is accepted and named after its file, and its model is the one
// that the file's name promises.
static void shipped_benchmarks_are_valid(void **state)
{
    (void)state;
    GError *reason = NULL;
    GDir *folder = g_dir_open(SOBOX_SOURCE_DIR "/deploy/scenarios/benchmarks", 0, &reason);
    assert_non_null(folder);
    uint32_t count = 0;
    for (const char *file; (file = g_dir_read_name(folder)) != NULL; count++) {
        assert_true(g_str_has_suffix(file, ".yaml"));
        char *name = g_strndup(file, strlen(file) - strlen(".yaml"));
        char *path = g_strconcat("benchmarks/", name, NULL);
        struct scenario scenario = read_shipped(path, NULL);
        assert_string_equal(scenario.name, name);
        g_strdelimit(name, "-", '_');
        assert_true(g_str_has_prefix(name, scenario_model_name(scenario.model)));
        assert_true(box_free_count(&scenario.design_space) == scenario.design_space.count);
        scenario_fini(&scenario);
        g_free(path);
        g_free(name);
    }
    assert_int_equal(count, 13);
    g_dir_close(folder);
}

// The wagon is the sedan's structure in a heavier car that reaches further ahead of its COG.
static void shipped_cases_share_their_front(void **state)
{
    (void)state;
    struct scenario scenario = read_shipped("sedan-and-wagon", NULL);
    struct scenario sedan = read_shipped("sedan-two-springs", NULL);
    assert_int_equal(scenario.case_count, 2);
    assert_true(box_equal(&scenario.design_space, &sedan.design_space));
    const struct scenario *base = &scenario.cases[0], *wagon = &scenario.cases[1];
    assert_memory_equal(&base->vehicle, &sedan.vehicle, sizeof sedan.vehicle);
    assert_true(wagon->vehicle.mass > base->vehicle.mass);
    // From the A-pillar to the face it is the same front.
    assert_true(fabs((wagon->springs[0].position[0] - wagon->barrier.face_x) -
                     (base->springs[0].position[0] - base->barrier.face_x)) < 1e-9);
    assert_true(wagon->springs[0].length == base->springs[0].length);
    scenario_fini(&sedan);
    scenario_fini(&scenario);
}

// At their step of 1 ms only event Verlet has the converged crash, which is what a car that comes
// with the program should show; worker/kinematics/README.md has the figures.
static void shipped_cars_are_simulated_converged(void **state)
{
    (void)state;
    static const char *const derived[] = {"sedan-and-wagon"};
    for (size_t i = 0; i < G_N_ELEMENTS(names) + G_N_ELEMENTS(derived); i++) {
        struct scenario scenario = read_shipped(
            i < G_N_ELEMENTS(names) ? names[i] : derived[i - G_N_ELEMENTS(names)], NULL);
        for (uint32_t j = 0; j <= scenario.case_count; j++) {
            const struct scenario *one = j == 0 ? &scenario : &scenario.cases[j - 1];
            assert_int_equal(one->simulation.integrator, SCENARIO_INTEGRATOR_EVENT_VERLET);
            assert_true(one->simulation.time_step <= 1e-3);
        }
        scenario_fini(&scenario);
    }
}

// The first file shows every key, so leaving the optional ones out changes nothing.
static void the_complete_example_shows_the_defaults(void **state)
{
    (void)state;
    struct scenario shown = read_shipped("sedan-two-springs", NULL);
    struct scenario initial;
    scenario_init(&initial);
    assert_int_equal(initial.simulation.integrator, SCENARIO_INTEGRATOR_EVENT_VERLET);
    assert_int_equal(initial.simulation.reloading, SCENARIO_RELOADING_CRUSHED);
    assert_memory_equal(&shown.simulation, &initial.simulation, sizeof initial.simulation);
    assert_memory_equal(&shown.search, &initial.search, sizeof initial.search);
    assert_true(shown.barrier.width == initial.barrier.width);
    assert_true(shown.barrier.edge_radius == initial.barrier.edge_radius);
    assert_int_equal(shown.barrier.profile, initial.barrier.profile);
    assert_int_equal(shown.model, initial.model);
    scenario_fini(&initial);
    scenario_fini(&shown);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shipped_scenarios_are_valid),
        cmocka_unit_test(shipped_geometry_is_a_small_overlap),
        cmocka_unit_test(shipped_benchmarks_are_valid),
        cmocka_unit_test(shipped_cases_share_their_front),
        cmocka_unit_test(shipped_cars_are_simulated_converged),
        cmocka_unit_test(the_complete_example_shows_the_defaults),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
