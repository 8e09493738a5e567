// Threads beside the loop, at the work that most of them do: trimming searches. The main loop is
// the test's own.
#include "coordinator/runtime/pool.h"

#include "common/scenario/scenario_read.h"
#include "coordinator/runtime/run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

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
                           "search: {promise: points}\n"; // whose steps all have as many samples

enum { SEARCHES = 40, STEPS = 8, SAMPLES = 200 };

struct fixture {
    struct scenario scenario;
    struct run_search searches[SEARCHES];
    struct pool *pool;
    GMainLoop *loop;
    unsigned told;
};

// Bad above a plane that each search has at a place of its own.
static void judge(struct run_search *search)
{
    search_request(search->search, &search->request);
    for (uint32_t i = 0; i < search->request.sampling.samples; i++)
        search->verdicts[i].violation = (i + search->index) % 5 == 0 ? (uint16_t)(i + 1) : 0;
}

static void trim(void *search)
{
    run_trim(search);
}

static void heard(void *user, GPtrArray *searches)
{
    struct fixture *fixture = user;
    for (guint i = 0; i < searches->len; i++) {
        struct run_search *search = searches->pdata[i];
        if (search_last_step(search->search)->step + 1 < STEPS) {
            judge(search);
            pool_take(fixture->pool, search);
        } else {
            fixture->told++;
        }
    }
    if (fixture->told == SEARCHES)
        g_main_loop_quit(fixture->loop);
}

static void start(struct fixture *fixture)
{
    struct error error = {0};
    *fixture = (struct fixture){.loop = g_main_loop_new(NULL, FALSE)};
    if (scenario_read_text(&fixture->scenario, "plane.yaml", text, strlen(text), NULL, 0, &error) !=
        STATUS_OK)
        fail_msg("%s", error.text);
    for (uint32_t i = 0; i < SEARCHES; i++) {
        fixture->searches[i].index = i;
        fixture->searches[i].search = search_create(&fixture->scenario, 1 + i, 1);
        fixture->searches[i].verdicts = g_new0(struct verdict, SAMPLES);
    }
}

static void end(struct fixture *fixture)
{
    for (uint32_t i = 0; i < SEARCHES; i++) {
        search_free(fixture->searches[i].search);
        g_free(fixture->searches[i].verdicts);
    }
    scenario_fini(&fixture->scenario);
    g_main_loop_unref(fixture->loop);
}

static void trim_all(struct fixture *fixture, int threads)
{
    struct error error = {0};
    assert_int_equal(pool_create(&fixture->pool, threads, trim, heard, fixture, &error), STATUS_OK);
    for (uint32_t i = 0; i < SEARCHES; i++) {
        judge(&fixture->searches[i]);
        pool_take(fixture->pool, &fixture->searches[i]);
    }
    assert_true(pool_load(fixture->pool) == (double)SEARCHES / threads);
    g_main_loop_run(fixture->loop);
    assert_true(pool_load(fixture->pool) == 0);
    pool_free(fixture->pool);
}

// Every search comes back once for each step, and its result is that of one thread, whatever the
// threads' timing.
static void searches_come_back_with_the_same_results_from_any_number_of_threads(void **state)
{
    (void)state;
    struct fixture one, many;
    start(&one);
    start(&many);
    trim_all(&one, 1);
    trim_all(&many, 4);
    for (uint32_t i = 0; i < SEARCHES; i++) {
        struct search_result a, b;
        search_result(one.searches[i].search, &a);
        search_result(many.searches[i].search, &b);
        assert_true(digest_equal(&a.digest, &b.digest));
    }
    end(&one);
    end(&many);
}

// A run that is interrupted frees the threads while they work.
static void threads_end_in_the_middle_of_work(void **state)
{
    (void)state;
    struct fixture fixture;
    start(&fixture);
    struct error error = {0};
    assert_int_equal(pool_create(&fixture.pool, 2, trim, heard, &fixture, &error), STATUS_OK);
    for (uint32_t i = 0; i < SEARCHES; i++) {
        judge(&fixture.searches[i]);
        pool_take(fixture.pool, &fixture.searches[i]);
    }
    pool_free(fixture.pool);
    pool_free(NULL);
    assert_int_equal(fixture.told, 0);
    end(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(searches_come_back_with_the_same_results_from_any_number_of_threads),
        cmocka_unit_test(threads_end_in_the_middle_of_work),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
