// Courses that stay bounded.
#include "monitor/feed/history.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static int point(const struct history *history, guint i)
{
    return g_array_index(history->points, int, i);
}

static void fill(struct history *history, int count)
{
    history_init(history, sizeof(int), 8);
    for (int i = 0; i < count; i++)
        history_add(history, &i);
}

// Whatever its length, a course begins with its first point, ends with its newest, and what lies
// between is spread evenly: a window of the newest points would hide how it began.
static void course_of_any_length_is_spanned_evenly(void **state)
{
    (void)state;
    for (int count = 1; count < 1000; count++) {
        struct history history;
        fill(&history, count);
        const guint last = history.points->len - 1;
        assert_true(history.points->len <= 8);
        assert_int_equal(point(&history, 0), 0);
        assert_int_equal(point(&history, last), count - 1);
        for (guint i = 0; i < last; i++)
            assert_int_equal(point(&history, i), (int)(i * history.stride));
        history_fini(&history);
    }
}

// Who copies a course point by point must learn that points it has are gone.
static void thinning_and_cutting_are_counted(void **state)
{
    (void)state;
    struct history history;
    fill(&history, 8);
    assert_int_equal(history.rewrites, 0);
    const int next = 8;
    history_add(&history, &next);
    assert_int_equal(history.rewrites, 1);
    history_cut(&history, 2);
    assert_int_equal(history.rewrites, 2);
    assert_int_equal(point(&history, history.points->len - 1), 4);
    history_add(&history, &next);
    assert_int_equal(point(&history, history.points->len - 2), 4);
    history_cut(&history, 100);
    assert_int_equal(history.points->len, 0);
    history_fini(&history);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(course_of_any_length_is_spanned_evenly),
        cmocka_unit_test(thinning_and_cutting_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
