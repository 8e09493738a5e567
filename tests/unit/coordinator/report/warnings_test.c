// What makes a result doubtful is repeated wherever it is shown.
#include "coordinator/report/warnings.h"

#include "coordinator/report/document.h"
#include "coordinator/report/report.h"

#include "sample_run.h"

#include <jansson.h>

static char *with_speed(const char *speed)
{
    char **parts = g_strsplit(SAMPLE_SCENARIO, "17.889", 2);
    char *text = g_strjoinv(speed, parts);
    g_strfreev(parts);
    return text;
}

static char *printed(const char *folder)
{
    char *text = NULL;
    size_t size = 0;
    struct error error = {0};
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    assert_int_equal(report_print(folder, &(struct report_table){0}, out, &error), STATUS_OK);
    fclose(out);
    return text;
}

// A speed in km/h stands in the table and in result.json, without a place in a file that the reader
// does not have.
static void unlikely_scenario_is_told_again(void **state)
{
    char *scenario = with_speed("64.4");
    sample_run(*state, scenario, 1, SAMPLE_DONE);
    struct error error = {0};
    assert_int_equal(report_write(*state, &error), STATUS_OK);
    char *table = printed(*state);
    assert_non_null(strstr(table, "\nwarning      vehicle.speed: speed is 64.4 m/s"));
    free(table);
    char *path = g_build_filename(*state, "result.json", NULL);
    json_t *result = json_load_file(path, 0, NULL);
    json_t *search = json_array_get(json_object_get(result, "searches"), 0);
    const char *warning = json_string_value(json_array_get(json_object_get(search, "warnings"), 0));
    assert_true(
        g_str_has_prefix(warning, "vehicle.speed: speed is 64.4 m/s, expected 1 to 30 m/s"));
    json_decref(result);
    g_free(path);
    g_free(scenario);
}

// A usual car has an empty list, so that programs need not ask whether there is one.
static void usual_scenario_has_none(void **state)
{
    char *scenario = with_speed("15");
    sample_run(*state, scenario, 1, SAMPLE_DONE);
    g_free(scenario);
    struct error error = {0};
    assert_int_equal(report_write(*state, &error), STATUS_OK);
    char *table = printed(*state);
    assert_null(strstr(table, "warning"));
    free(table);
    char *path = g_build_filename(*state, "result.json", NULL);
    json_t *result = json_load_file(path, 0, NULL);
    json_t *search = json_array_get(json_object_get(result, "searches"), 0);
    assert_true(json_is_array(json_object_get(search, "warnings")));
    assert_int_equal(json_array_size(json_object_get(search, "warnings")), 0);
    json_decref(result);
    g_free(path);
}

// A design space of which everything is good is told, and one bad design of it ends that.
static void space_without_a_bad_design_is_told(void **state)
{
    (void)state;
    struct run_data_search search = {.space_samples = 200, .space_good = 200};
    char **texts = warnings_of(&search);
    assert_true(warnings_any(&search));
    assert_int_equal(g_strv_length(texts), 1);
    assert_true(g_str_has_prefix(texts[0], "design space: all of 200 designs of it are good"));
    g_strfreev(texts);
    search.space_good = 199;
    assert_false(warnings_any(&search));
    search.space_samples = search.space_good = 0;
    assert_false(warnings_any(&search));
}

// In a document of a sweep each warning stands once, with how many cases have it.
static void document_of_a_sweep_has_them(void **state)
{
    (void)state;
    char *axes[] = {NULL};
    struct rows_row row = {.name = (char *)"slow", .status = (char *)"done", .values = axes};
    struct rows rows = {.name = (char *)"speeds",
                        .version = (char *)"1",
                        .axes = axes,
                        .items = &row,
                        .count = 1,
                        .group_count = 1,
                        .warnings = {{.text = (char *)"vehicle.speed: <64.4>", .count = 1}},
                        .warning_count = 1};
    GArray *pictures = g_array_new(FALSE, FALSE, sizeof(struct document_picture));
    const struct document document = {.rows = &rows, .pictures = pictures};
    char *html = document_html(&document), *markdown = document_markdown(&document);
    assert_non_null(strstr(html, "<h2>Warnings</h2>\n<p>vehicle.speed: &#60;64.4&#62; (in 1 of 1 "
                                 "cases, first in slow)</p>"));
    assert_non_null(strstr(markdown, "## Warnings\n\nvehicle.speed: &#60;64.4&#62;"));
    g_free(html);
    g_free(markdown);
    rows.warning_count = 0;
    html = document_html(&document);
    assert_null(strstr(html, "Warnings"));
    g_free(html);
    g_array_unref(pictures);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(unlikely_scenario_is_told_again, folder_make,
                                        folder_remove),
        cmocka_unit_test_setup_teardown(usual_scenario_has_none, folder_make, folder_remove),
        cmocka_unit_test(space_without_a_bad_design_is_told),
        cmocka_unit_test(document_of_a_sweep_has_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
