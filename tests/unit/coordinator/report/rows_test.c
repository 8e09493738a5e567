// A sweep as a table, and the scripts and documents that are made from it.
#include "coordinator/report/document.h"
#include "coordinator/report/overlay.h"
#include "coordinator/report/rows.h"
#include "coordinator/report/volume.h"

#include "sample_run.h"

#include <inttypes.h>
#include <math.h>

// A table of two masses, three responses (the last axis but the seed follows the mass) and two
// seeds, in memory only.
enum { MASSES = 2, RESPONSES = 3, SEEDS = 2, CASES = MASSES * RESPONSES * SEEDS };

static void table(struct rows *rows)
{
    static const char *const masses[] = {"1500", "1650"}, *const inertias[] = {"2727", "3000"};
    static const char *const responses[] = {"any", "rotating", "<b>|glancing_off"};
    static const char *const seeds[] = {"1", "2"};
    static const char *const axes[] = {"vehicle.mass", "vehicle.yaw_inertia", "response",
                                       "search.seed", NULL};
    *rows = (struct rows){.name = g_strdup("masses"),
                          .version = g_strdup("1.2.3"),
                          .axes = g_strdupv((char **)axes),
                          .axis_count = 4,
                          .items = g_new0(struct rows_row, CASES),
                          .count = CASES,
                          .group_count = MASSES * RESPONSES,
                          .done = CASES,
                          .found = CASES - 1};
    for (uint32_t i = 0; i < CASES; i++) {
        const uint32_t mass = i / (RESPONSES * SEEDS), response = i / SEEDS % RESPONSES;
        const char *values[] = {masses[mass], inertias[mass], responses[response], seeds[i % SEEDS],
                                NULL};
        rows->items[i] = (struct rows_row){
            .index = i,
            .name = g_strdup_printf("case%" PRIu32, i),
            .status = g_strdup("done"),
            .values = g_strdupv((char **)values),
            .group = i / SEEDS,
            .log_volume = -1.0 - i,
            .purity_lower95 = 0.99,
        };
    }
    rows->items[CASES - 1].log_volume = NAN;
}

// What is read from a run folder: names, values, groups, and what is unknown as NAN.
static void run_folder_becomes_a_table(void **state)
{
    sample_sweep(*state);
    struct rows rows;
    struct error error = {0};
    assert_int_equal(rows_read(&rows, *state, &error), STATUS_OK);
    assert_int_equal(rows.count, 3);
    assert_int_equal(rows.axis_count, 2);
    assert_int_equal(rows.group_count, 3);
    assert_int_equal(rows.done, 2);
    assert_int_equal(rows.found, 1);
    assert_string_equal(rows.items[0].name, "mass=1,upper=#1");
    assert_true(rows.items[0].log_volume == -4.5);
    assert_true(isnan(rows.items[1].log_volume));
    assert_string_equal(rows.items[2].status, "waiting");
    assert_string_equal(rows.items[2].values[0], "3");
    rows_fini(&rows);
}

static void single_run_is_no_table(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    struct rows rows;
    struct error error = {0};
    assert_int_equal(rows_read(&rows, *state, &error), STATUS_INVALID);
    assert_contains(error.text, "not a sweep");
}

// An axis may be called by its last key, but only where that is one axis alone.
static void axes_are_found_by_path_or_last_key(void **state)
{
    (void)state;
    struct rows rows;
    table(&rows);
    assert_int_equal(rows_axis(&rows, "vehicle.mass"), 0);
    assert_int_equal(rows_axis(&rows, "mass"), 0);
    assert_int_equal(rows_axis(&rows, "seed"), 3);
    assert_int_equal(rows_axis(&rows, "weight"), 4);
    g_free(rows.axes[1]);
    rows.axes[1] = g_strdup("trailer.mass");
    assert_int_equal(rows_axis(&rows, "mass"), 4);
    assert_int_equal(rows_axis(&rows, "trailer.mass"), 1);
    assert_true(rows_follows(&rows, 1, 0));
    assert_false(rows_follows(&rows, 2, 0));
    assert_true(rows_is_seed(&rows, 3));
    assert_int_equal(rows_best(&rows, 1)->index, 2);
    assert_int_equal(rows_best(&rows, 5)->index, 10);
    rows_fini(&rows);
}

static void median_is_the_middle(void **state)
{
    (void)state;
    double odd[] = {3, 1, 2}, even[] = {4, 1, 3, 2}, one[] = {7};
    assert_true(rows_median(odd, 3) == 2);
    assert_true(rows_median(even, 4) == 2.5);
    assert_true(rows_median(one, 1) == 7);
}

// A line a response: the seed makes dots, and the inertia, which goes with the mass, makes nothing.
static void lines_are_told_apart_by_what_is_left(void **state)
{
    (void)state;
    struct rows rows;
    table(&rows);
    char *script = volume_lines(&rows, 0, "volume");
    assert_contains(script, "$line_1 << END\n1500 -1.5\n1650 -7.5\n");
    assert_contains(script, "$dots_1 << END\n1500 -1\n1500 -2\n1650 -7\n1650 -8\n");
    assert_contains(script, "$line_3 << END\n1500 -5.5\n1650 -11\n"); // one seed found nothing
    assert_contains(script, "title \"response=any\"");
    assert_null(strstr(script, "$line_4"));
    assert_null(strstr(script, "yaw"));
    assert_null(strstr(script, "<b>")); // hostile characters are codes
    g_free(script);
    script = volume_lines(&rows, 2, "volume");
    assert_contains(script, "set xtics (\"any\" 0, \"rotating\" 1,");
    g_free(script);
    rows_fini(&rows);
}

static void map_has_the_median_of_each_cell(void **state)
{
    (void)state;
    struct rows rows;
    table(&rows);
    char *script = volume_map(&rows, 0, 2, "map");
    assert_contains(script, "\n0 0 -1.5\n0 1 -3.5\n0 2 -5.5\n1 0 -7.5\n1 1 -9.5\n1 2 -11\n");
    g_free(script);
    rows_fini(&rows);
}

// Texts from elsewhere stay texts in both languages.
static void documents_hold_tables_and_tame_texts(void **state)
{
    (void)state;
    struct rows rows;
    table(&rows);
    struct document_picture picture = {
        .title = g_strdup("A <title>"), .svg = g_strdup("<svg/>"), .file = g_strdup("p-1.svg")};
    struct document document = {.rows = &rows,
                                .pictures = g_array_new(FALSE, FALSE, sizeof picture)};
    g_array_append_val(document.pictures, picture);
    char *markdown = document_markdown(&document), *html = document_html(&document);
    assert_contains(markdown, "# masses\n");
    assert_contains(markdown, "| 1500 | 2727 | &#60;b&#62;\\|glancing\\_off | 2 | 2 | -5.000 | "
                              "-5.500 | -6.000 | 0.9900 |");
    assert_contains(markdown, "| 1650 | 3000 | &#60;b&#62;\\|glancing\\_off | 2 | 1 | -11.000 | "
                              "-11.000 | -11.000 |");
    assert_contains(markdown, "](p-1.svg)");
    assert_contains(markdown, "| case11 | done | - |");
    assert_contains(html, "<figure><svg/></figure>");
    assert_contains(html, "<h2>A &#60;title&#62;</h2>");
    assert_null(strstr(html, "<b>"));
    assert_null(strstr(markdown, "<b>"));
    g_free(markdown);
    g_free(html);
    g_free(picture.title);
    g_free(picture.svg);
    g_free(picture.file);
    g_array_unref(document.pictures);
    rows_fini(&rows);
}

// Cases lie over the design space of the first; normalised, nothing of the car is in the script.
static void overlay_has_the_bounds_of_each_case(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 2, SAMPLE_DONE);
    struct run_data data;
    struct error error = {0};
    assert_int_equal(run_data_read(&data, *state, &error), STATUS_OK);
    struct overlay overlay = {
        .title = "two", .searches = data.searches, .count = 2, .stem = "cases"};
    char *script = overlay_script(&overlay);
    assert_contains(script, "$design_1_x << END\n0 0 60\n1.2 0 450\nEND\n");
    assert_contains(script, "$case_1_1_x << END\n0 15 45\n1.2 112.5 337.5\nEND\n");
    assert_contains(script, "$case_2_2_y << END\n0.1 1 3\n0.9 1 3\nEND\n");
    g_free(script);
    overlay.normalise = true;
    script = overlay_script(&overlay);
    assert_contains(script, "$case_1_1_x << END\n0 0.03333");
    assert_null(strstr(script, "450"));
    assert_null(strstr(script, "[kN]"));
    g_free(script);
    run_data_fini(&data);
}

// A case's bounds are dashed where no design comes, and documents show the same picture.
static void overlay_dashes_what_no_design_reaches(void **state)
{
    sample_run(*state, SAMPLE_STOPPED, 2, SAMPLE_DONE);
    struct run_data data;
    struct error error = {0};
    assert_int_equal(run_data_read(&data, *state, &error), STATUS_OK);
    run_data_find_reach(&data.searches[1]);
    const struct overlay overlay = {
        .title = "two", .searches = data.searches, .count = 2, .stem = "cases"};
    char *script = overlay_script(&overlay);
    assert_contains(script, "$case_1_1_x << END\n0 500 700\n0.25 500 700\n0.5 500 700\n"
                            "0.75 500 700\n1 500 700\nEND\n"); // nobody looked
    assert_contains(script, "$case_2_1_x << END\n0 500 700\n0.25 500 700\n0.5 500 700\n"
                            "0.75 500 700\nEND\n"
                            "$beyond_2_1_x << END\n0.75 500 700\n1 500 700\nEND\n");
    assert_contains(script, "$beyond_2_1_x using 1:2 with lines lw 1 dt 2");
    assert_contains(script, "dashed: reached by none of 2,048 designs that were simulated");
    g_free(script);
    run_data_fini(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(run_folder_becomes_a_table),
        IN_FOLDER(single_run_is_no_table),
        cmocka_unit_test(axes_are_found_by_path_or_last_key),
        cmocka_unit_test(median_is_the_middle),
        cmocka_unit_test(lines_are_told_apart_by_what_is_left),
        cmocka_unit_test(map_has_the_median_of_each_cell),
        cmocka_unit_test(documents_hold_tables_and_tame_texts),
        IN_FOLDER(overlay_has_the_bounds_of_each_case),
        IN_FOLDER(overlay_dashes_what_no_design_reaches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
