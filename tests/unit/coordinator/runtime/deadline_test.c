#include "coordinator/runtime/deadline.h"

#include "common/base/clock.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

struct bell {
    struct deadline *deadline;
    int rung;
    int64_t rung_ns; // when it last did
};

static void ring(void *user)
{
    struct bell *bell = user;
    bell->rung++;
    bell->rung_ns = clock_monotonic_ns();
}

static int bell_hang(void **state)
{
    struct bell *bell = g_new0(struct bell, 1);
    bell->deadline = deadline_create(ring, bell);
    assert_non_null(bell->deadline);
    *state = bell;
    return 0;
}

static int bell_take_down(void **state)
{
    struct bell *bell = *state;
    deadline_free(bell->deadline);
    g_free(bell);
    return 0;
}

// Runs the main loop until this time has passed and everything due by then is done.
static void run_until(int64_t time_ns)
{
    while (clock_monotonic_ns() <= time_ns || g_main_context_pending(NULL))
        g_main_context_iteration(NULL, FALSE);
}

static int64_t from_now(int64_t milliseconds)
{
    return clock_monotonic_ns() + milliseconds * CLOCK_MILLISECOND_NS;
}

// Not before its time, and once.
static void deadline_comes_once(void **state)
{
    struct bell *bell = *state;
    int64_t due_ns = from_now(3);
    deadline_set(bell->deadline, due_ns);
    while (bell->rung == 0)
        g_main_context_iteration(NULL, TRUE);
    assert_true(bell->rung_ns >= due_ns);
    run_until(from_now(3));
    assert_int_equal(bell->rung, 1);
}

// The kernel's timer still rings at the first time, which must not show.
static void deadline_that_moves_away_comes_at_its_last_time(void **state)
{
    struct bell *bell = *state;
    int64_t due_ns = 0;
    for (int i = 1; i <= 20; i++) {
        due_ns = from_now(1 + i / 4);
        deadline_set(bell->deadline, due_ns);
    }
    while (bell->rung == 0)
        g_main_context_iteration(NULL, TRUE);
    assert_true(bell->rung_ns >= due_ns);
    run_until(from_now(3));
    assert_int_equal(bell->rung, 1);
}

// The timer that was wound for the later time must not make it wait for that.
static void deadline_that_comes_nearer_does_not_wait_for_the_later_one(void **state)
{
    struct bell *bell = *state;
    deadline_set(bell->deadline, from_now(1000 * 1000));
    deadline_set(bell->deadline, from_now(1));
    while (bell->rung == 0)
        g_main_context_iteration(NULL, TRUE);
    assert_int_equal(bell->rung, 1);
}

// A time that has passed already, the beginning of time included, is due now.
static void deadline_in_the_past_is_due_at_once(void **state)
{
    struct bell *bell = *state;
    deadline_set(bell->deadline, 0);
    while (bell->rung == 0)
        g_main_context_iteration(NULL, TRUE);
    deadline_set(bell->deadline, from_now(-1000));
    while (bell->rung == 1)
        g_main_context_iteration(NULL, TRUE);
    assert_int_equal(bell->rung, 2);
}

static void deadline_that_is_taken_back_never_comes(void **state)
{
    struct bell *bell = *state;
    int64_t due_ns = from_now(1);
    deadline_set(bell->deadline, due_ns);
    deadline_set(bell->deadline, INT64_MAX);
    run_until(due_ns + 2 * CLOCK_MILLISECOND_NS);
    assert_int_equal(bell->rung, 0);
    // It is there for the next one.
    deadline_set(bell->deadline, from_now(1));
    while (bell->rung == 0)
        g_main_context_iteration(NULL, TRUE);
    assert_int_equal(bell->rung, 1);
}

int main(void)
{
#define BELL_TEST(test) cmocka_unit_test_setup_teardown(test, bell_hang, bell_take_down)
    const struct CMUnitTest tests[] = {
        BELL_TEST(deadline_comes_once),
        BELL_TEST(deadline_that_moves_away_comes_at_its_last_time),
        BELL_TEST(deadline_that_comes_nearer_does_not_wait_for_the_later_one),
        BELL_TEST(deadline_in_the_past_is_due_at_once),
        BELL_TEST(deadline_that_is_taken_back_never_comes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
