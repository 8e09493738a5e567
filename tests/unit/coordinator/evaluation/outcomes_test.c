#include "coordinator/evaluation/outcomes.h"
#include "sample_scenario.h"

#include <math.h>

static struct scenario scenario;

static int set_up(void **state)
{
    (void)state;
    static const char text[] = "name: crash\n"
                               "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                               "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                               "springs:\n"
                               "  - name: front\n"
                               "    position: [-0.83, -0.75]\n"
                               "    deformation: [0.0, 1.2]\n"
                               "    force_x: {lower: 0, upper: 450e3}\n"
                               "    force_y: {lower: 0, upper: 250e3}\n"
                               "response: any\n"
                               "firewall_distance: 0.25\n"
                               "constraints: {yaw_deg: {min: -20, max: 20}}\n";
    struct error error = {0};
    return scenario_read_text(&scenario, "crash", text, strlen(text), NULL, 0, &error) == STATUS_OK
               ? 0
               : -1;
}

static int tear_down(void **state)
{
    (void)state;
    scenario_fini(&scenario);
    return 0;
}

// Three designs: good; violating both constraints; broken down in an outcome that nobody asks for.
static void assert_written(const char *names, const struct designs *designs, uint64_t first,
                           const char *expected)
{
    enum { DESIGNS = 3 };
    const uint32_t count = scenario_outcome_count(&scenario);
    double *values = g_new0(double, DESIGNS *(size_t)count);
    const uint32_t s_l = scenario_outcome_find(&scenario, "s_L_min");
    const uint32_t yaw = scenario_outcome_find(&scenario, "yaw_deg");
    values[s_l] = 0.5;
    values[count + s_l] = 0.125;
    values[count + yaw] = -30;
    values[2 * count + s_l] = 0.5;
    values[2 * count + scenario_outcome_find(&scenario, "travel_x")] = NAN;
    struct outcomes_layout layout;
    struct outcomes_sums sums = {0};
    assert_int_equal(outcomes_layout_read(&layout, &scenario, names, NULL), STATUS_OK);
    GString *text = g_string_new(NULL);
    outcomes_header(&layout, text);
    outcomes_rows(&layout, designs, first, values, text, &sums);
    assert_string_equal(text->str, expected);
    assert_int_equal(sums.good, 1);
    assert_int_equal(sums.non_finite, 1);
    g_string_free(text, TRUE);
    outcomes_layout_fini(&layout);
    g_free(values);
}

// What is asked for, in the order in which it is, and all constraints that stand in the way.
static void rows_say_what_came_of_each_design(void **state)
{
    (void)state;
    const char *ids[] = {"a,", "bc,", "d,"};
    uint32_t id_sizes[] = {1, 2, 1};
    assert_written("yaw_deg,s_L_min",
                   &(struct designs){.count = 3, .ids = ids, .id_sizes = id_sizes}, 1,
                   "id,yaw_deg,s_L_min,good,violated\n"
                   "a,0,0.5,1,\n"
                   "bc,-30,0.125,0,s_L_min;yaw_deg\n"
                   "d,0,0.5,0,\n");
}

// Designs without names are numbered over the whole table.
static void designs_without_ids_are_numbered(void **state)
{
    (void)state;
    assert_written("travel_x", &(struct designs){.count = 3}, 16385,
                   "id,travel_x,good,violated\n"
                   "16385,0,1,\n"
                   "16386,0,0,s_L_min;yaw_deg\n"
                   "16387,nan,0,\n");
}

// A name that is none is told with one that is; nothing at all is no choice.
static void wrong_names_are_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {"s_l", "s_L,,yaw_deg", "", "s_L,s_L", "s_L;yaw_deg"};
    for (size_t i = 0; i < G_N_ELEMENTS(wrong); i++) {
        struct outcomes_layout layout;
        struct error error = {0};
        assert_int_equal(outcomes_layout_read(&layout, &scenario, wrong[i], &error),
                         STATUS_INVALID);
        assert_complaint(&error, "--outcomes ");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_say_what_came_of_each_design),
        cmocka_unit_test(designs_without_ids_are_numbered),
        cmocka_unit_test(wrong_names_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
