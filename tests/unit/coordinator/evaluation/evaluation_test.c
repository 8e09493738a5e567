#include "coordinator/evaluation/evaluation.h"
#include "sample_scenario.h"

#include "common/base/clock.h"

#include <glib.h>
#include <glib/gstdio.h>

static char *parent;
static char *folder;

static int set_up(void **state)
{
    (void)state;
    parent = g_dir_make_tmp("sobox-evaluation-XXXXXX", NULL);
    folder = g_build_filename(parent, "run", NULL);
    return 0;
}

static char *in_folder(const char *name)
{
    return g_build_filename(folder, name, NULL);
}

static void remove_file(const char *name)
{
    char *path = in_folder(name);
    g_unlink(path);
    g_free(path);
}

static int tear_down(void **state)
{
    (void)state;
    remove_file("outcomes.csv");
    remove_file("evaluation.json");
    g_rmdir(folder);
    g_rmdir(parent);
    g_free(folder);
    g_free(parent);
    return 0;
}

static char *content_of(const char *name)
{
    char *path = in_folder(name), *text = NULL;
    assert_true(g_file_get_contents(path, &text, NULL, NULL));
    g_free(path);
    return text;
}

static void change(const char *name, const char *text)
{
    char *path = in_folder(name);
    assert_true(g_file_set_contents(path, text, -1, NULL));
    g_free(path);
}

static void begin(struct evaluation *evaluation)
{
    struct scenario scenario;
    struct error error = {0};
    sample_scenario(&scenario);
    if (evaluation_create(evaluation, folder, &scenario, "table.csv", NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_null(scenario.text);
}

static void append(struct evaluation *evaluation, const char *rows, uint64_t end)
{
    const struct evaluation_piece piece = {.text = rows,
                                           .size = strlen(rows),
                                           .rows = 2,
                                           .sums = {.good = 1},
                                           .end = end,
                                           .digest = digest_of(rows, strlen(rows))};
    assert_int_equal(evaluation_append(evaluation, &piece, NULL), STATUS_OK);
}

// What a killed session wrote after its last note is cut off and done again; all before it stays.
static void evaluation_goes_on_where_its_note_says(void **state)
{
    (void)state;
    struct evaluation evaluation;
    begin(&evaluation);
    append(&evaluation, "1,0.5,1,\n2,-1,0,distance\n", 100);
    assert_int_equal(evaluation_note(&evaluation, CLOCK_SECOND_NS, NULL), STATUS_OK);
    append(&evaluation, "3,0.5,1,\n4,-1,0,distance\n", 200);
    evaluation_fini(&evaluation); // killed
    char *all = content_of("outcomes.csv");

    struct error error = {0};
    if (evaluation_resume(&evaluation, folder, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_int_equal(evaluation.rows, 2);
    assert_int_equal(evaluation.sums.good, 1);
    assert_int_equal(evaluation.bytes_read, 100);
    assert_true(g_path_is_absolute(evaluation.designs));
    assert_true(g_str_has_suffix(evaluation.designs, "/table.csv"));
    assert_string_equal(evaluation.scenario.name, "sample");
    append(&evaluation, "3,0.5,1,\n4,-1,0,distance\n", 200);
    assert_int_equal(evaluation_end(&evaluation, RUN_STATE_DONE, 0, NULL), STATUS_OK);
    evaluation_fini(&evaluation);
    char *again = content_of("outcomes.csv");
    assert_string_equal(again, all);
    assert_string_equal(again, "id,distance,good,violated\n"
                               "1,0.5,1,\n2,-1,0,distance\n3,0.5,1,\n4,-1,0,distance\n");
    g_free(again);
    g_free(all);

    assert_int_equal(evaluation_resume(&evaluation, folder, 0, &error), STATUS_REFUSED);
    assert_non_null(strstr(error.text, "is done"));
}

// A folder belongs to one process at a time.
static void folder_of_a_living_evaluation_is_refused(void **state)
{
    (void)state;
    struct evaluation evaluation, other;
    struct error error = {0};
    begin(&evaluation);
    assert_int_equal(evaluation_resume(&other, folder, 0, &error), STATUS_REFUSED);
    struct scenario scenario;
    sample_scenario(&scenario);
    assert_int_equal(evaluation_create(&other, folder, &scenario, "t", NULL, 0, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "not empty"));
    evaluation_abandon(&evaluation);
    evaluation_fini(&evaluation);
    assert_false(g_file_test(folder, G_FILE_TEST_EXISTS));
}

// Files may be cut, edited or of another version: said, and nothing of them is believed.
static void damaged_folder_is_refused(void **state)
{
    (void)state;
    struct evaluation evaluation;
    begin(&evaluation);
    append(&evaluation, "1,0.5,1,\n2,-1,0,distance\n", 100);
    assert_int_equal(evaluation_note(&evaluation, CLOCK_SECOND_NS, NULL), STATUS_OK);
    evaluation_fini(&evaluation);
    char *note = content_of("evaluation.json");
    static const char *const changes[][2] = {
        {"\"rows\": 2", "\"rows\": -2"},
        {"\"rows\": 2", "\"rows\": \"2\""},
        {"\"rows\": 2,", ""},
        {"\"elapsed_s\": ", "\"elapsed_s\": -"},
        {"\"digest\": \"", "\"digest\": \"x"},
        {"\"distance\"", "\"nothing\""},
        {"\"distance\"", "7"},
        {"name: sample", "nome: sample"},
        {"\"version\": \"", "\"version\": \"0.0."},
        {"{", ""},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(changes); i++) {
        struct error error = {0};
        g_auto(GStrv) parts = g_strsplit(note, changes[i][0], 2);
        assert_non_null(parts[1]);
        g_autofree char *changed = g_strjoinv(changes[i][1], parts);
        change("evaluation.json", changed);
        assert_int_not_equal(evaluation_resume(&evaluation, folder, 0, &error), STATUS_OK);
        assert_string_not_equal(error.text, "");
    }
    change("evaluation.json", note);
    change("outcomes.csv", "id,distance,good,violated\n1,0.5,1,\n");
    struct error error = {0};
    assert_int_equal(evaluation_resume(&evaluation, folder, 0, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "it was changed"));
    g_free(note);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(evaluation_goes_on_where_its_note_says, set_up, tear_down),
        cmocka_unit_test_setup_teardown(folder_of_a_living_evaluation_is_refused, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(damaged_folder_is_refused, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
