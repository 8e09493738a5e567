// A run and its journal: begun, taken up again, refused, abandoned. The model is a plane cut
// through the design space, so that no kernel is needed.
#include "coordinator/runtime/run.h"

#include "common/scenario/scenario_read.h"
#include "worker/sampling/sampling.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <setjmp.h>
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
                           "    force_x: {lower: 0, upper: 1}\n"
                           "    force_y: {lower: 0, upper: 1}\n"
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
            sum += values[(size_t)v * samples + i];
        search->verdicts[i].constraint = 0;
        search->verdicts[i].violation = verdict_violation(sum / count - 0.6);
    }
    free(values);
}

// Works on the run until it is done or `steps` steps are complete. Returns whether it is done.
static bool work(struct run *run, unsigned steps)
{
    struct error error = {0};
    for (unsigned i = 0; i < steps; i++) {
        bool wanted = false;
        assert_int_equal(run_next(run, 0, 0, &wanted, &error), STATUS_OK);
        if (!wanted)
            return true;
        judge(&run->searches[0]);
        assert_int_equal(run_complete(run, 0, &error), STATUS_OK);
    }
    return false;
}

static void begin(struct run *run, const char *folder)
{
    struct scenario scenario = scenario_of(text);
    struct error error = {0};
    if (run_create(run, folder, &scenario, 1, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_null(scenario.text);
}

static struct digest digest_of_run(const struct run *run)
{
    struct search_result result;
    search_result(run->searches[0].search, &result);
    return result.digest;
}

enum { ALL = 100000 };

// The digest must not depend on where a run was interrupted: after every single step once.
static void resumed_run_ends_with_the_digest_of_an_uninterrupted_one(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct error error = {0};
    begin(&run, fixture->folder);
    assert_true(work(&run, ALL));
    const struct digest whole = digest_of_run(&run);
    const uint32_t steps = search_last_step(run.searches[0].search)->step + 1;
    run_fini(&run);

    for (uint32_t at = 0; at <= steps; at++) {
        remove_tree(fixture->folder);
        begin(&run, fixture->folder);
        work(&run, at);
        assert_int_equal(run_end(&run, JOURNAL_STATE_INTERRUPTED, 5, &error), STATUS_OK);
        run_fini(&run);
        if (run_resume(&run, fixture->folder, 1, 0, &error) != STATUS_OK)
            fail_msg("%s", error.text);
        assert_int_equal(run.record.elapsed_ns, 5);
        assert_true(work(&run, ALL));
        const struct digest resumed = digest_of_run(&run);
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
    assert_true(work(&run, ALL));
    assert_int_equal(run_end(&run, JOURNAL_STATE_DONE, 1, &error), STATUS_OK);
    run_fini(&run);
    assert_int_equal(run_resume(&run, fixture->folder, 1, 0, &error), STATUS_REFUSED);
    assert_non_null(strstr(error.text, "sobox-report"));
}

// A folder without a run is the user's mistake, said as such.
static void folder_without_a_run_is_not_resumed(void **state)
{
    const struct fixture *fixture = *state;
    struct run run;
    struct error error = {0};
    assert_int_equal(run_resume(&run, fixture->parent, 1, 0, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, fixture->parent));
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
