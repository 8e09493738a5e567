// What a monitor makes of the status messages it hears.
#include "monitor/feed/feed.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
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

static sobox_worker_status_t worker_message(int64_t sender, int64_t uptime_ns, int64_t samples)
{
    sobox_worker_status_t message = {.header.sender = sender,
                                     .process = 42,
                                     .threads = 4,
                                     .uptime_ns = uptime_ns,
                                     .busy_ns = uptime_ns / 2,
                                     .samples = samples};
    strcpy((char *)message.host, "crash1");
    return message;
}

// The rate is what changed between two messages, not an average since the start, which would hide
// that a worker has just stalled.
static void worker_rate_is_between_its_last_two_messages(void **state)
{
    struct feed *feed = *state;
    sobox_worker_status_t first = worker_message(7, 10 * SECOND, 1000000);
    sobox_worker_status_t second = worker_message(7, 12 * SECOND, 1000500);
    feed_worker_heard(feed, &first, 1);
    feed_worker_heard(feed, &second, 2);
    assert_int_equal(feed->workers->len, 1);
    const struct feed_worker *worker = feed->workers->pdata[0];
    assert_string_equal(worker->name, "crash1/42");
    assert_float_equal(worker->rate, 250, 1e-9);
    assert_float_equal(worker->busy, 0.5, 1e-9);
}

// The network may deliver an old message after a newer one: the picture must not turn back.
static void late_message_does_not_turn_the_picture_back(void **state)
{
    struct feed *feed = *state;
    double bounds[2] = {1, 2};
    sobox_search_status_t newer = {.header.run = 5, .step = 9, .bound_count = 2, .bounds = bounds};
    sobox_search_status_t older = {.header.run = 5, .step = 8, .log_volume = -3};
    feed_search_heard(feed, &newer, 1);
    feed_search_heard(feed, &older, 2);
    const struct feed_search *search = feed_search_find(feed, 5, 0);
    assert_int_equal(search->step, 9);
    assert_float_equal(search->log_volume, 0, 0);
    assert_int_equal(search->bounds->len, 2);
    assert_null(feed_search_find(feed, 6, 0));
}

// A name from the network must not be able to drive the user's terminal.
static void control_characters_in_names_are_shown_as_question_marks(void **state)
{
    struct feed *feed = *state;
    sobox_run_status_t message = {.header.run = 5};
    strcpy((char *)message.name, "sedan\x1b[2J\n");
    feed_run_heard(feed, &message, 1);
    assert_string_equal(((struct feed_run *)feed->runs->pdata[0])->name, "sedan?[2J?");
}

// A flood of invented workers and runs costs a bounded memory, and the newest stay visible.
static void tables_are_bounded_and_keep_the_newest(void **state)
{
    struct feed *feed = *state;
    for (int64_t i = 1; i <= FEED_WORKER_MAX + 10; i++) {
        sobox_worker_status_t message = worker_message(i, SECOND, 0);
        feed_worker_heard(feed, &message, i);
    }
    assert_int_equal(feed->workers->len, FEED_WORKER_MAX);
    const struct feed_worker *last = feed->workers->pdata[FEED_WORKER_MAX - 1];
    assert_int_equal(last->id, FEED_WORKER_MAX + 10);
    for (int64_t i = 1; i <= FEED_RUN_MAX + 3; i++) {
        sobox_run_status_t message = {.header.run = i};
        feed_run_heard(feed, &message, i);
    }
    assert_int_equal(feed->runs->len, FEED_RUN_MAX);
    assert_int_equal(((struct feed_run *)feed->runs->pdata[0])->id, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(worker_rate_is_between_its_last_two_messages, feed_setup,
                                        feed_teardown),
        cmocka_unit_test_setup_teardown(late_message_does_not_turn_the_picture_back, feed_setup,
                                        feed_teardown),
        cmocka_unit_test_setup_teardown(control_characters_in_names_are_shown_as_question_marks,
                                        feed_setup, feed_teardown),
        cmocka_unit_test_setup_teardown(tables_are_bounded_and_keep_the_newest, feed_setup,
                                        feed_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
