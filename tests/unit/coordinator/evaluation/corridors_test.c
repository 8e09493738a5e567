#include "coordinator/evaluation/corridors.h"
#include "sample_scenario.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <string.h>

static const char car[] = "name: car\n"
                          "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                          "barrier: {face_x: -2.08, edge_y: -0.455}\n"
                          "springs:\n"
                          "  - name: front\n"
                          "    position: [-0.83, -0.75]\n"
                          "    deformation: [0.0, 0.6]\n"
                          "    force_x: {lower: 0, upper: 450e3}\n"
                          "    force_y: {lower: 0, upper: 250e3}\n"
                          "response: any\n"
                          "firewall_distance: 0.25\n";

static char folder[] = "/tmp/corridors-test-XXXXXX";
static char *path;
static struct scenario variables, springs;

static int set_up(void **state)
{
    (void)state;
    sample_scenario(&variables);
    struct error error = {0};
    if (scenario_read_text(&springs, "car", car, strlen(car), NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_non_null(g_mkdtemp(folder));
    path = g_build_filename(folder, "corridors.csv", NULL);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    g_unlink(path);
    g_rmdir(folder);
    g_free(path);
    scenario_fini(&variables);
    scenario_fini(&springs);
    return 0;
}

static void write_table(const char *text)
{
    assert_true(g_file_set_contents(path, text, -1, NULL));
}

static void assert_box_read(const struct scenario *scenario, const char *from, const double *lower,
                            const double *upper)
{
    struct box box;
    struct error error = {0};
    if (corridors_read(&box, scenario, from, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_int_equal(box.count, scenario->design_space.count);
    assert_memory_equal(box.lower, lower, box.count * sizeof *lower);
    assert_memory_equal(box.upper, upper, box.count * sizeof *upper);
    box_fini(&box);
}

// What a spreadsheet may do to the table: other columns, another order of rows and columns, quotes,
// rounded numbers. The run folder stands for the table in it.
static void an_edited_table_is_a_box(void **state)
{
    (void)state;
    write_table("note,upper_N,lower_N,deformation_m,direction,spring\r\n"
                ",450000.000000001,45e3,0.6000000000001,x,\"front\"\r\n"
                "softer,80e3,0,0,x,front\r\n"
                ",31e3,30e3,0,y,front\r\n"
                "\r\n"
                ",250e3,0,0.6,y,front\r\n");
    static const double lower[] = {0, 45e3, 30e3, 0}, upper[] = {80e3, 450e3, 31e3, 250e3};
    assert_box_read(&springs, path, lower, upper);
    assert_box_read(&springs, folder, lower, upper);
}

// Variables of other models stand by their names; one that is fixed needs no row.
static void variables_stand_by_their_names(void **state)
{
    (void)state;
    write_table("search,spring,direction,deformation_m,lower_N,upper_N\n"
                "0,b,,,-0.5,0.5\n"
                "0,a,,,0,1e-1\n");
    assert_box_read(&variables, path, (const double[]){0, -0.5, 0.25},
                    (const double[]){0.1, 0.5, 0.25});
}

// The text of a box leads back to the same bits.
static void the_text_is_exact(void **state)
{
    (void)state;
    double lower[] = {0.1, -1.0 / 3, 0.25}, upper[] = {0.2, 2.0 / 3, 0.25};
    g_autofree char *text =
        corridors_text(&(struct box){.count = 3, .lower = lower, .upper = upper});
    g_autofree char *override = g_strconcat("search.box=", text, NULL);
    const char *overrides[] = {override};
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_text(&scenario, "s", variables.text, variables.text_size, overrides, 1,
                           &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_memory_equal(scenario.search.hold.lower, lower, sizeof lower);
    assert_memory_equal(scenario.search.hold.upper, upper, sizeof upper);
    scenario_fini(&scenario);
}

// Whatever is wrong is told with its place.
static void what_is_wrong_is_pointed_at(void **state)
{
    (void)state;
    static const struct {
        const char *rows, *complaint;
    } cases[] = {
        {"", "corridors.csv:1:1: expected the columns"},
        {"spring,direction,deformation_m,lower_N,upper_N\n",
         "corridors.csv:1:1: expected a row for every variable"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0,0\n",
         "corridors.csv:2:1: expected 5 cells as in the header, found 4"},
        {"spring;direction\nfront;x\n", "corridors.csv:1:1: expected the columns"},
        {"spring,direction,deformation_m,lower_N\nfront,x,0,1\n",
         "corridors.csv:1:1: expected the columns spring,direction,deformation_m,lower_N,upper_N "
         "with commas between them; 'upper_N' is missing"},
        {"spring,direction,deformation_m,lower_N,upper_N\nrear,x,0,0,1\n",
         "corridors.csv:2:1: expected the name of a spring of the scenario, found 'rear'"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,z,0,0,1\n",
         "corridors.csv:2:7: expected x or y, found 'z'"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0.3,0,1\n",
         "corridors.csv:2:9: expected a deformation at which the scenario has a point of this "
         "spring [m], found '0.3'"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0,0,1\nfront,x,0,0,1\n",
         "corridors.csv:3:1: expected each corridor's place once, found 'front'"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0,2,1\n",
         "corridors.csv:2:13: front.force_x[0]: expected an upper bound at least at the lower one "
         "of 2, found 1"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0,0,451e3\n",
         "corridors.csv:2:13: front.force_x[0]: expected a bound inside the design space, 0 to "
         "450000, found 451e3"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0,nan,1\n",
         "corridors.csv:2:11: expected a number, found 'nan'"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0,0,1\n",
         "corridors.csv:1:1: expected a row for every variable; that of front.force_x[1] is "
         "missing"},
        {"spring,direction,deformation_m,lower_N,upper_N\nfront,x,0,1,1\nfront,x,0.6,1,1\n"
         "front,y,0,1,1\nfront,y,0.6,1,1\n",
         "corridors.csv:1:1: every corridor is a single value"},
        {"search,spring,direction,deformation_m,lower_N,upper_N\n0,front,x,0,0,1\n1,front,y,0,0,"
         "1\n",
         "corridors.csv:3:1: expected the corridors of one search alone, as in the first row, "
         "found '1'"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        write_table(cases[i].rows);
        struct box box;
        struct error error = {0};
        assert_int_equal(corridors_read(&box, &springs, path, &error), STATUS_INVALID);
        assert_null(box.lower);
        const char *complaint = strstr(error.text, "corridors.csv:");
        if (complaint == NULL || !g_str_has_prefix(complaint, cases[i].complaint))
            fail_msg("expected \"%s\", found \"%s\"", cases[i].complaint, error.text);
    }
    struct box box;
    struct error error = {0};
    assert_int_equal(corridors_read(&box, &springs, "/nowhere/box.csv", &error), STATUS_INVALID);
    assert_complaint(&error, "/nowhere/box.csv:1:1: expected a file that can be read");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_edited_table_is_a_box),
        cmocka_unit_test(variables_stand_by_their_names),
        cmocka_unit_test(the_text_is_exact),
        cmocka_unit_test(what_is_wrong_is_pointed_at),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
