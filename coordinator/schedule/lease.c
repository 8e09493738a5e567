#include "coordinator/schedule/lease.h"
#include "coordinator/schedule/backlog.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>

// As long as a worker has answered nothing, its lease allows for the scenario's text to be fetched
// piece by piece and its model to be prepared. TCP's first timer has 1 s (RFC 6298, section 2);
// within one network half of that is plenty.
#define LEASE_FIRST_NS INT64_C(200000000)

// Nothing is overdue sooner than this: a box may have to be fetched first, and a worker that
// measured microseconds so far may have to wait for its turn on its own machine.
#define LEASE_OVERDUE_MIN_NS INT64_C(1000000)

// No estimate, however wild the measurements, is longer than this.
#define LEASE_ESTIMATE_MAX_NS 3600e9

void lease_book_init(struct lease_book *book, const struct schedule_settings *settings)
{
    *book = (struct lease_book){.settings = settings};
}

void lease_book_fini(struct lease_book *book)
{
    heap_fini(&book->timers);
}

static int64_t ns_of(double ns)
{
    return (int64_t)fmin(fmax(ns, 1), LEASE_ESTIMATE_MAX_NS);
}

static int64_t ns_min(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static int64_t ns_max(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

// A slot of the batch whose lease has ended: the one that was given first.
static struct lease *lease_slot(struct backlog_batch *batch)
{
    struct lease *slot = NULL;
    for (uint32_t i = 0; i < LEASE_KEPT_MAX; i++) {
        struct lease *lease = &batch->leases[i];
        if (lease->worker == NULL && (slot == NULL || lease->order < slot->order))
            slot = lease;
    }
    assert(slot != NULL);
    return slot;
}

// The moments of a lease.
struct lease_plan {
    int64_t overdue_ns; // its outcome should have come
    int64_t late_ns;    // a copy may be made
    int64_t end_ns;
};

// How long after its start the outcome is overdue, if all goes as it did so far: the work before it
// and its own at the worker's mean, four deviations of that, and the delay's bound. Half of the
// work is allowed on top even where measurements never differed: a machine gets another job now and
// then.
static int64_t lease_bound_ns(const struct roster_worker *worker, double work_ns)
{
    double spread = 1;
    if (worker->service.measured)
        spread = fmax(4 * worker->service.deviation / worker->service.mean, 0.5);
    return ns_of(work_ns * (1 + spread) + estimate_bound(&worker->delay));
}

// The least lease of a worker.
static int64_t lease_least_ns(const struct lease_book *book, const struct roster_worker *worker)
{
    const struct schedule_settings *settings = book->settings;
    if (worker->delay.measured)
        return ns_max(worker->least_ns, settings->lease_min_ns);
    return ns_max(ns_max(settings->lease_new_ns, LEASE_FIRST_NS), settings->lease_min_ns);
}

static struct lease_plan lease_plan(const struct lease_book *book, const struct roster *roster,
                                    const struct lease *lease)
{
    const struct schedule_settings *settings = book->settings;
    const struct roster_worker *worker = lease->worker;
    double work_ns =
        ((double)lease->ahead_ns + (double)lease->cost_ns) * roster_service(roster, worker);
    int64_t bound_ns = lease_bound_ns(worker, work_ns);
    int64_t least_ns = lease_least_ns(book, worker);
    if (!worker->delay.measured)
        bound_ns = ns_max(bound_ns, least_ns / 4);
    const uint32_t further =
        lease->attempt < LEASE_FREE_COUNT ? 0 : lease->attempt - LEASE_FREE_COUNT + 1;
    const uint32_t backoff = further < LEASE_BACKOFF_MAX ? further : LEASE_BACKOFF_MAX;
    int64_t duration_ns = ns_max(least_ns, 2 * bound_ns) << backoff;
    // Work that is known to take longer than the greatest lease is not cut off.
    int64_t most_ns = ns_max(settings->lease_max_ns, ns_of(2 * work_ns));
    return (struct lease_plan){
        .overdue_ns = lease->start_ns + ns_max(LEASE_OVERDUE_MIN_NS, bound_ns),
        .late_ns = lease->start_ns + ns_max(least_ns / 4, bound_ns),
        .end_ns = lease->start_ns + ns_min(duration_ns, most_ns),
    };
}

// Sets the timer to what comes next.
static void lease_set_timer(struct lease_book *book, struct lease *lease,
                            const struct lease_plan *plan)
{
    heap_put(&book->timers, &lease->timer,
             lease->late ? plan->end_ns : ns_min(plan->late_ns, plan->end_ns));
}

struct lease *lease_start(struct lease_book *book, struct roster *roster,
                          struct backlog_batch *batch, struct roster_worker *worker, int64_t now_ns)
{
    assert(lease_active(batch) < LEASE_ACTIVE_MAX);
    struct lease *lease = lease_slot(batch);
    *lease = (struct lease){
        .worker = worker,
        .batch = batch,
        .worker_id = worker->id,
        .attempt = batch->identity.attempt++,
        .order = ++book->started,
        .start_ns = now_ns,
        .slept_ns = book->slept_ns,
        .samples = batch->identity.count,
        .cost_ns = ns_of(batch->step->sample_ns * batch->identity.count),
        .ahead_ns = worker->load_ns,
        .timer.tie = book->started,
    };
    batch->holder = worker->id;
    struct lease_plan plan = lease_plan(book, roster, lease);
    lease_set_timer(book, lease, &plan);
    roster_hold(roster, worker, lease);
    return lease;
}

void lease_end(struct lease_book *book, struct roster *roster, struct lease *lease)
{
    assert(lease->worker != NULL);
    heap_remove(&book->timers, &lease->timer);
    roster_drop(roster, lease->worker, lease);
    lease->worker = NULL;
}

struct lease *lease_due(struct lease_book *book, struct roster *roster, int64_t now_ns, bool *ended)
{
    struct heap_entry *first;
    while ((first = heap_first(&book->timers)) != NULL && first->key <= now_ns) {
        struct lease *lease = (struct lease *)((char *)first - offsetof(struct lease, timer));
        struct lease_plan plan = lease_plan(book, roster, lease);
        *ended = plan.end_ns <= now_ns;
        if (*ended)
            return lease;
        bool newly_late = !lease->late && plan.late_ns <= now_ns;
        if (newly_late)
            roster_late(roster, lease->worker, lease);
        lease_set_timer(book, lease, &plan);
        if (newly_late)
            return lease;
    }
    return NULL;
}

bool lease_overdue(const struct lease_book *book, const struct roster *roster,
                   const struct lease *lease, int64_t now_ns)
{
    return lease_plan(book, roster, lease).overdue_ns <= now_ns;
}

int64_t lease_wake_ns(const struct lease_book *book)
{
    const struct heap_entry *first = heap_first(&book->timers);
    return first != NULL ? first->key : INT64_MAX;
}

struct lease *lease_find(struct backlog_batch *batch, uint64_t worker_id, uint32_t attempt)
{
    struct lease *next = NULL; // the worker's next one
    bool kept = false;         // one before it is
    for (uint32_t i = 0; i < LEASE_KEPT_MAX; i++) {
        struct lease *lease = &batch->leases[i];
        if (lease->order == 0)
            continue;
        kept |= lease->attempt <= attempt;
        if (lease->worker_id != worker_id)
            continue;
        if (lease->attempt == attempt)
            return lease;
        if (lease->attempt > attempt && (next == NULL || lease->attempt < next->attempt))
            next = lease;
    }
    return kept ? NULL : next;
}

void lease_measure(const struct lease_book *book, struct lease *lease, struct roster *roster,
                   struct roster_worker *worker, int64_t service_ns, int64_t now_ns)
{
    assert(lease->worker_id == worker->id);
    int64_t turnaround_ns = now_ns - lease->start_ns;
    double work_ns =
        ((double)lease->ahead_ns + (double)lease->cost_ns) * roster_service(roster, worker);
    // An evaluation cannot have taken longer than the lease is old, whatever the message says.
    const int64_t age_ns = turnaround_ns + book->slept_ns - lease->slept_ns;
    double service_known_ns = (double)ns_min(service_ns, age_ns);
    // Of a worker that was not measured before only its own evaluation is known.
    if (!worker->service.measured)
        work_ns = service_known_ns;
    roster_measure(roster, worker, (double)lease->cost_ns, service_known_ns,
                   fmax((double)turnaround_ns - work_ns, 0));
    lease->worker_id = 0;
}

uint32_t lease_active(const struct backlog_batch *batch)
{
    uint32_t active = 0;
    for (uint32_t i = 0; i < LEASE_KEPT_MAX; i++)
        active += batch->leases[i].worker != NULL;
    return active;
}
