// Metrics whose names and numbers come from the network.
#include "monitor/http/metrics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static int setup(void **state)
{
    static struct feed feed;
    feed_init(&feed);
    *state = &feed;
    return 0;
}

static int teardown(void **state)
{
    feed_fini(*state);
    return 0;
}

static void assert_told(const struct feed *feed, const char *line)
{
    g_autoptr(GString) text = g_string_new(NULL);
    metrics_write(feed, 0, text);
    if (strstr(text->str, line) == NULL)
        fail_msg("expected %s in:\n%s", line, text->str);
}

// A name with a quote in it must not be able to end its label and begin a metric of its own.
static void names_cannot_leave_their_label(void **state)
{
    struct feed *feed = *state;
    sobox_run_status_t run = {.header = {.sender = 1, .run = 255}};
    strcpy((char *)run.name, "a\"} 1\nsobox_x{b=\"\\");
    feed_run_heard(feed, &run, 0);
    assert_told(
        feed, "sobox_run_info{run=\"00000000000000ff\",name=\"a\\\"} 1?sobox_x{b=\\\"\\\\\"} 1\n");
}

static void odd_numbers_are_written_as_prometheus_reads_them(void **state)
{
    struct feed *feed = *state;
    sobox_search_status_t search = {
        .header = {.sender = 1, .run = 255}, .good_share = NAN, .log_volume = -INFINITY};
    feed_search_heard(feed, &search, 0);
    assert_told(feed, "sobox_search_good_ratio{run=\"00000000000000ff\",search=\"0\"} NaN\n");
    assert_told(feed, "sobox_search_log_volume{run=\"00000000000000ff\",search=\"0\"} -Inf\n");
}

// Thousands of searches would be thousands of series.
static void few_searches_are_told_of(void **state)
{
    struct feed *feed = *state;
    for (int32_t i = 0; i < 1000; i++) {
        sobox_search_status_t search = {.header = {.sender = 1, .sequence = i, .run = 255},
                                        .search = i};
        feed_search_heard(feed, &search, 0);
    }
    g_autoptr(GString) text = g_string_new(NULL);
    metrics_write(feed, 0, text);
    unsigned count = 0;
    for (const char *c = text->str; (c = strstr(c, "sobox_search_steps{")) != NULL; c++)
        count++;
    assert_int_equal(count, METRICS_SEARCH_MAX);
}

#define TEST(claim) cmocka_unit_test_setup_teardown(claim, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(names_cannot_leave_their_label),
        TEST(odd_numbers_are_written_as_prometheus_reads_them),
        TEST(few_searches_are_told_of),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
