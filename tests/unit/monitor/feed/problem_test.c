// Problems in plain words: each is told when it is there, and nothing else is.
#include "monitor/feed/problem.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define SECOND INT64_C(1000000000)

static int feed_setup(void **state)
{
    static struct feed feed;
    feed_init(&feed);
    *state = &feed;
    return 0;
}

static int feed_teardown(void **state)
{
    feed_fini(*state);
    return 0;
}

// A worker that has evaluated `batches` after `second` seconds, of which `lost` did not reach it.
static void hear_worker(struct feed *feed, int64_t second, int64_t batches, int64_t lost, int queue)
{
    sobox_worker_status_t message = {
        .header = {.sender = 9, .sequence = (int32_t)second},
        .process = 42,
        .threads = 2,
        .queue = queue,
        .batches = batches,
        .lost = lost,
        .uptime_ns = second * SECOND,
    };
    strcpy((char *)message.host, "host7");
    feed_worker_heard(feed, &message, second * SECOND);
}

static sobox_run_status_t run_message(int64_t second)
{
    sobox_run_status_t message = {
        .header = {.sender = 3, .sequence = (int32_t)second, .run = 5},
        .searches = 1,
        .workers = 1,
        .batches = 100 * second,
        .elapsed_ns = second * SECOND,
    };
    strcpy((char *)message.name, "sedan");
    return message;
}

static void assert_problem(const struct feed *feed, int64_t now_ns, const char *text)
{
    GArray *problems = problem_list(feed, now_ns);
    bool found = false;
    for (guint i = 0; i < problems->len; i++)
        found |= strstr(g_array_index(problems, struct problem, i).text, text) != NULL;
    for (guint i = 0; i < problems->len && !found; i++)
        print_message("%s\n", g_array_index(problems, struct problem, i).text);
    g_array_free(problems, TRUE);
    if (!found)
        fail_msg("expected a problem: %s", text);
}

static void assert_no_problem(const struct feed *feed, int64_t now_ns)
{
    GArray *problems = problem_list(feed, now_ns);
    const guint count = problems->len;
    if (count > 0)
        print_message("%s\n", g_array_index(problems, struct problem, 0).text);
    g_array_free(problems, TRUE);
    assert_int_equal(count, 0);
}

// A healthy cluster is told to be one by silence, also after the run is over.
static void healthy_run_has_no_problem(void **state)
{
    struct feed *feed = *state;
    for (int64_t second = 0; second < 10; second++) {
        sobox_run_status_t run = run_message(second);
        feed_run_heard(feed, &run, second * SECOND);
        hear_worker(feed, second, 100 * second, 0, 4);
    }
    assert_no_problem(feed, 9 * SECOND);
    sobox_run_status_t done = run_message(10);
    done.state = RUN_STATE_DONE;
    feed_run_heard(feed, &done, 10 * SECOND);
    hear_worker(feed, 10, 1000, 0, 0);
    hear_worker(feed, 11, 1000, 0, 0);
    assert_no_problem(feed, 11 * SECOND);
}

static void silent_worker_is_named_with_the_batches_it_held(void **state)
{
    struct feed *feed = *state;
    hear_worker(feed, 1, 10, 0, 3);
    assert_problem(feed, 13 * SECOND,
                   "worker host7/42 is silent since 12 s: the batches it held (3)");
}

// Dozens of workers go silent at once when a switch does: the list stays readable.
static void many_silent_workers_are_counted(void **state)
{
    struct feed *feed = *state;
    for (int64_t i = 0; i < 50; i++) {
        sobox_worker_status_t message = {.header.sender = 100 + i, .threads = 1};
        feed_worker_heard(feed, &message, 0);
    }
    assert_problem(feed, 10 * SECOND, "42 more workers are silent");
}

static void silent_coordinator_is_named(void **state)
{
    struct feed *feed = *state;
    sobox_run_status_t run = run_message(1);
    feed_run_heard(feed, &run, SECOND);
    assert_problem(feed, 6 * SECOND, "sedan: its coordinator is silent since 5 s");
}

static void waiting_and_refused_are_told_with_the_remedy(void **state)
{
    struct feed *feed = *state;
    sobox_run_status_t run = run_message(1);
    run.state = RUN_STATE_WAITING;
    run.workers_refused = 2;
    feed_run_heard(feed, &run, SECOND);
    assert_problem(feed, SECOND, "sedan waits for workers: start sobox-worker");
    assert_problem(feed, SECOND, "2 workers are refused");
}

static void batches_handed_out_again_are_a_share(void **state)
{
    struct feed *feed = *state;
    for (int64_t second = 1; second <= 5; second++) {
        sobox_run_status_t run = run_message(second);
        run.released = 25 * second;
        feed_run_heard(feed, &run, second * SECOND);
    }
    assert_problem(feed, 5 * SECOND, "20 % of the batches are handed out again");
}

// What was lost before the monitor came, or long ago, is no problem of now.
static void losses_of_now_are_told_with_the_remedy(void **state)
{
    struct feed *feed = *state;
    for (int64_t second = 1; second <= 5; second++) {
        sobox_run_status_t run = run_message(second);
        run.lost = 5000 + 43 * second;
        feed_run_heard(feed, &run, second * SECOND);
        hear_worker(feed, second, 50 * second, 50 * second, 1);
    }
    assert_problem(feed, 5 * SECOND,
                   "sedan: 30 % of the messages to its coordinator are lost: raise "
                   "net.core.rmem_max");
    assert_problem(feed, 5 * SECOND, "worker host7/42: 50 % of the messages to it are lost");
    for (int64_t second = 6; second <= 60; second++) {
        sobox_run_status_t run = run_message(second);
        run.lost = 5000 + 43 * 5;
        feed_run_heard(feed, &run, second * SECOND);
        hear_worker(feed, second, 50 * second, 250, 1);
    }
    assert_no_problem(feed, 60 * SECOND);
}

static void idle_workers_beside_waiting_batches_are_told(void **state)
{
    struct feed *feed = *state;
    for (int64_t second = 1; second <= 5; second++) {
        sobox_run_status_t run = run_message(second);
        feed_run_heard(feed, &run, second * SECOND);
        hear_worker(feed, second, 10, 0, 0);
        sobox_worker_status_t busy = {
            .header = {.sender = 10, .sequence = (int32_t)second},
            .threads = 2,
            .queue = 8,
            .batches = second,
        };
        feed_worker_heard(feed, &busy, second * SECOND);
    }
    assert_problem(feed, 5 * SECOND, "1 worker is idle while 6 batches wait at others");
}

static void deaf_monitor_says_so(void **state)
{
    struct feed *feed = *state;
    feed_own_counted(feed, &(struct feed_own){0}, SECOND);
    feed_own_counted(feed, &(struct feed_own){.received = 60, .lost = 40}, 2 * SECOND);
    assert_problem(feed, 2 * SECOND, "this monitor misses 40 % of the messages");
}

#define TEST(claim) cmocka_unit_test_setup_teardown(claim, feed_setup, feed_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(healthy_run_has_no_problem),
        TEST(silent_worker_is_named_with_the_batches_it_held),
        TEST(many_silent_workers_are_counted),
        TEST(silent_coordinator_is_named),
        TEST(waiting_and_refused_are_told_with_the_remedy),
        TEST(batches_handed_out_again_are_a_share),
        TEST(losses_of_now_are_told_with_the_remedy),
        TEST(idle_workers_beside_waiting_batches_are_told),
        TEST(deaf_monitor_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
