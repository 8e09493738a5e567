// A run and its journal: begun, taken up again, refused, abandoned. The model is a plane cut
// through the design space, so that no kernel is needed.
#include "coordinator/runtime/run.h"

#include "common/base/log.h"
#include "common/sampling/sampling.h"
#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <setjmp.h>
#include <sqlite3.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static const char text[] = "name: plane\n"
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
                           "search: {samples: 50, exploration_steps: 10, consolidation_steps: 10,\n"
                           "         certificate_samples: 400}\n";

struct fixture {
    char *parent; // a folder of the test's own
    char *folder; // the run folder in it
};

static int setup(void **state)
{
    struct fixture *fixture = g_new0(struct fixture, 1);
    fixture->parent = g_dir_make_tmp("sobox-run-XXXXXX", NULL);
    fixture->folder = g_build_filename(fixture->parent, "run", NULL);
    *state = fixture;
    return 0;
}

static void remove_tree(const char *path)
{
    GDir *dir = g_dir_open(path, 0, NULL);
    const char *name;
    while (dir != NULL && (name = g_dir_read_name(dir)) != NULL) {
        char *inside = g_build_filename(path, name, NULL);
        remove_tree(inside);
        g_free(inside);
    }
    if (dir != NULL)
        g_dir_close(dir);
    g_remove(path);
}

static int teardown(void **state)
{
    struct fixture *fixture = *state;
    remove_tree(fixture->parent);
    g_free(fixture->parent);
    g_free(fixture->folder);
    g_free(fixture);
    return 0;
}

static struct scenario scenario_of(const char *yaml)
{
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_text(&scenario, "plane.yaml", yaml, strlen(yaml), NULL, 0, &error) !=
        STATUS_OK)
        fail_msg("%s", error.text);
    return scenario;
}

// Good below the plane through 60 % of the space's far corner.
static void judge(const struct run_search *search)
{
    const uint32_t samples = search->request.sampling.samples;
    const uint32_t count = search->scenario.design_space.count;
    double *values = calloc((size_t)samples * count, sizeof *values);
    sampling_fill(&search->request.sampling, search->request.box, 0, samples, values, samples);
    for (uint32_t i = 0; i < samples; i++) {
        double sum = 0;
        for (uint32_t v = 0; v < count; v++)
            sum += values[(size_t)v * samples + i] / search->scenario.design_space.upper[v];
        search->verdicts[i].constraint = 0;
        search->verdicts[i].violation = verdict_violation(sum / count - 0.6);
        search->verdicts[i].margin = (float)(0.6 - sum / count);
    }
    free(values);
}

// Works on a search until it is done or `steps` steps are complete. Returns whether it is done; its
// digest is then in `digest`, unless that is NULL.
static bool work_on(struct run *run, uint32_t index, unsigned steps, struct digest *digest)
{
    struct error error = {0};
    if (run->open[index] == NULL && run_open(run, index, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    for (unsigned i = 0; i < steps; i++) {
        bool wanted = false;
        assert_int_equal(run_next(run, index, 0, &wanted, &error), STATUS_OK);
        if (!wanted) {
            struct search_result result;
            search_result(run->open[index]->search, &result);
            if (digest != NULL)
                *digest = result.digest;
            run_close(run, index);
            return true;
        }
        judge(run->open[index]);
        run_trim(run->open[index]);
        assert_int_equal(run_record(run, index, &error), STATUS_OK);
    }
    return false;
}

static void begin(struct run *run, const char *folder)
{
    struct scenario scenario = scenario_of(text);
    struct error error = {0};
    if (run_create(run, folder, &scenario, 1, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    scenario_fini(&scenario);
}

static const struct run_choice everything = {.shard = 1, .shard_count = 1};

static void resume(struct run *run, const char *folder)
{
    struct error error = {0};
    if (run_resume(run, folder, &everything, 1, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

enum { ALL = 100000 };

// The digest must not depend on where a run was interrupted: after every single step once.
static void resumed_run_ends_with_the_digest_of_an_uninterrupted_one(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct digest whole, resumed;
    struct error error = {0};
    begin(&run, fixture->folder);
    assert_true(work_on(&run, 0, ALL, &whole));
    const uint64_t steps = run.steps;
    run_fini(&run);

    for (uint64_t at = 0; at <= steps; at++) {
        remove_tree(fixture->folder);
        begin(&run, fixture->folder);
        work_on(&run, 0, (unsigned)at, NULL);
        assert_int_equal(run_end(&run, RUN_STATE_INTERRUPTED, 5, &error), STATUS_OK);
        run_fini(&run);
        resume(&run, fixture->folder);
        assert_int_equal(run.record.elapsed_ns, 5);
        assert_true(work_on(&run, 0, ALL, &resumed));
        assert_true(digest_equal(&resumed, &whole));
        run_fini(&run);
    }
}

// What a user has in a folder is never mixed with a run, nor touched.
static void folder_with_something_in_it_is_refused_and_left_alone(void **state)
{
    const struct fixture *fixture = *state;
    char *notes = g_build_filename(fixture->parent, "notes.txt", NULL);
    assert_true(g_file_set_contents(notes, "mine", -1, NULL));
    struct scenario scenario = scenario_of(text);
    struct run run;
    struct error error = {0};
    assert_int_equal(run_create(&run, fixture->parent, &scenario, 1, 0, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "not empty"));
    assert_true(g_file_test(notes, G_FILE_TEST_EXISTS));
    scenario_fini(&scenario);
    g_free(notes);
}

// A run that never began leaves no empty shell, but a folder the user made stays.
static void abandoned_run_leaves_nothing_of_its_own(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    begin(&run, fixture->folder);
    run_abandon(&run);
    run_fini(&run);
    assert_false(g_file_test(fixture->folder, G_FILE_TEST_EXISTS));

    assert_int_equal(g_mkdir(fixture->folder, 0777), 0);
    begin(&run, fixture->folder);
    run_abandon(&run);
    run_fini(&run);
    assert_true(g_file_test(fixture->folder, G_FILE_TEST_IS_DIR));
    assert_int_equal(g_rmdir(fixture->folder), 0);
}

// There is nothing to continue in a run that is done; the message says how to see it.
static void finished_run_is_not_resumed(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct error error = {0};
    begin(&run, fixture->folder);
    assert_true(work_on(&run, 0, ALL, NULL));
    assert_int_equal(run_end(&run, RUN_STATE_DONE, 1, &error), STATUS_OK);
    run_fini(&run);
    assert_int_equal(run_resume(&run, fixture->folder, &everything, 1, 0, &error), STATUS_REFUSED);
    assert_non_null(strstr(error.text, "sobox-report"));
}

// A folder without a run is the user's mistake, said as such.
static void folder_without_a_run_is_not_resumed(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct error error = {0};
    assert_int_equal(run_resume(&run, fixture->parent, &everything, 1, 0, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, fixture->parent));
}

// ---- Sweeps ----

// A sweep of the plane over two sizes of its steps and `replicates` seeds.
static struct sweep *sweep_of(const struct fixture *fixture, const char *values, int replicates)
{
    char *base = g_build_filename(fixture->parent, "plane.yaml", NULL);
    char *path = g_build_filename(fixture->parent, "sweep.yaml", NULL);
    char *yaml = g_strdup_printf("sweep: planes\nbase: plane.yaml\n"
                                 "axes: [{path: search.samples, values: %s}]\n"
                                 "replicates: %d\n",
                                 values, replicates);
    assert_true(g_file_set_contents(base, text, -1, NULL));
    assert_true(g_file_set_contents(path, yaml, -1, NULL));
    struct sweep *sweep;
    struct error error = {0};
    if (sweep_read_file(&sweep, path, NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    g_free(yaml);
    g_free(path);
    g_free(base);
    return sweep;
}

static void begin_sweep(struct run *run, const struct fixture *fixture,
                        const struct run_choice *choice)
{
    struct sweep *sweep = sweep_of(fixture, "[40, 50]", 3);
    struct error error = {0};
    if (run_create_sweep(run, fixture->folder, sweep, choice, 1, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    sweep_free(sweep);
}

enum { CASES = 6 };

// Works on all searches in turn, a step each, with at most `open_max` open at once; stops after
// `steps` steps of all of them. Returns whether the session has nothing left to do.
static bool work_in_turn(struct run *run, uint32_t open_max, unsigned steps,
                         struct digest digests[CASES])
{
    uint32_t index;
    for (unsigned step = 0; !run_finished(run);) {
        while (run->open_count < open_max && run_waiting(run, &index)) {
            struct error error = {0};
            if (run_open(run, index, 0, &error) != STATUS_OK)
                fail_msg("%s", error.text);
        }
        for (uint32_t i = 0; i < run->record.search_count; i++) {
            if (run->open[i] == NULL)
                continue;
            if (step++ == steps)
                return false;
            work_on(run, i, 1, &digests[i]);
        }
    }
    return true;
}

// Many searches side by side, taken up at any moment, each ends as its scenario does alone.
static void case_ends_as_its_scenario_alone_wherever_the_sweep_was_interrupted(void **state)
{
    const struct fixture *fixture = *state;
    struct digest alone[CASES], digests[CASES];
    struct sweep *sweep = sweep_of(fixture, "[40, 50]", 3);
    struct run run;
    struct error error = {0};
    for (uint32_t i = 0; i < CASES; i++) {
        struct scenario scenario;
        assert_int_equal(sweep_scenario(sweep, i, &scenario, &error), STATUS_OK);
        assert_int_equal(run_create(&run, fixture->folder, &scenario, 1, 0, &error), STATUS_OK);
        assert_true(work_on(&run, 0, ALL, &alone[i]));
        run_fini(&run);
        scenario_fini(&scenario);
        remove_tree(fixture->folder);
    }
    sweep_free(sweep);
    for (unsigned steps = 1; steps < 400; steps = steps * 2 + 1) {
        begin_sweep(&run, fixture, &everything);
        bool finished = work_in_turn(&run, 1 + steps % 4, steps, digests);
        run_fini(&run);
        while (!finished) {
            resume(&run, fixture->folder);
            finished = work_in_turn(&run, 1 + steps % 3, steps, digests);
            if (finished)
                assert_int_equal(run.done_count, CASES);
            run_fini(&run);
        }
        for (uint32_t i = 0; i < CASES; i++)
            assert_true(digest_equal(&digests[i], &alone[i]));
        remove_tree(fixture->folder);
    }
}

// What waits and what is done holds no search: ten thousand of them cost kilobytes.
static void only_open_searches_hold_memory(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct digest digests[CASES];
    begin_sweep(&run, fixture, &everything);
    for (uint32_t i = 0; i < CASES; i++)
        assert_null(run.open[i]);
    work_in_turn(&run, 2, 5, digests);
    assert_int_equal(run.open_count, 2);
    assert_true(work_in_turn(&run, 2, ALL, digests));
    assert_int_equal(run.open_count, 0);
    assert_int_equal(run.done_count, CASES);
    assert_int_equal(run.found_count, CASES);
    for (uint32_t i = 0; i < CASES; i++)
        assert_null(run.open[i]);
    run_fini(&run);
}

// Of the same sweep: the cases that a pattern, a shard and a limit leave.
static void choice_leaves_the_searches_it_names(void **state)
{
    static const struct {
        struct run_choice choice;
        uint32_t searches, chosen;
        const char *first;
    } cases[] = {
        {{.shard = 1, .shard_count = 1}, 6, 6, "samples=40,seed=1"},
        {{.only = "*seed=2", .shard = 1, .shard_count = 1}, 2, 2, "samples=40,seed=2"},
        {{.only = "samples=50,seed=[13]", .shard = 1, .shard_count = 1}, 2, 2, "samples=50,seed=1"},
        {{.shard = 2, .shard_count = 4}, 2, 2, "samples=40,seed=2"},
        {{.shard = 1, .shard_count = 1, .stop_after = 4}, 6, 4, "samples=40,seed=1"},
        {{.shard = 1, .shard_count = 1, .stop_after = 9}, 6, 6, "samples=40,seed=1"},
    };
    const struct fixture *fixture = *state;
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct run run;
        struct digest digests[CASES];
        struct error error = {0};
        struct journal_search first;
        begin_sweep(&run, fixture, &cases[i].choice);
        assert_int_equal(run.record.search_count, cases[i].searches);
        assert_int_equal(run.chosen_count, cases[i].chosen);
        assert_int_equal(journal_read_search(run.journal, 0, &first, &error), STATUS_OK);
        assert_string_equal(first.name, cases[i].first);
        journal_search_fini(&first);
        assert_true(work_in_turn(&run, 3, ALL, digests));
        assert_int_equal(run.done_count, cases[i].chosen);
        run_fini(&run);
        remove_tree(fixture->folder);
    }
}

// The rest of a sweep is taken up in parts, and what does not match waits on.
static void resumed_sweep_carries_out_what_is_missing_and_matches(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct digest digests[CASES];
    struct error error = {0};
    const struct run_choice two = {.shard = 1, .shard_count = 1, .stop_after = 2};
    const struct run_choice last = {.only = "*seed=3", .shard = 1, .shard_count = 1};
    const struct run_choice none = {.only = "samples=40,seed=1", .shard = 1, .shard_count = 1};
    begin_sweep(&run, fixture, &two);
    assert_true(work_in_turn(&run, 3, ALL, digests));
    run_fini(&run);
    assert_int_equal(run_resume(&run, fixture->folder, &last, 1, 0, &error), STATUS_OK);
    assert_int_equal(run.chosen_count, 2);
    assert_true(work_in_turn(&run, 3, ALL, digests));
    assert_int_equal(run.done_count, 4);
    run_fini(&run);
    assert_int_equal(run_resume(&run, fixture->folder, &none, 1, 0, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "matches no search that is missing"));
    resume(&run, fixture->folder);
    assert_int_equal(run.chosen_count, 2);
    assert_true(work_in_turn(&run, 3, ALL, digests));
    assert_int_equal(run.done_count, CASES);
    run_fini(&run);
}

// One wrong case ends a sweep before it starts, or is left out when that is wanted; no case at all
// is an error either way.
static void invalid_case_ends_the_sweep_before_it_starts(void **state)
{
    const struct fixture *fixture = *state;
    struct sweep *sweep = sweep_of(fixture, "[40, 0, 50]", 1);
    struct run_choice choice = everything;
    struct run run;
    struct error error = {0};
    assert_int_equal(run_create_sweep(&run, fixture->folder, sweep, &choice, 1, 0, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "in the case samples=0"));
    assert_false(g_file_test(fixture->folder, G_FILE_TEST_EXISTS));

    log_start("test", LOG_QUIET);
    choice.keep_going = true;
    assert_int_equal(run_create_sweep(&run, fixture->folder, sweep, &choice, 1, 0, &error),
                     STATUS_OK);
    assert_int_equal(run.record.search_count, 2);
    run_fini(&run);
    remove_tree(fixture->folder);

    choice.only = "samples=0,*";
    assert_int_equal(run_create_sweep(&run, fixture->folder, sweep, &choice, 1, 0, &error),
                     STATUS_INVALID);
    choice.only = "nothing";
    assert_int_equal(run_create_sweep(&run, fixture->folder, sweep, &choice, 1, 0, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "samples=40"));
    assert_false(g_file_test(fixture->folder, G_FILE_TEST_EXISTS));
    sweep_free(sweep);
}

// A search whose steps were tampered with fails alone; the others go on.
static void search_that_does_not_replay_fails_alone(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct digest digests[CASES];
    struct error error = {0};
    begin_sweep(&run, fixture, &everything);
    work_in_turn(&run, 2, 6, digests);
    run_fini(&run);
    char *path = g_build_filename(fixture->folder, "run.db", NULL);
    sqlite3 *database;
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    assert_int_equal(
        sqlite3_exec(database, "UPDATE step SET step = 7, id = 7 WHERE id = 1", NULL, NULL, NULL),
        SQLITE_OK);
    sqlite3_close(database);
    g_free(path);

    resume(&run, fixture->folder);
    assert_int_equal(run_open(&run, 0, 0, &error), STATUS_REFUSED);
    assert_int_equal(run.standings[0], SEARCH_STANDING_FAILED);
    assert_true(work_in_turn(&run, 2, ALL, digests));
    assert_int_equal(run.failed_count, 1);
    assert_int_equal(run.done_count, CASES - 1);
    run_fini(&run);
}

int main(void)
{
#define RUN_TEST(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
    const struct CMUnitTest tests[] = {
        RUN_TEST(resumed_run_ends_with_the_digest_of_an_uninterrupted_one),
        RUN_TEST(folder_with_something_in_it_is_refused_and_left_alone),
        RUN_TEST(abandoned_run_leaves_nothing_of_its_own),
        RUN_TEST(finished_run_is_not_resumed),
        RUN_TEST(folder_without_a_run_is_not_resumed),
        RUN_TEST(case_ends_as_its_scenario_alone_wherever_the_sweep_was_interrupted),
        RUN_TEST(only_open_searches_hold_memory),
        RUN_TEST(choice_leaves_the_searches_it_names),
        RUN_TEST(resumed_sweep_carries_out_what_is_missing_and_matches),
        RUN_TEST(invalid_case_ends_the_sweep_before_it_starts),
        RUN_TEST(search_that_does_not_replay_fails_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
