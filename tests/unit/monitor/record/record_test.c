// A run's journal shown as a run: what the monitor makes of it, beside the numbers, is how each
// step's samples were drawn, on which the pictures of samples rest.
#include "monitor/record/record.h"

#include "coordinator/journal/journal.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <setjmp.h>
#include <sqlite3.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { SAMPLES = 10 };

// Explores with uniform samples, if one went by the scenario.
static char scenario_text[] = "name: plain\n"
                              "model: hypersphere\n"
                              "variables:\n"
                              "  - {name: a, lower: -1, upper: 1}\n"
                              "  - {name: b, lower: -1, upper: 1}\n"
                              "parameters: {radius: 1}\n"
                              "constraints: {radius: {max: 1}}\n";

struct fixture {
    char *folder;
    struct feed feed;
    struct texts *texts;
    struct record *record;
};

static void append_step(struct journal *journal, uint32_t number, const char *phase,
                        enum sampling_method sampling)
{
    double lower[2] = {-1, 0.25}, upper[2] = {1, 0.5};
    struct box box = {2, lower, upper};
    struct verdict verdicts[SAMPLES] = {[3] = {.violation = 700, .constraint = 0}};
    struct journal_step step = {.step = number,
                                .samples = SAMPLES,
                                .good = SAMPLES - 1,
                                .log_volume = -2,
                                .box = &box,
                                .verdicts = verdicts,
                                .sampling = sampling};
    g_strlcpy(step.phase, phase, sizeof step.phase);
    assert_int_equal(journal_append(journal, &step, NULL), STATUS_OK);
}

static int setup(void **state)
{
    struct fixture *fixture = g_new0(struct fixture, 1);
    fixture->folder = g_dir_make_tmp("sobox-record-XXXXXX", NULL);
    const struct journal_run run = {.name = "plain", .version = "1", .id = 77, .search_count = 1};
    const struct journal_search search = {.text = scenario_text,
                                          .text_size = sizeof scenario_text - 1,
                                          .scenario = digest_of("plain", 5),
                                          .seed = 42};
    struct journal *journal;
    assert_int_equal(journal_create(&journal, fixture->folder, &run, &search, NULL), STATUS_OK);
    append_step(journal, 0, "seek", SAMPLING_METHOD_LATIN_HYPERCUBE);
    append_step(journal, 1, "explore", SAMPLING_METHOD_SOBOL);
    append_step(journal, 2, "certify", SAMPLING_METHOD_UNIFORM);
    journal_close(journal);
    feed_init(&fixture->feed);
    fixture->texts = texts_create();
    fixture->record = record_open(fixture->folder, &fixture->feed, fixture->texts);
    *state = fixture;
    return 0;
}

static int teardown(void **state)
{
    struct fixture *fixture = *state;
    record_close(fixture->record);
    texts_free(fixture->texts);
    feed_fini(&fixture->feed);
    GDir *dir = g_dir_open(fixture->folder, 0, NULL);
    for (const char *name; (name = g_dir_read_name(dir)) != NULL;) {
        char *path = g_build_filename(fixture->folder, name, NULL);
        g_unlink(path);
        g_free(path);
    }
    g_dir_close(dir);
    g_rmdir(fixture->folder);
    g_free(fixture->folder);
    g_free(fixture);
    return 0;
}

static const struct feed_search *read_all(struct fixture *fixture)
{
    struct error error = {0};
    assert_int_equal(record_read(fixture->record, 1, &error), STATUS_OK);
    assert_int_equal(record_read_samples(fixture->record, 0, 2, &error), STATUS_OK);
    return feed_search_find(&fixture->feed, 77, 0);
}

// The exploration's samples are Sobol points here although the scenario's setting is another: what
// was drawn stands in the journal, and no rule about phases may be put in its place.
static void samples_are_drawn_as_the_journal_says(void **state)
{
    struct fixture *fixture = *state;
    const struct feed_search *search = read_all(fixture);
    static const enum sampling_method methods[] = {SAMPLING_METHOD_LATIN_HYPERCUBE,
                                                   SAMPLING_METHOD_SOBOL, SAMPLING_METHOD_UNIFORM};
    assert_non_null(search);
    assert_non_null(search->album);
    for (uint32_t step = 0; step < 3; step++) {
        const struct album_picture *picture = album_find(search->album, step);
        assert_non_null(picture);
        assert_int_equal(picture->sampling.step, step);
        assert_int_equal(picture->sampling.method, methods[step]);
        assert_int_equal(picture->sampling.seed, 42);
        assert_int_equal(picture->sampling.samples, SAMPLES);
        assert_int_equal(picture->good, SAMPLES - 1);
        assert_int_equal(picture->count, SAMPLES);
        assert_int_equal(picture->verdicts[3].violation, 700);
        assert_true(picture->sampled.lower[1] == 0.25);
        assert_true(picture->sampled.upper[1] == 0.5);
    }
}

// The course and the box of a run are shown as they stand in the journal.
static void search_is_shown_as_the_journal_has_it(void **state)
{
    const struct feed_search *search = read_all(*state);
    assert_int_equal(search->standing, SEARCH_STANDING_OPEN);
    assert_int_equal(search->phase, SEARCH_PHASE_CERTIFY);
    assert_int_equal(search->step, 3);
    assert_int_equal(search->evaluations, 3 * SAMPLES);
    assert_int_equal(search->steps.points->len, 3);
    assert_int_equal(search->bounds->len, 4);
    assert_true(g_array_index(search->bounds, double, 1) == 0.25);
    assert_true(g_array_index(search->bounds, double, 3) == 0.5);
}

// A journal that does not say how its steps were sampled is shown without samples, not with others.
static void old_journal_has_no_samples_to_show(void **state)
{
    struct fixture *fixture = *state;
    char *path = g_build_filename(fixture->folder, "run.db", NULL);
    sqlite3 *database;
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    assert_int_equal(sqlite3_exec(database,
                                  "UPDATE meta SET schema = 2;"
                                  "ALTER TABLE step DROP COLUMN sampling",
                                  NULL, NULL, NULL),
                     SQLITE_OK);
    sqlite3_close(database);
    g_free(path);
    const struct feed_search *search = read_all(fixture);
    assert_int_equal(search->step, 3);
    assert_null(search->album);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(samples_are_drawn_as_the_journal_says, setup, teardown),
        cmocka_unit_test_setup_teardown(search_is_shown_as_the_journal_has_it, setup, teardown),
        cmocka_unit_test_setup_teardown(old_journal_has_no_samples_to_show, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
