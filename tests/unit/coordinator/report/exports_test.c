#include "sample_run.h"

#include "coordinator/report/number.h"
#include "coordinator/report/reach.h"
#include "coordinator/report/report.h"

#include <float.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>

static void write_reports(const char *folder)
{
    struct error error = {0};
    if (report_write(folder, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

// result.json, to be released with json_decref().
static json_t *read_json(const char *folder)
{
    char *text = file_text(folder, "result.json");
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    g_free(text);
    return root;
}

static void assert_file(const char *folder, const char *name, const char *expected)
{
    char *text = file_text(folder, name);
    assert_string_equal(text, expected);
    g_free(text);
}

static char *printed(const char *folder)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    struct error error = {0};
    if (report_print(folder, &(struct report_table){.bounds = true}, out, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    fclose(out);
    return text;
}

// ---- numbers ----

// Thousands are grouped from the right, the greatest number fits.
static void counts_are_grouped(void **state)
{
    (void)state;
    char text[NUMBER_SIZE];
    assert_string_equal(number_count(0, text), "0");
    assert_string_equal(number_count(999, text), "999");
    assert_string_equal(number_count(1000, text), "1,000");
    assert_string_equal(number_count(UINT64_MAX, text), "18,446,744,073,709,551,615");
}

// ---- files ----

// The two tables hold exactly what the journal holds, one row a variable and one a step.
static void csv_tables_are_golden(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    write_reports(*state);
    assert_file(*state, "corridors.csv",
                "search,spring,direction,deformation_m,lower_N,upper_N,design_lower_N,"
                "design_upper_N,reached\n"
                "0,front,x,0,15000,45000,0,60000,yes\n"
                "0,front,x,1.2,112500,337500,0,450000,yes\n"
                "0,front,y,0,62500,187500,0,250000,yes\n"
                "0,front,y,1.2,62500,187500,0,250000,yes\n"
                "0,rail,x,0.1,1000,1000,1000,1000,yes\n"
                "0,rail,x,0.9,3500,6500,2000,8000,yes\n"
                "0,rail,y,0.1,1000,3000,0,4000,yes\n"
                "0,rail,y,0.9,1000,3000,0,4000,yes\n");
    assert_file(*state, "history.csv",
                "search,phase,step,samples,good,growth,log_volume\n"
                "0,seek,0,8,6,0,0\n"
                "0,explore,1,8,6,0.1,-4.5\n");
}

// The keys that other programs read, with the values of the journal.
static void json_holds_the_result(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    write_reports(*state);
    char *json = file_text(*state, "result.json");
    static const char *const PARTS[] = {
        "\"name\": \"sample\"",
        "\"version\": \"1.2.3\"",
        "\"status\": \"done\"",
        "\"seed\": 1",
        "\"name\": \"rail.force_x[1]\"",
        "\"spring\": \"rail\"",
        "\"direction\": \"x\"",
        "\"deformation_m\": 0.90000000000000002",
        "\"log_volume\": -4.5",
        "\"samples\": 1000",
        "\"bad\": 0",
        "\"estimate\": 1.0",
        "\"lower95\": 0.99709000000000003",
        "\"evaluations\": 1016",
        "\"steps\": 2",
        "\"wall_s\": 0.25",
        "\"non_finite\": 0",
    };
    for (size_t i = 0; i < G_N_ELEMENTS(PARTS); i++)
        assert_contains(json, PARTS[i]);
    struct digest digest = digest_of("sample", 6);
    char hex[DIGEST_HEX_SIZE];
    assert_contains(json, digest_hex(&digest, hex));
    g_free(json);
}

// Reports can be made of a run that is not finished: they show the box sampled last, and do not
// claim a purity or a digest that nobody has computed.
static void unfinished_run_shows_its_last_box(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_UNFINISHED);
    write_reports(*state);
    char *json = file_text(*state, "result.json");
    assert_contains(json, "\"status\": \"interrupted\"");
    assert_contains(json, "\"purity\": null");
    assert_contains(json, "\"digest\": null");
    assert_contains(json, "\"evaluations\": 16");
    g_free(json);
    char *csv = file_text(*state, "corridors.csv");
    assert_contains(csv, "0,front,x,0,15000,45000,0,60000,yes\n");
    g_free(csv);
    char *table = printed(*state);
    assert_contains(table, "interrupted, can be resumed");
    assert_contains(table, "not certified yet");
    g_free(table);
}

// Before the first step there is no box at all.
static void untouched_run_has_no_corridors(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_UNTOUCHED);
    write_reports(*state);
    assert_file(*state, "corridors.csv",
                "search,spring,direction,deformation_m,lower_N,upper_N,design_lower_N,"
                "design_upper_N,reached\n");
    char *json = file_text(*state, "result.json");
    assert_contains(json, "\"corridor\": null");
    assert_contains(json, "\"log_volume\": null");
    g_free(json);
    g_free(printed(*state));
}

// When nothing is good, the box that came with the result means nothing and must not be shown.
static void no_good_design_names_the_obstacle(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_NO_GOOD_DESIGN);
    write_reports(*state);
    char *json = file_text(*state, "result.json");
    assert_contains(json, "\"status\": \"no_good_design\"");
    assert_contains(json, "\"blocking_constraint\": \"s_L\"");
    assert_contains(json, "\"corridor\": null");
    g_free(json);
    char *table = printed(*state);
    assert_contains(table, "no good design found");
    assert_contains(table, "s_L_min >= 0.25 m: violated worst by 8 of 8 samples");
    assert_null(strstr(table, "F_x"));
    g_free(table);
}

// A variable that is held to one value has no width, and counts no more in the log-volume of a run
// that goes on than in that of one that is done.
static void held_variable_leaves_the_log_volume_finite(void **state)
{
    char *yaml = g_strconcat(SAMPLE_SCENARIO,
                             "search: {hold: {lower: {\"front.force_x[0]\": 30e3},\n"
                             "                upper: {\"front.force_x[0]\": 30e3}}}\n",
                             NULL);
    sample_run(*state, yaml, 1, SAMPLE_UNFINISHED);
    char *table = printed(*state);
    assert_contains(table, "log-volume   -4.159 "); // six free variables, half of each
    g_free(table);
    g_free(yaml);
}

// Each search of a run has its rows.
static void searches_of_a_sweep_are_told_apart(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 3, SAMPLE_DONE);
    write_reports(*state);
    char *csv = file_text(*state, "corridors.csv");
    assert_contains(csv, "\n0,rail,y,0.9,");
    assert_contains(csv, "\n2,rail,y,0.9,");
    g_free(csv);
    char *table = printed(*state);
    assert_contains(table, "3 searches");
    g_free(table);
}

// The rows of summary.csv: what each case is, how it ended, and its corridors; what is not known is
// an empty cell.
static void summary_has_a_row_a_case(void **state)
{
    sample_sweep(*state);
    write_reports(*state);
    char *csv = file_text(*state, "summary.csv");
    char **lines = g_strsplit(csv, "\n", -1);
    assert_int_equal(g_strv_length(lines), 5);
    assert_true(g_str_has_prefix(
        lines[0], "case,vehicle.mass,springs.0.force_x.upper,status,log_volume,purity_estimate,"
                  "purity_lower95,evaluations,wall_s,digest,front.force_x[0].lower,"
                  "front.force_x[0].upper,"));
    assert_true(g_str_has_prefix(
        lines[1], "\"mass=1,upper=#1\",1,\"[1, 2]\",done,-4.5,1,0.99709,1016,0.25,"));
    assert_contains(lines[1], ",15000,45000,");
    assert_true(
        g_str_has_prefix(lines[2], "\"mass=2,upper=#1\",2,\"[1, 2]\",no_good_design,,,,8,"));
    assert_true(g_str_has_suffix(lines[2], ",,,,,,,,,,,,,,,,"));
    assert_true(g_str_has_prefix(lines[3], "\"mass=3,upper=#1\",3,\"[1, 2]\",waiting,,,,0,0,,,"));
    g_strfreev(lines);
    g_free(csv);
    char *json = file_text(*state, "result.json");
    assert_contains(json, "\"springs.0.force_x.upper\": \"[1, 2]\"");
    g_free(json);
}

// Points that no design of the box reaches are told as such, for each point and each spring.
static void exports_tell_what_no_design_reaches(void **state)
{
    sample_run(*state, SAMPLE_STOPPED, 1, SAMPLE_DONE);
    write_reports(*state);
    char *csv = file_text(*state, "corridors.csv");
    assert_contains(csv, "\n0,front,x,0.75,500000,700000,400000,800000,yes\n"
                         "0,front,x,1,500000,700000,400000,800000,no\n");
    assert_contains(csv, "\n0,front,y,0.75,0,0,0,0,yes\n0,front,y,1,0,0,0,0,no\n");
    assert_contains(csv, "\n0,idle,x,0,20000,60000,0,80000,no\n");
    g_free(csv);
    json_t *root = read_json(*state);
    const json_t *search = json_array_get(json_object_get(root, "searches"), 0);
    const json_t *reach = json_object_get(search, "reach");
    const json_t *front = json_array_get(json_object_get(reach, "springs"), 0);
    assert_int_equal(json_integer_value(json_object_get(reach, "designs")), REACH_DESIGNS);
    json_int_t designs = 0;
    const char *kind;
    json_t *count;
    json_object_foreach(json_object_get(reach, "kinds"), kind, count) designs +=
        json_integer_value(count);
    assert_int_equal(designs, REACH_DESIGNS);
    assert_float_equal(json_real_value(json_object_get(front, "deformation_max_m")),
                       SAMPLE_STOPPED_DEEPEST, 5e-3);
    assert_int_equal(json_integer_value(json_object_get(front, "points_reached")), 4);
    static const bool reached[] = {1, 1, 1, 1, 0, 1, 1, 1, 1, 0, 0, 0, 0, 0};
    const json_t *variables = json_object_get(search, "variables");
    assert_int_equal(json_array_size(variables), G_N_ELEMENTS(reached));
    for (size_t i = 0; i < G_N_ELEMENTS(reached); i++)
        assert_true(json_is_boolean(json_object_get(json_array_get(variables, i), "reached")) &&
                    json_is_true(json_object_get(json_array_get(variables, i), "reached")) ==
                        reached[i]);
    json_decref(root);
}

// A formula has no springs, and a search without a box no designs: of neither anything is claimed.
static void nothing_is_told_of_reach_where_there_is_none(void **state)
{
    sample_run(*state, SAMPLE_STOPPED, 1, SAMPLE_NO_GOOD_DESIGN);
    write_reports(*state);
    json_t *root = read_json(*state);
    const json_t *search = json_array_get(json_object_get(root, "searches"), 0);
    assert_true(json_is_null(json_object_get(search, "reach")));
    const json_t *variable = json_array_get(json_object_get(search, "variables"), 0);
    assert_null(json_object_get(variable, "reached"));
    json_decref(root);
}

// A file that cannot be replaced is an error, and what stood there stays as it was.
static void export_that_fails_leaves_the_old_one(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *blocked = g_build_filename(*state, "history.csv", NULL);
    assert_int_equal(mkdir(blocked, 0777), 0);
    struct error error = {0};
    assert_int_equal(report_write(*state, &error), STATUS_IO);
    assert_contains(error.text, "history.csv");
    GDir *dir = g_dir_open(*state, 0, NULL);
    for (const char *name; (name = g_dir_read_name(dir)) != NULL;)
        assert_true(g_str_equal(name, "history.csv") || g_str_equal(name, "corridors.csv") ||
                    g_str_equal(name, "run.db"));
    g_dir_close(dir);
    g_free(blocked);
}

// ---- the table ----

// The complete table as a person sees it, within 80 columns.
static void table_is_golden(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *table = printed(*state);
    char *files = g_strdup_printf("files        %s/run.db\n", (const char *)*state);
    char *expected =
        g_strconcat("sample, response any\n"
                    "\n"
                    "front\n"
                    " deformation   F_x lower     upper    share   F_y lower     upper    share\n"
                    "         [m]        [kN]      [kN]      [%]        [kN]      [kN]      [%]\n"
                    "       0.000        15.0      45.0     50.0        62.5     187.5     50.0\n"
                    "       1.200       112.5     337.5     50.0        62.5     187.5     50.0\n"
                    "\n"
                    "rail\n"
                    " deformation   F_x lower     upper    share   F_y lower     upper    share\n"
                    "         [m]        [kN]      [kN]      [%]        [kN]      [kN]      [%]\n"
                    "       0.100       1.000     1.000    fixed       1.000     3.000     50.0\n"
                    "       0.900       3.500     6.500     50.0       1.000     3.000     50.0\n"
                    "\n"
                    "status       done: the corridors keep what was asked for\n"
                    "warning      springs.0.force_x.upper: energy that the springs can absorb over "
                    "the car's kinetic energy is 0.867, expected 1 to 100: below 1 the structure "
                    "cannot stop the car; the springs absorb at most 228.9 kJ, the car has 264.0 "
                    "kJ\n"
                    "promise      every: the wanted share of each kind below is good, and an "
                    "adversarial\n"
                    "             search with fresh starts found no bad design\n"
                    "purity       of 1,000 fresh designs of each kind, with 95 % confidence\n"
                    "  points     1.0000  at least 0.9970   every force on its own\n"
                    "log-volume   -4.500 (0 is the whole design space)\n"
                    "simulated    1,016 designs in 2 steps, 0.25 s, 4,064 designs/s\n",
                    files, NULL);
    assert_string_equal(table, expected);
    g_free(expected);
    g_free(files);
    g_free(table);
}

// Rows that no design reaches bear a mark, and the table says below what it means.
static void table_marks_what_no_design_reaches(void **state)
{
    sample_run(*state, SAMPLE_STOPPED, 1, SAMPLE_DONE);
    char *table = printed(*state);
    assert_contains(table,
                    "\n       0.750       500.0     700.0     50.0         0.0       0.0    fixed\n"
                    "*      1.000       500.0     700.0     50.0         0.0       0.0    fixed\n");
    assert_contains(
        table, "\n*      0.000       20.00     60.00     50.0       20.00     60.00     50.0\n");
    assert_contains(table,
                    "\n* none of 2,048 simulated designs of these corridors presses the spring so\n"
                    "  far that the force here plays a part\n");
    g_free(table);
}

// A car that turns beyond 90 degrees is told in the table and in result.json: here a turntable that
// every design turns right round.
static void designs_that_turn_too_far_are_told(void **state)
{
    static const char SPUN[] = "name: spun\n"
                               "vehicle: {mass: 1650, yaw_inertia: 200, speed: 17.889}\n"
                               "barrier: {face_x: -2.08, edge_y: -0.455}\n"
                               "springs:\n"
                               "  - name: front\n"
                               "    position: [-0.83, -0.75]\n"
                               "    deformation: [0.0, 1.2]\n"
                               "    force_x: {lower: 300e3, upper: 500e3}\n"
                               "    force_y: {lower: 0, upper: 0}\n"
                               "response: any\n"
                               "firewall_distance: 0.25\n";
    sample_run(*state, SPUN, 1, SAMPLE_DONE);
    write_reports(*state);
    char *table = printed(*state);
    assert_contains(table,
                    "\nturned       2,048 of 2,048 simulated designs turn beyond 90 degrees, where "
                    "no\n             spring meets the barrier: ");
    g_free(table);
    json_t *root = read_json(*state);
    const json_t *search = json_array_get(json_object_get(root, "searches"), 0);
    const json_t *turned = json_object_get(json_object_get(search, "reach"), "yaw_beyond_90_deg");
    assert_int_equal(json_integer_value(turned), REACH_DESIGNS);
    json_decref(root);
}

// A journal whose result does not fit its scenario is refused before anything is indexed by it.
static void contradicting_journal_is_refused(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_UNTOUCHED);
    struct journal *journal;
    assert_int_equal(journal_open(&journal, *state, JOURNAL_RESUME, NULL), STATUS_OK);
    double bounds[3] = {0};
    struct box box = {3, bounds, bounds};
    struct verdict verdict = {0};
    struct journal_step step = {
        .phase = "seek", .samples = 1, .good = 1, .box = &box, .verdicts = &verdict};
    assert_int_equal(journal_append(journal, &step, NULL), STATUS_OK);
    journal_close(journal);
    struct error error = {0};
    assert_int_equal(report_write(*state, &error), STATUS_IO);
    assert_contains(error.text, "3 variables");
    assert_contains(error.text, "run.db");
    assert_false(file_exists(*state, "result.json"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_are_grouped),
        IN_FOLDER(csv_tables_are_golden),
        IN_FOLDER(json_holds_the_result),
        IN_FOLDER(unfinished_run_shows_its_last_box),
        IN_FOLDER(untouched_run_has_no_corridors),
        IN_FOLDER(no_good_design_names_the_obstacle),
        IN_FOLDER(held_variable_leaves_the_log_volume_finite),
        IN_FOLDER(searches_of_a_sweep_are_told_apart),
        IN_FOLDER(summary_has_a_row_a_case),
        IN_FOLDER(exports_tell_what_no_design_reaches),
        IN_FOLDER(nothing_is_told_of_reach_where_there_is_none),
        IN_FOLDER(export_that_fails_leaves_the_old_one),
        IN_FOLDER(table_is_golden),
        IN_FOLDER(table_marks_what_no_design_reaches),
        IN_FOLDER(designs_that_turn_too_far_are_told),
        IN_FOLDER(contradicting_journal_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
