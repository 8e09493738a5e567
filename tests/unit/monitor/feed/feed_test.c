// What a monitor makes of the status messages it hears: recorded in the tests, lost, doubled, late,
// of two runs at once, of programs started anew.
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
                                     .header.sequence = (int32_t)(uptime_ns / SECOND),
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
    assert_int_equal(feed->workers.entries->len, 1);
    const struct feed_worker *worker = feed_worker_at(feed, 0);
    assert_string_equal(worker->name, "crash1/42");
    assert_float_equal(worker->rate, 250, 1e-9);
    assert_float_equal(worker->busy, 0.5, 1e-9);
}

static sobox_search_status_t search_message(int64_t sender, int32_t sequence, int32_t step)
{
    return (sobox_search_status_t){
        .header = {.sender = sender, .sequence = sequence, .run = 5},
        .step = step,
        .step_count = 100,
        .log_volume = -step,
    };
}

static void hear_search(struct feed *feed, int64_t sender, int32_t sequence, int32_t step,
                        int64_t now_ns)
{
    sobox_search_status_t message = search_message(sender, sequence, step);
    feed_search_heard(feed, &message, now_ns);
}

// The network may deliver an old message after a newer one: the picture must not turn back, also
// when both are of the same step.
static void late_message_does_not_turn_the_picture_back(void **state)
{
    struct feed *feed = *state;
    double bounds[2] = {1, 2};
    sobox_search_status_t newer = search_message(7, 3, 9);
    newer.variables = 1;
    newer.bound_count = 2;
    newer.bounds = bounds;
    newer.status = 1;
    sobox_search_status_t older = search_message(7, 2, 9);
    feed_search_heard(feed, &newer, 1);
    feed_search_heard(feed, &older, 2);
    const struct feed_search *search = feed_search_find(feed, 5, 0);
    assert_int_equal(search->step, 9);
    assert_int_equal(search->status, 1);
    assert_int_equal(search->bounds->len, 2);
    assert_null(feed_search_find(feed, 6, 0));
}

// A message that comes twice changes nothing, so that nobody is told of news that are none.
static void doubled_message_is_no_news(void **state)
{
    struct feed *feed = *state;
    hear_search(feed, 7, 1, 1, 1);
    const uint64_t version = feed->version;
    hear_search(feed, 7, 1, 1, 2);
    assert_int_equal(feed->version, version);
}

// A search that is over is told of again and again, for monitors that come late: whoever has heard
// of it is not sent it again.
static void search_that_is_over_is_no_news_twice(void **state)
{
    struct feed *feed = *state;
    sobox_search_status_t message = search_message(7, 1, 9);
    message.standing = SEARCH_STANDING_DONE;
    message.status = 1;
    feed_search_heard(feed, &message, 1);
    const uint64_t version = feed->version;
    message.header.sequence = 2;
    feed_search_heard(feed, &message, 2);
    assert_int_equal(feed->version, version);
    assert_string_equal(feed_search_word(feed_search_find(feed, 5, 0)), "done");
}

// A box that fits no message comes in parts, in any order; nothing is drawn of half a box.
static void box_in_parts_is_shown_when_it_is_whole(void **state)
{
    struct feed *feed = *state;
    sobox_search_status_t message = search_message(7, 1, 1);
    message.variables = 3;
    message.first_variable = 1;
    message.bound_count = 4;
    message.bounds = (double[]){2, 3, 20, 30};
    feed_search_heard(feed, &message, 1);
    const GArray *bounds = feed_search_find(feed, 5, 0)->bounds;
    assert_int_equal(bounds->len, 0);
    message.header.sequence = 2;
    message.first_variable = 0;
    message.bound_count = 2;
    message.bounds = (double[]){1, 10};
    feed_search_heard(feed, &message, 2);
    assert_int_equal(bounds->len, 6);
    for (guint i = 0; i < 3; i++) {
        assert_float_equal(g_array_index(bounds, double, i), i + 1, 0);
        assert_float_equal(g_array_index(bounds, double, 3 + i), 10 * (i + 1), 0);
    }
}

// Samples are kept of the searches heard of last, so that a sweep does not fill the memory.
static void samples_of_many_searches_are_bounded(void **state)
{
    struct feed *feed = *state;
    uint8_t packed[1 + 32] = {1};
    for (int32_t i = 0; i < 3 * FEED_ALBUM_MAX; i++) {
        const sobox_step_status_t message = {
            .header = {.sender = 7, .sequence = i, .run = 5},
            .search = i,
            .samples = 1,
            .count = 1,
            .variables = 1,
            .window = 1,
            .packed_size = sizeof packed,
            .packed = packed,
        };
        feed_step_heard(feed, &message, i);
    }
    assert_int_equal(feed->albums.length, FEED_ALBUM_MAX);
    assert_null(feed_search_find(feed, 5, 0)->album);
    assert_non_null(feed_search_find(feed, 5, 3 * FEED_ALBUM_MAX - 1)->album);
}

// A coordinator that was killed and continues the run is another sender and counts its messages
// anew. What it says holds, even where it stands some steps before what was shown; what the killed
// one said last may still come late and does not.
static void restarted_coordinator_is_believed(void **state)
{
    struct feed *feed = *state;
    hear_search(feed, 7, 500, 40, 1);
    hear_search(feed, 7, 501, 41, 2);
    hear_search(feed, 8, 0, 40, 3);
    const struct feed_search *search = feed_search_find(feed, 5, 0);
    assert_int_equal(search->step, 40);
    assert_int_equal(search->steps.points->len, 1);
    hear_search(feed, 7, 502, 42, 4);
    assert_int_equal(search->step, 40);
}

// A recording that is played a second time is shown a second time, once the first is over.
static void recording_may_be_played_again(void **state)
{
    struct feed *feed = *state;
    hear_search(feed, 7, 1, 1, 0);
    hear_search(feed, 7, 2, 2, 1);
    hear_search(feed, 7, 1, 1, FEED_SILENCE_NS + 2);
    assert_int_equal(feed_search_find(feed, 5, 0)->step, 1);
}

// Two runs at once have searches of the same number: nothing of one may show in the other.
static void two_runs_are_never_mixed(void **state)
{
    struct feed *feed = *state;
    for (int32_t i = 0; i < 20; i++) {
        sobox_search_status_t message = search_message(7 + i % 2, i, i);
        message.header.run = 5 + i % 2;
        message.log_volume = i % 2 ? -1 : -2;
        feed_search_heard(feed, &message, i);
    }
    for (guint run = 0; run < 2; run++) {
        const struct feed_search *search = feed_search_find(feed, 5 + run, 0);
        assert_int_equal(search->steps.points->len, 10);
        for (guint i = 0; i < 10; i++) {
            const struct feed_step *step =
                &g_array_index(search->steps.points, struct feed_step, i);
            assert_int_equal(step->step % 2, run);
            assert_float_equal(step->log_volume, run ? -1 : -2, 0);
        }
    }
}

// Ten messages a second say the same step again while it lasts: the course has one point for it.
static void step_is_one_point_of_the_course(void **state)
{
    struct feed *feed = *state;
    for (int32_t i = 0; i < 30; i++)
        hear_search(feed, 7, i, i / 10, i);
    const struct feed_search *search = feed_search_find(feed, 5, 0);
    assert_int_equal(search->steps.points->len, 3);
}

// Thousands of searches and of steps: memory is bounded, the newest search stays, and no message
// looks through the others (this test would take minutes).
static void thousands_of_searches_are_found_at_once(void **state)
{
    struct feed *feed = *state;
    for (int32_t step = 0; step < 20; step++) {
        for (int32_t i = 0; i < FEED_SEARCH_MAX + 10; i++) {
            sobox_search_status_t message = search_message(7, step * 100000 + i, step);
            message.search = i;
            feed_search_heard(feed, &message, step);
        }
    }
    assert_int_equal(feed->searches.entries->len, FEED_SEARCH_MAX);
    assert_true(feed->searches.removed > 0);
    assert_non_null(feed_search_find(feed, 5, FEED_SEARCH_MAX + 9));
}

// A name from the network must not be able to drive the user's terminal.
static void control_characters_in_names_are_shown_as_question_marks(void **state)
{
    struct feed *feed = *state;
    sobox_run_status_t message = {.header.run = 5};
    strcpy((char *)message.name, "sedan\x1b[2J\n\xff\xc2\x9b");
    feed_run_heard(feed, &message, 1);
    assert_string_equal(feed_run_find(feed, 5)->name, "sedan?[2J????");
}

// A flood of invented workers and runs costs a bounded memory, and the newest stay visible.
static void tables_are_bounded_and_keep_the_newest(void **state)
{
    struct feed *feed = *state;
    for (int64_t i = 1; i <= FEED_WORKER_MAX + 10; i++) {
        sobox_worker_status_t message = worker_message(i, SECOND, 0);
        feed_worker_heard(feed, &message, i);
    }
    assert_int_equal(feed->workers.entries->len, FEED_WORKER_MAX);
    assert_int_equal(feed_worker_at(feed, FEED_WORKER_MAX - 1)->entry.key[0], FEED_WORKER_MAX + 10);
    for (int64_t i = 1; i <= FEED_RUN_MAX + 3; i++) {
        sobox_run_status_t message = {.header.run = i};
        feed_run_heard(feed, &message, i);
    }
    assert_int_equal(feed->runs.entries->len, FEED_RUN_MAX);
    assert_int_equal(feed_run_at(feed, 0)->id, 4);
}

// Who has gone makes room: at once after a good-bye, after a long silence else.
static void workers_that_are_gone_are_forgotten(void **state)
{
    struct feed *feed = *state;
    sobox_worker_status_t stays = worker_message(1, SECOND, 0);
    sobox_worker_status_t leaves = worker_message(2, SECOND, 0);
    leaves.leaving = 1;
    feed_worker_heard(feed, &stays, 0);
    feed_worker_heard(feed, &leaves, 0);
    feed_tick(feed, FEED_LEFT_NS);
    assert_int_equal(feed->workers.entries->len, 2);
    feed_tick(feed, FEED_LEFT_NS + 1);
    assert_int_equal(feed->workers.entries->len, 1);
    feed_tick(feed, FEED_FORGET_NS + 1);
    assert_int_equal(feed->workers.entries->len, 0);
}

// The time left follows the pace of the steps, or of the searches where there are many.
static void time_left_follows_the_pace(void **state)
{
    struct feed *feed = *state;
    sobox_run_status_t run = {.header.run = 5, .searches = 1, .elapsed_ns = 10 * SECOND};
    feed_run_heard(feed, &run, 0);
    assert_true(feed_run_left_s(feed, feed_run_find(feed, 5)) < 0);
    hear_search(feed, 7, 2, 40, SECOND);
    assert_float_equal(feed_run_left_s(feed, feed_run_find(feed, 5)), 15, 1e-9);
    run = (sobox_run_status_t){
        .header = {.sender = 7, .sequence = 1, .run = 6},
        .searches = 100,
        .searches_done = 10,
        .elapsed_ns = 5 * SECOND,
    };
    feed_run_heard(feed, &run, SECOND);
    assert_float_equal(feed_run_left_s(feed, feed_run_find(feed, 6)), 45, 1e-9);
}

#define TEST(claim) cmocka_unit_test_setup_teardown(claim, feed_setup, feed_teardown)

// Where there are thousands of workers each speaks less often, and is not called silent for it.
static void worker_among_thousands_may_be_silent_for_longer(void **state)
{
    struct feed *feed = *state;
    for (int64_t sender = 1; sender <= 2000; sender++) {
        const sobox_worker_status_t message = {.header.sender = sender, .threads = 1};
        feed_worker_heard(feed, &message, 0);
    }
    assert_int_equal(feed_worker_at(feed, 0)->silence_ns, FEED_SILENCE_NS);
    assert_int_equal(feed_worker_at(feed, 1999)->silence_ns, 8 * FEED_SILENCE_NS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(worker_rate_is_between_its_last_two_messages),
        TEST(worker_among_thousands_may_be_silent_for_longer),
        TEST(late_message_does_not_turn_the_picture_back),
        TEST(doubled_message_is_no_news),
        TEST(search_that_is_over_is_no_news_twice),
        TEST(box_in_parts_is_shown_when_it_is_whole),
        TEST(samples_of_many_searches_are_bounded),
        TEST(restarted_coordinator_is_believed),
        TEST(recording_may_be_played_again),
        TEST(two_runs_are_never_mixed),
        TEST(step_is_one_point_of_the_course),
        TEST(thousands_of_searches_are_found_at_once),
        TEST(control_characters_in_names_are_shown_as_question_marks),
        TEST(tables_are_bounded_and_keep_the_newest),
        TEST(workers_that_are_gone_are_forgotten),
        TEST(time_left_follows_the_pace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
