// What a browser is told: everything at first, then what changed, of what it has chosen and of
// nothing else.
#include "monitor/http/picture.h"

#include <float.h>
#include <jansson.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define SECOND INT64_C(1000000000)

struct fixture {
    struct feed feed;
    struct picture_view view;
    struct picture_cursor cursor;
    unsigned wanted;
};

static void want(void *user, uint64_t run, const struct digest *scenario)
{
    (void)run;
    (void)scenario;
    ((struct fixture *)user)->wanted++;
}

static int setup(void **state)
{
    struct fixture *fixture = g_new0(struct fixture, 1);
    feed_init(&fixture->feed);
    fixture->view = (struct picture_view){
        .feed = &fixture->feed,
        .texts = texts_create(),
        .source = "memq://",
        .instance = "1",
        .want = want,
        .user = fixture,
    };
    fixture->cursor = (struct picture_cursor){.has_run = true, .has_search = true, .run = 5};
    *state = fixture;
    return 0;
}

static int teardown(void **state)
{
    struct fixture *fixture = *state;
    texts_free(fixture->view.texts);
    feed_fini(&fixture->feed);
    g_free(fixture);
    return 0;
}

static void hear(struct fixture *fixture, int64_t run, int32_t step, double log_volume,
                 int64_t now_ns)
{
    double bounds[2] = {step, step + 1};
    sobox_search_status_t message = {
        .header = {.sender = 100 + run, .sequence = step, .run = run},
        .step = step,
        .log_volume = log_volume,
        .variables = 1,
        .bound_count = 2,
        .bounds = bounds,
    };
    feed_search_heard(&fixture->feed, &message, now_ns);
}

static json_t *event(struct fixture *fixture, int64_t now_ns)
{
    GString *text = g_string_new(NULL);
    picture_event(&fixture->view, &fixture->cursor, now_ns, text);
    assert_null(strchr(text->str, '\n'));
    json_t *object = json_loads(text->str, 0, NULL);
    assert_non_null(object);
    g_string_free(text, TRUE);
    return object;
}

static double step_from(const json_t *told)
{
    return json_number_value(
        json_object_get(json_object_get(json_object_get(told, "chosen"), "steps"), "from"));
}

static void first_event_is_complete_and_later_ones_tell_what_changed(void **state)
{
    struct fixture *fixture = *state;
    hear(fixture, 5, 1, -1, SECOND);
    hear(fixture, 6, 1, -2, SECOND);
    json_t *first = event(fixture, SECOND);
    assert_true(json_is_true(json_object_get(first, "reset")));
    assert_int_equal(json_array_size(json_object_get(first, "searches")), 2);
    json_decref(first);

    for (int32_t step = 2; step < 5; step++)
        hear(fixture, 5, step, -step, SECOND + step);
    json_t *second = event(fixture, 3 * SECOND);
    assert_null(json_object_get(second, "reset"));
    assert_int_equal(json_array_size(json_object_get(second, "searches")), 1);
    assert_float_equal(step_from(second), 0, 0);
    json_decref(second);

    hear(fixture, 5, 5, -5, 4 * SECOND);
    json_t *third = event(fixture, 5 * SECOND);
    assert_float_equal(step_from(third), 3, 0);
    json_decref(third);
}

// Nothing of a run that is not chosen may reach the chosen's charts.
static void other_runs_do_not_show_in_the_chosen_one(void **state)
{
    struct fixture *fixture = *state;
    hear(fixture, 5, 1, -1, SECOND);
    json_decref(event(fixture, SECOND));
    hear(fixture, 6, 9, -9, 2 * SECOND);
    assert_false(picture_due(&fixture->view, &fixture->cursor, SECOND + PICTURE_CHOSEN_NS));
    hear(fixture, 5, 2, -2, 2 * SECOND);
    assert_true(picture_due(&fixture->view, &fixture->cursor, SECOND + PICTURE_CHOSEN_NS));
    json_t *told = event(fixture, 2 * SECOND);
    const json_t *chosen = json_object_get(told, "chosen");
    assert_string_equal(json_string_value(json_object_get(chosen, "run")), "0000000000000005");
    const json_t *volume = json_object_get(json_object_get(chosen, "state"), "log_volume");
    assert_float_equal(json_number_value(volume), -2, 0);
    json_decref(told);
}

// A browser must be able to tell a quiet network from a dead monitor.
static void something_is_told_every_second(void **state)
{
    struct fixture *fixture = *state;
    json_decref(event(fixture, SECOND));
    assert_false(picture_due(&fixture->view, &fixture->cursor, SECOND + 1));
    assert_true(picture_due(&fixture->view, &fixture->cursor, 2 * SECOND));
}

// What the reader has and the feed forgot would stay on the page for ever.
static void forgotten_entries_make_the_reader_begin_anew(void **state)
{
    struct fixture *fixture = *state;
    sobox_worker_status_t worker = {.header = {.sender = 9}, .leaving = 1};
    feed_worker_heard(&fixture->feed, &worker, 0);
    json_decref(event(fixture, 0));
    feed_tick(&fixture->feed, FEED_LEFT_NS + 1);
    json_t *told = event(fixture, FEED_LEFT_NS + 1);
    assert_true(json_is_true(json_object_get(told, "reset")));
    assert_null(json_object_get(told, "workers"));
    json_decref(told);
}

// A chart whose axis goes to -DBL_MAX is drawn for ever; JSON has no word for infinity.
static void numbers_beyond_measure_are_null(void **state)
{
    struct fixture *fixture = *state;
    const double wrong[] = {-DBL_MAX, NAN, INFINITY, 1e200};
    for (int32_t i = 0; i < 4; i++) {
        hear(fixture, 5, i + 1, wrong[i], SECOND + i);
        json_t *told = event(fixture, (2 + i) * SECOND);
        const json_t *chosen = json_object_get(json_object_get(told, "chosen"), "state");
        assert_true(json_is_null(json_object_get(chosen, "log_volume")));
        json_decref(told);
    }
}

static void unknown_scenario_is_wanted(void **state)
{
    struct fixture *fixture = *state;
    hear(fixture, 5, 1, -1, SECOND);
    json_t *told = event(fixture, SECOND);
    assert_int_equal(fixture->wanted, 1);
    const json_t *chosen = json_object_get(told, "chosen");
    assert_true(json_is_null(json_object_get(chosen, "scenario")));
    json_decref(told);
}

#define TEST(claim) cmocka_unit_test_setup_teardown(claim, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(first_event_is_complete_and_later_ones_tell_what_changed),
        TEST(other_runs_do_not_show_in_the_chosen_one),
        TEST(something_is_told_every_second),
        TEST(forgotten_entries_make_the_reader_begin_anew),
        TEST(numbers_beyond_measure_are_null),
        TEST(unknown_scenario_is_wanted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
