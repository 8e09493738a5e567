// A batch handed to one worker until a deadline.
//
//     start                late                            end
//       |-------------------|-------------------------------|
//        expected work       an idle worker may take a copy  the batch is handed out again
//        + 4 deviations
//        + delay
//
// The end is twice as far from the start as late is, and not below the worker's least lease
// (roster_hurry()), which is between lease_new_ns and lease_min_ns. Late is not below a quarter of
// that. After LEASE_FREE_COUNT attempts each further one has twice the time of
// the one before.
//
// All of this is worked out anew when the timer rings: what has been measured meanwhile counts, so
// that a model that turns out slow does not end the leases that were given before that was known.
//
// A lease lives in its batch. When it has ended it stays there for a while, so that an outcome that
// comes after all still tells how long that worker takes: that is how leases that are too short
// grow.
#ifndef SOBOX_COORDINATOR_SCHEDULE_LEASE_H
#define SOBOX_COORDINATOR_SCHEDULE_LEASE_H

#include "coordinator/schedule/heap.h"
#include "coordinator/schedule/roster.h"

struct backlog_batch;

enum {
    LEASE_ACTIVE_MAX = 2,  // of a batch at once: the holder's and one copy
    LEASE_KEPT_MAX = 4,    // of a batch, active and ended; older ones are answered for by these
    LEASE_PASSED_MAX = 3,  // later leases of the same worker answered: this one is lost if it is
                           // overdue too. Workers work in order, networks reorder neighbours: TCP's
                           // three duplicate acknowledgements (RFC 5681, section 3.2). A batch that
                           // waits for its box is overtaken without being lost: hence overdue
    LEASE_FREE_COUNT = 6,  // attempts before leases get longer: where half of all batches get
                           // lost, one in 64 needs more, and to wait would not help
    LEASE_BACKOFF_MAX = 3, // doublings of a lease from attempt to attempt: an estimate far too
                           // short grows eightfold, and under heavy loss nobody waits for minutes
};

struct lease {
    struct roster_worker *worker; // NULL: it has ended
    struct backlog_batch *batch;
    uint64_t worker_id; // whose outcome is still to be measured; 0: nobody's
    uint32_t attempt;
    uint32_t passed; // outcomes of later leases of the same worker
    uint64_t order;  // among all leases
    int64_t start_ns;
    int64_t slept_ns;   // the book's, then
    uint32_t samples;   // of its batch
    int64_t cost_ns;    // its work, as one core is thought to do it
    int64_t ahead_ns;   // likewise: work the worker had before it
    int64_t overdue_ns; // when its outcome is overdue, if all goes as it did so far
    int64_t end_ns;
    bool late;
    struct heap_entry timer; // in the book: when it gets late, then when it ends
};

// All active leases by when something is due.
struct lease_book {
    const struct schedule_settings *settings;
    struct heap timers;
    uint64_t started; // ever
    int64_t slept_ns; // how long the schedule's clock stood still while the coordinator did
};

void lease_book_init(struct lease_book *book, const struct schedule_settings *settings);
void lease_book_fini(struct lease_book *book);

// Hands `batch` to `worker`, who has room, and counts the attempt.
struct lease *lease_start(struct lease_book *book, struct roster *roster,
                          struct backlog_batch *batch, struct roster_worker *worker,
                          int64_t now_ns);

// Ends an active lease, for whatever reason.
void lease_end(struct lease_book *book, struct roster *roster, struct lease *lease);

// A lease that has reached its end, which is for the caller to end, or become late, which is marked
// and goes on; NULL when there is none.
struct lease *lease_due(struct lease_book *book, struct roster *roster, int64_t now_ns,
                        bool *ended);

// Whether the outcome of an active lease is overdue, if all goes as it did so far.
bool lease_overdue(const struct lease_book *book, const struct roster *roster,
                   const struct lease *lease, int64_t now_ns);

// When lease_due() may find one; INT64_MAX when there is none.
int64_t lease_wake_ns(const struct lease_book *book);

// The batch's lease, active or ended, under which this worker made this attempt, or where that is
// no longer kept the next one of the worker: it tells at least how long the worker takes. NULL when
// there is none, or when its outcome has been measured before.
struct lease *lease_find(struct backlog_batch *batch, uint64_t worker_id, uint32_t attempt);

// Measures the worker by an outcome of its lease, once.
void lease_measure(const struct lease_book *book, struct lease *lease, struct roster *roster,
                   struct roster_worker *worker, int64_t service_ns, int64_t now_ns);

// How many leases of the batch are active.
uint32_t lease_active(const struct backlog_batch *batch);

#endif
