// Reports of scenarios without springs, and of cases.
#include "common/plot/picture.h"
#include "sample_run.h"

#include "coordinator/report/report.h"

#include <stdlib.h>

static const char FORMULA[] = "name: sections\n"
                              "model: two_section_crash\n"
                              "variables:\n"
                              "- {name: F1, lower: 100e3, upper: 500e3}\n"
                              "- {name: F2, lower: 200e3, upper: 600e3}\n"
                              "- {name: mass, lower: 2000, upper: 2000}\n"
                              "parameters: {d1: 0.3, d2: 0.3, speed: 15.6}\n"
                              "constraints: {energy_remaining: {max: 0}}\n";

static char *printed(const char *folder)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_int_equal(report_print(folder, &(struct report_table){0}, out, NULL), STATUS_OK);
    fclose(out);
    return text;
}

static void draw(const char *folder, const struct report_plot *plot)
{
    struct error error = {0};
    if (report_draw(folder, plot, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

// The columns are those of springs, so that whatever reads them need not change: the variable's
// name stands for the spring, and what it does not have is empty.
static void csv_names_the_variable(void **state)
{
    sample_run(*state, FORMULA, 1, SAMPLE_DONE);
    assert_int_equal(report_write(*state, NULL), STATUS_OK);
    char *csv = file_text(*state, "corridors.csv");
    assert_string_equal(csv, "search,spring,direction,deformation_m,lower_N,upper_N,"
                             "design_lower_N,design_upper_N,reached\n"
                             "0,F1,,,200000,400000,100000,500000,\n"
                             "0,F2,,,300000,500000,200000,600000,\n"
                             "0,mass,,,2000,2000,2000,2000,\n");
    g_free(csv);
}

static void json_has_no_spring(void **state)
{
    sample_run(*state, FORMULA, 1, SAMPLE_DONE);
    assert_int_equal(report_write(*state, NULL), STATUS_OK);
    char *json = file_text(*state, "result.json");
    assert_contains(json, "\"name\": \"F1\",\n          \"design\": [");
    assert_null(strstr(json, "spring"));
    assert_null(strstr(json, "deformation_m"));
    g_free(json);
}

static void table_has_a_line_a_variable(void **state)
{
    sample_run(*state, FORMULA, 1, SAMPLE_DONE);
    char *table = printed(*state);
    assert_contains(table, "sections, model two_section_crash\n");
    assert_contains(table, "F1             200000       400000    50.0       1e+05       5e+05\n");
    assert_contains(table, "mass             2000         2000   fixed        2000        2000\n");
    free(table);
}

// Each variable's name and bounds stand in the picture, and its axis is the share.
static void picture_has_a_bar_a_variable(void **state)
{
    sample_run(*state, FORMULA, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG});
    char *picture = file_text(*state, "corridors.svg");
    static const char *const PARTS[] = {"F1",
                                        "F2",
                                        "mass",
                                        "200000",
                                        "400000",
                                        "share of the design space [%]",
                                        "model: two_section_crash"};
    for (size_t i = 0; i < G_N_ELEMENTS(PARTS); i++)
        assert_contains(picture, PARTS[i]);
    g_free(picture);
}

// What is shared without its numbers has none, neither in the picture nor in the script.
static void normalised_picture_holds_no_numbers(void **state)
{
    sample_run(*state, FORMULA, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG, .normalise = true});
    static const char *const FILES[] = {"corridors-normalised.svg", "corridors-normalised.gp"};
    for (size_t i = 0; i < G_N_ELEMENTS(FILES); i++) {
        char *text = file_text(*state, FILES[i]);
        assert_null(strstr(text, "200000"));
        assert_null(strstr(text, "400000"));
        g_free(text);
    }
}

// Runs are compared in the variables that both have; without one in common it is said.
static void variables_of_one_name_are_compared(void **state)
{
    char *other = g_build_filename(*state, "other", NULL);
    char *springs = g_build_filename(*state, "springs", NULL);
    assert_int_equal(mkdir(other, 0777), 0);
    assert_int_equal(mkdir(springs, 0777), 0);
    sample_run(*state, FORMULA, 1, SAMPLE_DONE);
    sample_run(other,
               "name: other\nmodel: hypersphere\n"
               "variables: [{name: F2, lower: 0, upper: 1e6}, {name: F9, lower: 0, upper: 1}]\n"
               "constraints: {distance: {max: 0}}\n",
               1, SAMPLE_DONE);
    sample_run(springs, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG, .compare = other});
    char *picture = file_text(*state, "corridors-compared.svg");
    assert_contains(picture, "sections and other");
    assert_contains(picture, "750000"); // the other run's
    assert_null(strstr(picture, "mass"));
    struct error error = {0};
    assert_int_equal(report_draw(*state,
                                 &(struct report_plot){.format = PICTURE_SVG, .compare = springs},
                                 &error),
                     STATUS_INVALID);
    assert_contains(error.text, "none of its variables (front.force_x[0], ...) has the name of one "
                                "of the run it is compared with (F1, ...)");
    g_free(picture);
    g_free(springs);
    g_free(other);
}

// With hundreds of variables names and numbers would run into each other; the page stays a page.
static void many_variables_fit_a_page(void **state)
{
    GString *text = g_string_new("name: many\nmodel: hypersphere\nvariables:\n");
    for (int i = 0; i < 700; i++)
        g_string_append_printf(text, "- {name: variable-%d, lower: 0, upper: 1}\n", i);
    g_string_append(text, "constraints: {distance: {max: 0}}\n");
    sample_run(*state, text->str, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG});
    char *script = file_text(*state, "corridors.gp");
    assert_null(strstr(script, "variable-5"));
    assert_contains(script, "height = 2086.0");
    g_free(script);
    g_string_free(text, TRUE);
}

// Which car it is that does not allow a design is what an engineer asks first.
static void obstacle_names_its_case(void **state)
{
    char *text = g_strconcat(
        SAMPLE_SCENARIO, "cases:\n- {name: sedan}\n- {name: wagon, vehicle.mass: 1800}\n", NULL);
    sample_run(*state, text, 1, SAMPLE_NO_GOOD_DESIGN);
    char *table = printed(*state);
    assert_contains(table, "sample, good in sedan and wagon\n");
    assert_contains(table,
                    "in the way   sedan.s_L_min >= 0.25 m: violated worst by 8 of 8 samples");
    free(table);
    g_free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(csv_names_the_variable),
        IN_FOLDER(json_has_no_spring),
        IN_FOLDER(table_has_a_line_a_variable),
        IN_FOLDER(picture_has_a_bar_a_variable),
        IN_FOLDER(normalised_picture_holds_no_numbers),
        IN_FOLDER(variables_of_one_name_are_compared),
        IN_FOLDER(many_variables_fit_a_page),
        IN_FOLDER(obstacle_names_its_case),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
