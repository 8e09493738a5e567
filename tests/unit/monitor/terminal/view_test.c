// The screen as lines: what stands on it, and that it fits whatever the terminal's size.
#include "monitor/terminal/view.h"

#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define SECOND INT64_C(1000000000)

struct fixture {
    struct feed feed;
    struct view_state state;
    GArray *lines;
};

static void hear_run(struct feed *feed, int64_t run, const char *name, int64_t now_ns)
{
    sobox_run_status_t message = {
        .header = {.sender = run, .sequence = (int32_t)(now_ns / SECOND), .run = run},
        .searches = 3,
        .samples = 5390000,
        .elapsed_ns = now_ns,
    };
    strcpy((char *)message.name, name);
    feed_run_heard(feed, &message, now_ns);
}

static void hear_step(struct feed *feed, int32_t search, int32_t step, double log_volume)
{
    sobox_search_status_t message = {
        .header = {.sender = 5, .sequence = step * 8 + search, .run = 5},
        .search = search,
        .standing = SEARCH_STANDING_OPEN,
        .phase = 1,
        .step = step,
        .step_count = 20,
        .good_share = 0.7,
        .log_volume = log_volume,
    };
    feed_search_heard(feed, &message, SECOND);
}

static void hear_worker(struct feed *feed, int64_t sender, const char *host, int64_t samples)
{
    sobox_worker_status_t message = {
        .header = {.sender = sender, .sequence = 1},
        .process = 42,
        .threads = 8,
        .uptime_ns = SECOND,
        .samples = samples,
    };
    strcpy((char *)message.host, host);
    feed_worker_heard(feed, &message, SECOND);
}

static int setup(void **state)
{
    struct fixture *fixture = g_new0(struct fixture, 1);
    feed_init(&fixture->feed);
    fixture->lines = g_array_new(FALSE, FALSE, sizeof(struct view_line));
    fixture->state = (struct view_state){.width = 120, .height = 40, .unicode = true};
    hear_run(&fixture->feed, 5, "sedan", SECOND);
    for (int32_t step = 0; step < 10; step++)
        hear_step(&fixture->feed, 0, step, step == 0 ? -DBL_MAX : -10 + step);
    hear_step(&fixture->feed, 2, 4, -8);
    hear_worker(&fixture->feed, 11, "alpha", 10);
    hear_worker(&fixture->feed, 12, "beta", 1000);
    *state = fixture;
    return 0;
}

static int teardown(void **state)
{
    struct fixture *fixture = *state;
    g_array_free(fixture->lines, TRUE);
    feed_fini(&fixture->feed);
    g_free(fixture);
    return 0;
}

static void draw(struct fixture *fixture)
{
    view_lines(&fixture->state, &fixture->feed, "memq://", SECOND, fixture->lines);
}

// The number of the first line that has the text in it; -1: there is none.
static int line_with(const struct fixture *fixture, const char *text)
{
    for (guint i = 0; i < fixture->lines->len; i++) {
        if (strstr(g_array_index(fixture->lines, struct view_line, i).text, text) != NULL)
            return (int)i;
    }
    return -1;
}

static void screen_shows_run_search_and_workers(void **state)
{
    struct fixture *fixture = *state;
    draw(fixture);
    assert_int_equal(fixture->lines->len, 40);
    assert_true(line_with(fixture, "> sedan") > 0);
    assert_true(line_with(fixture, "5.39 M") > 0);
    assert_true(line_with(fixture, "search 2: explore") > 0);
    assert_true(line_with(fixture, "alpha/42") > 0);
    assert_int_equal(line_with(fixture, "q quit"), 39);
}

// Whatever the size, no line is wider than the screen and none stands below it: either would make a
// terminal scroll. Letters of two columns and empty courses are among what is shown.
static void lines_fit_every_size(void **state)
{
    struct fixture *fixture = *state;
    hear_worker(&fixture->feed, 13, "工場の計算機", 1);
    for (unsigned height = 0; height < 30; height++) {
        for (unsigned width = 0; width < 140; width++) {
            fixture->state.width = width;
            fixture->state.height = height;
            draw(fixture);
            assert_true(fixture->lines->len <= height);
            for (guint i = 0; i < fixture->lines->len; i++) {
                const char *text = g_array_index(fixture->lines, struct view_line, i).text;
                assert_true(g_utf8_validate(text, -1, NULL));
                unsigned columns = 0;
                for (const char *c = text; *c != '\0'; c = g_utf8_next_char(c))
                    columns += g_unichar_iswide(g_utf8_get_char(c)) ? 2 : 1;
                assert_true(columns <= width);
            }
        }
    }
}

static void terminal_without_unicode_gets_ascii(void **state)
{
    struct fixture *fixture = *state;
    fixture->state.unicode = false;
    hear_worker(&fixture->feed, 13, "工場", 1);
    draw(fixture);
    for (guint i = 0; i < fixture->lines->len; i++) {
        for (const char *c = g_array_index(fixture->lines, struct view_line, i).text; *c; c++)
            assert_true((unsigned char)*c < 0x80);
    }
}

static void keys_choose_searches_and_runs(void **state)
{
    struct fixture *fixture = *state;
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_LEFT); // 1 was never heard of
    draw(fixture);
    assert_true(line_with(fixture, "search 0: ") > 0);
    assert_true(line_with(fixture, "▁") > 0);
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_LEFT);
    assert_int_equal(fixture->state.search, 0);
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_RIGHT);
    assert_int_equal(fixture->state.search, 2);
    hear_run(&fixture->feed, 6, "wagon", 2 * SECOND);
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_DOWN);
    draw(fixture);
    assert_true(line_with(fixture, "> wagon") > 0);
    assert_true(line_with(fixture, "no search of this run") > 0);
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_DOWN);
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_UP);
    draw(fixture);
    assert_true(line_with(fixture, "> sedan") > 0);
}

// A second run begins while the first one is watched: what the user has not chosen follows it.
static void newest_run_is_shown_until_one_is_chosen(void **state)
{
    struct fixture *fixture = *state;
    hear_run(&fixture->feed, 6, "wagon", 2 * SECOND);
    draw(fixture);
    assert_true(line_with(fixture, "> wagon") > 0);
}

static void workers_are_sorted_by_the_chosen_column(void **state)
{
    struct fixture *fixture = *state;
    draw(fixture);
    assert_true(line_with(fixture, "alpha/42") < line_with(fixture, "beta/42"));
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_SORT);
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_SORT);
    draw(fixture);
    assert_true(line_with(fixture, "sort: rate") > 0);
    assert_true(line_with(fixture, "beta/42") < line_with(fixture, "alpha/42"));
    view_press(&fixture->state, &fixture->feed, VIEW_KEY_REVERSE);
    draw(fixture);
    assert_true(line_with(fixture, "alpha/42") < line_with(fixture, "beta/42"));
}

// Paging ends at the last worker, and a screen that grew shows all again.
static void scrolling_ends_with_the_workers(void **state)
{
    struct fixture *fixture = *state;
    for (int64_t i = 0; i < 50; i++)
        hear_worker(&fixture->feed, 100 + i, "gamma", i);
    for (int i = 0; i < 10; i++)
        view_press(&fixture->state, &fixture->feed, VIEW_KEY_PAGE_DOWN);
    draw(fixture);
    assert_int_equal(line_with(fixture, "alpha/42"), -1);
    assert_true(line_with(fixture, "gamma/42") > 0);
    fixture->state.height = 100;
    draw(fixture);
    assert_true(line_with(fixture, "alpha/42") > 0);
}

#define TEST(claim) cmocka_unit_test_setup_teardown(claim, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(screen_shows_run_search_and_workers),
        TEST(lines_fit_every_size),
        TEST(terminal_without_unicode_gets_ascii),
        TEST(keys_choose_searches_and_runs),
        TEST(newest_run_is_shown_until_one_is_chosen),
        TEST(workers_are_sorted_by_the_chosen_column),
        TEST(scrolling_ends_with_the_workers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
