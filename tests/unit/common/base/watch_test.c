#include "common/base/watch.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cmocka.h>

static gboolean count_event(gint descriptor, GIOCondition condition, gpointer user)
{
    eventfd_t ignored;
    assert_int_equal(condition, G_IO_IN);
    assert_int_equal(eventfd_read(descriptor, &ignored), 0);
    ++*(int *)user;
    return G_SOURCE_CONTINUE;
}

// Takes turns of the main loop until nothing is left to do.
static void turn(void)
{
    while (g_main_context_iteration(NULL, FALSE))
        continue;
}

// Whether the main loop would wake up at once though nothing has happened.
static bool loop_is_awake(void)
{
    GMainContext *context = g_main_context_default();
    GPollFD descriptors[16];
    gint timeout, priority;
    assert_true(g_main_context_acquire(context));
    g_main_context_prepare(context, &priority);
    gint count = g_main_context_query(context, priority, &timeout, descriptors, 16);
    assert_in_range(count, 1, 16);
    bool awake = g_poll(descriptors, (guint)count, 0) > 0;
    g_main_context_release(context);
    return awake;
}

// Each event is told once, none after the watch has gone.
static void descriptor_is_watched_until_its_source_is_removed(void **state)
{
    (void)state;
    int told = 0, descriptor = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    guint watch = watch_add(descriptor, count_event, &told);
    turn();
    assert_int_equal(told, 0);
    for (int i = 1; i <= 3; i++) {
        eventfd_write(descriptor, 1);
        turn();
        assert_int_equal(told, i);
    }
    assert_true(g_source_remove(watch));
    eventfd_write(descriptor, 1);
    turn();
    assert_int_equal(told, 3);
    close(descriptor);
}

// What the watch is for: g_unix_fd_add() leaves the loop awake, for an empty turn after each event.
static void event_leaves_the_loop_asleep(void **state)
{
    (void)state;
    int told = 0, descriptor = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    guint watch = watch_add(descriptor, count_event, &told);
    turn();
    eventfd_write(descriptor, 1);
    g_main_context_iteration(NULL, FALSE);
    assert_int_equal(told, 1);
    assert_false(loop_is_awake());
    g_source_remove(watch);
    close(descriptor);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(descriptor_is_watched_until_its_source_is_removed),
        cmocka_unit_test(event_leaves_the_loop_asleep),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
