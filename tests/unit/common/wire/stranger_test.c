#include "messages.h"

#include "common/base/log.h"
#include "common/wire/stranger.h"

static const int64_t second_ns = INT64_C(1000000000);

// The first one matters at once: a worker with another key is there and not used.
static void first_message_is_told(void **state)
{
    (void)state;
    struct strangers strangers = {0};
    assert_true(stranger_heard(&strangers, STRANGER_OTHER_KEY, 1, 0));
    assert_false(stranger_heard(&strangers, STRANGER_OTHER_KEY, 1, 0));
    assert_true(stranger_heard(&strangers, STRANGER_NO_KEY, 1, 0)); // each for itself
}

// A worker that speaks once a second is told of now and then.
static void later_ones_are_told_ever_more_seldom(void **state)
{
    (void)state;
    struct strangers strangers = {0};
    unsigned told = 0;
    for (int64_t second = 0; second < 3600; second++)
        told += stranger_heard(&strangers, STRANGER_SEALED, 1, second * second_ns);
    assert_in_range(told, 5, 12);
    assert_int_equal(strangers.of[STRANGER_SEALED].heard, 3600);
}

// A flood gives no flood of lines: at most one in ten seconds.
static void flood_gives_few_lines(void **state)
{
    (void)state;
    struct strangers strangers = {0};
    unsigned told = 0;
    for (int64_t i = 0; i < 1000000; i++)
        told += stranger_heard(&strangers, STRANGER_NO_KEY, 1, i * second_ns / 100000);
    assert_int_equal(told, 1);
}

static void nothing_heard_is_nothing_told(void **state)
{
    (void)state;
    struct strangers strangers = {0};
    assert_false(stranger_heard(&strangers, STRANGER_SILENT, 0, 0));
    assert_true(stranger_heard(&strangers, STRANGER_SILENT, 70, 0));
    assert_false(stranger_heard(&strangers, STRANGER_SILENT, 0, 100 * second_ns));
}

// The last words of a program that has just ended are no recording.
static void few_unanswered_messages_are_not_worth_a_line(void **state)
{
    (void)state;
    struct strangers strangers = {0};
    assert_false(stranger_heard(&strangers, STRANGER_SILENT, 3, 0));
    assert_true(stranger_heard(&strangers, STRANGER_SILENT, 30, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_message_is_told),
        cmocka_unit_test(later_ones_are_told_ever_more_seldom),
        cmocka_unit_test(flood_gives_few_lines),
        cmocka_unit_test(nothing_heard_is_nothing_told),
        cmocka_unit_test(few_unanswered_messages_are_not_worth_a_line),
    };
    log_start("stranger_test", LOG_QUIET);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
