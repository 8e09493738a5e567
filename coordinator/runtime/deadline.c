#include "coordinator/runtime/deadline.h"

#include "common/base/clock.h"
#include "common/base/watch.h"

#include <assert.h>
#include <sys/timerfd.h>
#include <unistd.h>

struct deadline {
    deadline_handler *handler;
    void *user;
    int timer;
    guint watch;
    int64_t wanted_ns;
    int64_t timer_ns; // when the timer rings: not after wanted_ns; INT64_MAX: never
};

static void wind(struct deadline *deadline, int64_t time_ns)
{
    const struct itimerspec when = {
        .it_value = {.tv_sec = time_ns / CLOCK_SECOND_NS, .tv_nsec = time_ns % CLOCK_SECOND_NS}};
    const int set = timerfd_settime(deadline->timer, TFD_TIMER_ABSTIME, &when, NULL);
    assert(set == 0);
    deadline->timer_ns = time_ns;
}

static gboolean ring(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)condition;
    struct deadline *deadline = user;
    uint64_t expirations;
    if (read(descriptor, &expirations, sizeof expirations) < 0)
        return G_SOURCE_CONTINUE; // wound anew since it rang
    const int64_t wanted_ns = deadline->wanted_ns;
    deadline->timer_ns = INT64_MAX;
    if (wanted_ns > clock_monotonic_ns()) {
        deadline_set(deadline, wanted_ns);
    } else {
        deadline->wanted_ns = INT64_MAX;
        deadline->handler(deadline->user);
    }
    return G_SOURCE_CONTINUE;
}

struct deadline *deadline_create(deadline_handler *handler, void *user)
{
    const int timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    if (timer < 0)
        return NULL;
    struct deadline *deadline = g_new(struct deadline, 1);
    *deadline = (struct deadline){
        .handler = handler,
        .user = user,
        .timer = timer,
        .watch = watch_add(timer, ring, deadline),
        .wanted_ns = INT64_MAX,
        .timer_ns = INT64_MAX,
    };
    return deadline;
}

void deadline_free(struct deadline *deadline)
{
    if (deadline == NULL)
        return;
    g_source_remove(deadline->watch);
    close(deadline->timer);
    g_free(deadline);
}

void deadline_set(struct deadline *deadline, int64_t time_ns)
{
    deadline->wanted_ns = time_ns;
    if (time_ns < deadline->timer_ns)
        wind(deadline, time_ns > 0 ? time_ns : 1); // 0 would stop the timer
}
