// Coordinators that share workers, on a virtual clock: the real schedule of each, workers of one
// thread that serve coordinators in turn, messages that take 50 us and never get lost.
#include "coordinator/schedule/schedule.h"
#include "worker/batch/turns.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum {
    COORDINATORS = 2,
    WORKERS = 3,
    LATENCY_NS = 50000,
    ANNOUNCE_NS = 1000000000,
};

#define MS INT64_C(1000000)
#define SECOND INT64_C(1000000000)

// A batch at a worker, or on its way to it or back.
struct job {
    struct turn turn; // its coordinator is the index of that
    struct batch_identity batch;
    uint32_t worker;
    int64_t service_ns;
};

enum event_kind { BATCH_ARRIVES, WORK_ENDS, OUTCOME_ARRIVES, WORKERS_ANNOUNCE };

struct event {
    int64_t time_ns;
    enum event_kind kind;
    struct job *job; // owned
};

struct coordinator {
    uint32_t step_samples; // 0: it is not there
    int64_t sample_ns;     // what a sample takes a worker
    struct schedule *schedule;
    struct schedule_effects effects;
    uint32_t steps;     // done
    int64_t step_ns;    // when the last one began
    int64_t longest_ns; // that a step took, once the workers were known
    int64_t served_ns;  // the workers' time
};

struct worker {
    struct turns turns;
    struct job *work; // NULL: idle
    uint32_t queue;   // that one included
};

struct site {
    int64_t now_ns;
    uint64_t arrivals;
    GSequence *events; // struct event, by time
    struct coordinator coordinators[COORDINATORS];
    struct worker workers[WORKERS];
};

static gint event_order(gconstpointer a, gconstpointer b, gpointer user)
{
    (void)user;
    const int64_t left = ((const struct event *)a)->time_ns;
    const int64_t right = ((const struct event *)b)->time_ns;
    return (left > right) - (left < right);
}

static void event_add(struct site *site, int64_t delay_ns, enum event_kind kind, struct job *job)
{
    struct event *event = g_new(struct event, 1);
    *event = (struct event){.time_ns = site->now_ns + delay_ns, .kind = kind, .job = job};
    g_sequence_insert_sorted(site->events, event, event_order, NULL);
}

// ---- A coordinator ----

static void coordinator_take(struct site *site, uint32_t index, struct schedule_event event);

static void coordinator_next_step(struct site *site, uint32_t index)
{
    struct coordinator *coordinator = &site->coordinators[index];
    coordinator->step_ns = site->now_ns;
    coordinator_take(site, index,
                     (struct schedule_event){.kind = SCHEDULE_EVENT_STEP,
                                             .step = {.step = coordinator->steps,
                                                      .samples = coordinator->step_samples}});
}

static void coordinator_send(struct site *site, uint32_t index, uint64_t worker,
                             const struct batch_identity *batch)
{
    struct job *job = g_new0(struct job, 1);
    job->turn.coordinator = index;
    job->batch = *batch;
    job->worker = (uint32_t)worker - 1;
    job->service_ns = batch->count * site->coordinators[index].sample_ns;
    event_add(site, LATENCY_NS, BATCH_ARRIVES, job);
}

static void coordinator_take(struct site *site, uint32_t index, struct schedule_event event)
{
    struct coordinator *coordinator = &site->coordinators[index];
    bool done = false;
    event.now_ns = site->now_ns;
    schedule_step(coordinator->schedule, &event, &coordinator->effects);
    for (size_t i = 0; i < coordinator->effects.count; i++) {
        const struct schedule_effect *effect = &coordinator->effects.items[i];
        if (effect->kind == SCHEDULE_EFFECT_SEND)
            coordinator_send(site, index, effect->send.worker, &effect->send.batch);
        done |= effect->kind == SCHEDULE_EFFECT_STEP;
    }
    if (!done)
        return;
    if (++coordinator->steps > 10) // by then it knows the workers
        coordinator->longest_ns = MAX(coordinator->longest_ns, site->now_ns - coordinator->step_ns);
    coordinator_next_step(site, index);
}

static void workers_announce(struct site *site)
{
    for (uint32_t c = 0; c < COORDINATORS; c++)
        for (uint32_t w = 0; w < WORKERS && site->coordinators[c].schedule != NULL; w++)
            coordinator_take(site, c,
                             (struct schedule_event){.kind = SCHEDULE_EVENT_WORKER,
                                                     .worker = {.id = w + 1,
                                                                .threads = 1,
                                                                .queue = site->workers[w].queue,
                                                                .acceptable = true,
                                                                .name = "worker"}});
    event_add(site, ANNOUNCE_NS, WORKERS_ANNOUNCE, NULL);
}

// ---- A worker ----

static void worker_next(struct site *site, struct worker *worker)
{
    if (worker->work != NULL)
        return;
    worker->work = (struct job *)turns_take(&worker->turns);
    if (worker->work != NULL)
        event_add(site, worker->work->service_ns, WORK_ENDS, worker->work);
}

static void worker_receive(struct site *site, struct job *job)
{
    struct worker *worker = &site->workers[job->worker];
    job->turn.arrival = site->arrivals++;
    turns_add(&worker->turns, &job->turn);
    worker->queue++;
    worker_next(site, worker);
}

static void worker_finish(struct site *site, struct job *job)
{
    struct worker *worker = &site->workers[job->worker];
    site->coordinators[job->turn.coordinator].served_ns += job->service_ns;
    worker->work = NULL;
    worker->queue--;
    event_add(site, LATENCY_NS, OUTCOME_ARRIVES, job);
    worker_next(site, worker);
}

static void outcome_arrives(struct site *site, struct job *job)
{
    coordinator_take(site, (uint32_t)job->turn.coordinator,
                     (struct schedule_event){.kind = SCHEDULE_EVENT_OUTCOME,
                                             .outcome = {.worker = job->worker + 1,
                                                         .batch = job->batch,
                                                         .queue = site->workers[job->worker].queue,
                                                         .service_ns = job->service_ns}});
    g_free(job);
}

// ---- The whole ----

static void event_happens(struct site *site, const struct event *event)
{
    switch (event->kind) {
    case BATCH_ARRIVES:
        worker_receive(site, event->job);
        break;
    case WORK_ENDS:
        worker_finish(site, event->job);
        break;
    case OUTCOME_ARRIVES:
        outcome_arrives(site, event->job);
        break;
    case WORKERS_ANNOUNCE:
        workers_announce(site);
        break;
    }
}

// The coordinator whose deadline comes first, and before this time; COORDINATORS: none.
static uint32_t first_to_wake(const struct site *site, int64_t before_ns)
{
    uint32_t first = COORDINATORS;
    for (uint32_t c = 0; c < COORDINATORS; c++) {
        const struct coordinator *coordinator = &site->coordinators[c];
        if (coordinator->schedule != NULL && coordinator->effects.wake_ns < before_ns) {
            first = c;
            before_ns = coordinator->effects.wake_ns;
        }
    }
    return first;
}

static void site_run(struct site *site, int64_t end_ns)
{
    site->events = g_sequence_new(g_free);
    for (uint32_t w = 0; w < WORKERS; w++)
        turns_init(&site->workers[w].turns);
    for (uint32_t c = 0; c < COORDINATORS; c++) {
        if (site->coordinators[c].schedule == NULL)
            continue;
        coordinator_next_step(site, c);
    }
    workers_announce(site);
    while (site->now_ns < end_ns) {
        GSequenceIter *next = g_sequence_get_begin_iter(site->events);
        const struct event event = *(const struct event *)g_sequence_get(next);
        const uint32_t awake = first_to_wake(site, event.time_ns);
        if (awake < COORDINATORS) {
            site->now_ns = MAX(site->now_ns, site->coordinators[awake].effects.wake_ns);
            coordinator_take(site, awake, (struct schedule_event){.kind = SCHEDULE_EVENT_TICK});
            continue;
        }
        g_sequence_remove(next);
        site->now_ns = event.time_ns;
        event_happens(site, &event);
    }
}

static void coordinator_join(struct site *site, uint32_t index, uint32_t step_samples,
                             int64_t sample_ns, uint32_t window_max)
{
    struct schedule_settings settings = schedule_settings_default();
    settings.window_max = window_max;
    site->coordinators[index] = (struct coordinator){.step_samples = step_samples,
                                                     .sample_ns = sample_ns,
                                                     .schedule = schedule_create(&settings)};
}

static void job_drop(gpointer data, gpointer user)
{
    (void)user;
    g_free(((const struct event *)data)->job);
}

static int set_up(void **state)
{
    *state = g_new0(struct site, 1);
    return 0;
}

static int tear_down(void **state)
{
    struct site *site = *state;
    g_sequence_foreach(site->events, job_drop, NULL); // a worker's own work is among them
    g_sequence_free(site->events);
    for (uint32_t w = 0; w < WORKERS; w++) {
        struct turn *turn;
        while ((turn = turns_take(&site->workers[w].turns)) != NULL)
            g_free(turn);
        turns_fini(&site->workers[w].turns);
    }
    for (uint32_t c = 0; c < COORDINATORS; c++) {
        schedule_effects_fini(&site->coordinators[c].effects);
        schedule_free(site->coordinators[c].schedule);
    }
    g_free(site);
    return 0;
}

// The first coordinator's part of the workers' time. [%]
static double share(const struct site *site)
{
    const double first = (double)site->coordinators[0].served_ns;
    return 100 * first / (first + (double)site->coordinators[1].served_ns);
}

static void assert_between(double value, double least, double greatest)
{
    if (value < least || value > greatest)
        fail_msg("%g is not between %g and %g", value, least, greatest);
}

static void equal_coordinators_get_half_each(void **state)
{
    struct site *site = *state;
    coordinator_join(site, 0, 8000, 1000, 8);
    coordinator_join(site, 1, 8000, 1000, 8);
    site_run(site, 3 * SECOND);
    assert_between(share(site), 47, 53);
}

// In the order of arrival it would be one fifth.
static void coordinator_that_keeps_less_in_flight_gets_no_less(void **state)
{
    struct site *site = *state;
    coordinator_join(site, 0, 100000, 1000, 2);
    coordinator_join(site, 1, 100000, 1000, 8);
    site_run(site, 3 * SECOND);
    assert_between(share(site), 47, 53);
}

// Nor does one whose steps have no end hold up one that has three small batches a step: they wait
// for the batch in work, not for all that wait.
static void small_steps_go_on_beside_huge_ones(void **state)
{
    struct site *site = *state;
    coordinator_join(site, 0, 200, 1000, 8);
    coordinator_join(site, 1, 1000000, 1000, 8);
    site_run(site, 3 * SECOND);
    assert_true(site->coordinators[0].longest_ns < 2 * MS); // alone 0.2 ms; a batch takes 0.4 ms
    assert_true(site->coordinators[0].steps > 3000);
    assert_between(share(site), 5, 50);
}

// Turns go by the batch, and batches of a cheap model are bounded by the size of a message: it gets
// less of the time, but never nothing.
static void cheap_model_goes_on_beside_a_dear_one(void **state)
{
    struct site *site = *state;
    coordinator_join(site, 0, 8000, 1000, 8);
    coordinator_join(site, 1, 8000, 100000, 8);
    site_run(site, 3 * SECOND);
    assert_between(share(site), 10, 50);
}

// What the others are compared with: one alone keeps every worker busy.
static void coordinator_alone_gets_everything(void **state)
{
    struct site *site = *state;
    coordinator_join(site, 0, 100000, 1000, 8);
    site_run(site, 3 * SECOND);
    assert_between(100.0 * (double)site->coordinators[0].served_ns / (3 * WORKERS * (double)SECOND),
                   95, 100);
}

int main(void)
{
#define SHARING_TEST(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        SHARING_TEST(equal_coordinators_get_half_each),
        SHARING_TEST(coordinator_that_keeps_less_in_flight_gets_no_less),
        SHARING_TEST(small_steps_go_on_beside_huge_ones),
        SHARING_TEST(cheap_model_goes_on_beside_a_dear_one),
        SHARING_TEST(coordinator_alone_gets_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
