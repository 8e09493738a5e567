// The workers the coordinator knows, what was measured of each, and who has room for another batch.
//
//                announced                     silent for silence_ns
//     (unknown) ----------> [working] ------------------------------> [silent]
//         |                  |     ^                                   |    |
//         | other kernel     |     +-----------------------------------+    |
//         | or version       |           heard again                        |
//         v                  |  says it leaves                              |
//     [refused]              +-----------> [left] <-------------------------+
//
// Only working ones hold leases. The others are remembered for a while, so that each is mentioned
// once and a worker that comes back is known, with its rate; then they are forgotten. A worker that
// was started anew has a new sender number and is another worker.
//
// A working one that let three batches in a row go late or lapse, and was not heard to work in
// between, is stalled: it gets one batch at a time, and only when nobody else has room, or a copy
// of a late one when it is idle, until it answers or says that it has nothing to do. Without this a
// worker that hangs or died would look idle and hold up every step until its silence is long
// enough.
#ifndef SOBOX_COORDINATOR_SCHEDULE_ROSTER_H
#define SOBOX_COORDINATOR_SCHEDULE_ROSTER_H

#include "coordinator/schedule/estimate.h"
#include "coordinator/schedule/heap.h"
#include "coordinator/schedule/schedule.h"

#include <glib.h>

struct backlog_batch;
struct lease;

enum {
    ROSTER_MISSED_MAX = 8, // a worker's given-up leases remembered; an outcome that has not come by
                           // the ninth was lost
    ROSTER_WORKER_MAX =
        65536,              // known at once; a newcomer then replaces the one gone for longest, and
                            // is ignored when nobody is gone: strangers cannot fill the memory
    ROSTER_STALL_COUNT = 3, // in a row that make a worker stalled: with 10 % loss each way one
                            // batch in five fails, three in a row fail once in 150
};

// A lease that was given up before its outcome came.
struct roster_missed {
    struct batch_identity batch; // with the attempt
    bool open;                   // its outcome has not come yet
};

enum roster_state {
    ROSTER_WORKING,
    ROSTER_SILENT,
    ROSTER_REFUSED,
    ROSTER_LEFT,
    ROSTER_STATE_COUNT
};

struct roster_worker {
    // As it says of itself.
    uint64_t id;
    char name[96];    // printable
    uint32_t threads; // >= 1
    uint32_t queue;   // batches it has beyond those leased to it: other coordinators'

    // As it was seen.
    enum roster_state state;
    int64_t heard_ns;        // last
    int64_t outcome_ns;      // last outcome
    struct estimate service; // its time for what a core is thought to do in 1 ns [ns / ns]
    struct estimate delay;   // from lease to outcome, beyond the work expected [ns]
    uint32_t measured_count; // outcomes that both were taken from
    int64_t least_ns;        // its least lease [ns], see roster_hurry()
    bool hurried;            // a lease of it was given up too soon
    struct roster_missed missed[ROSTER_MISSED_MAX];
    uint32_t missed_next; // the next one's place
    uint32_t stalls;      // leases late or lapsed since it was heard to work

    // What it holds.
    struct lease **leases; // (lease_count) of at most window_max
    uint32_t lease_count;
    uint32_t late_count; // of these
    uint32_t samples;    // in them
    int64_t load_ns;     // the work in them, as one core is thought to do it

    // Its places in the roster.
    uint64_t rate;               // its part of rate_total; 0 when it has none
    GList link;                  // in `heard` or `gone`
    struct heap_entry rank;      // in `room`
    struct heap_entry idle_rank; // in `idle`
};

struct roster {
    const struct schedule_settings *settings;
    GHashTable *workers;  // id -> struct roster_worker, owned
    GQueue heard;         // working ones, the one not heard for longest first
    GQueue gone;          // the others, likewise
    struct heap idle;     // those of them with nothing to do, as far as one can know
    struct heap room;     // working ones with room, the least loaded first, stalled ones last
    struct estimate core; // service x threads of all: what to expect of one not measured yet
    uint64_t rate_total;  // of working ones that are not stalled
    uint64_t joined;      // ever
    uint32_t refused;     // among `gone`
};

void roster_init(struct roster *roster, const struct schedule_settings *settings);
void roster_fini(struct roster *roster);

// The worker with that sender number, or NULL.
struct roster_worker *roster_find(const struct roster *roster, uint64_t id);

// Adds a worker, working or refused. NULL when the roster is full.
struct roster_worker *roster_add(struct roster *roster, uint64_t id, const char *name,
                                 uint32_t threads, enum roster_state state, int64_t now_ns);

// Moves a worker to another state; one that stops working holds no lease any more.
void roster_move(struct roster *roster, struct roster_worker *worker, enum roster_state state);

// A sign of life.
void roster_hear(struct roster *roster, struct roster_worker *worker, int64_t now_ns);

// The worker says it has `queue` batches: those leased to it, and other coordinators'. One that has
// nothing to do is not stalled: what it was given got lost.
void roster_queue(struct roster *roster, struct roster_worker *worker, uint32_t queue);

// The worker holds this lease from now on, or no longer.
void roster_hold(struct roster *roster, struct roster_worker *worker, struct lease *lease);
void roster_drop(struct roster *roster, struct roster_worker *worker, struct lease *lease);

// A lease it holds becomes late.
void roster_late(struct roster *roster, struct roster_worker *worker, struct lease *lease);

// An outcome says: work worth `cost_ns` on one core took it `service_ns`, and came back `delay_ns`
// after it was expected.
void roster_measure(struct roster *roster, struct roster_worker *worker, double cost_ns,
                    double service_ns, double delay_ns);

// It worked: not stalled (any more). / What it was leased at `start_ns` lapsed, or was late when
// another worker answered.
void roster_answered(struct roster *roster, struct roster_worker *worker, int64_t now_ns);
void roster_lapsed(struct roster *roster, struct roster_worker *worker, int64_t start_ns);

// How short leases may be is found out as TCP finds out how fast to send. The least lease begins at
// lease_new_ns and is halved with each outcome in time; once a lease was given up too soon, it is
// doubled for each of these, and comes down by a sixteenth with each outcome in time and by a
// quarter with each that was lost. So where nothing gets lost, one batch in 11 is copied for
// nothing at most (ln 2 / ln (16/15)), however unsteady the machines are.
//
// roster_hurry(): an outcome came in time. / roster_too_soon(): one came for which another worker
// had been asked too. / roster_missed(): the worker's lease was given up. / roster_came(): an
// outcome came, be it of a lease that had been given up, which then was too soon as well.
void roster_hurry(const struct roster *roster, struct roster_worker *worker);
void roster_missed(const struct roster *roster, struct roster_worker *worker,
                   const struct batch_identity *batch, uint32_t attempt);
void roster_came(const struct roster *roster, struct roster_worker *worker,
                 const struct batch_identity *batch);
void roster_too_soon(const struct roster *roster, struct roster_worker *worker);

bool roster_stalled(const struct roster_worker *worker);

// The worker's time for work worth 1 ns on one core: measured, else what others' cores take, else
// 1 / threads.
double roster_service(const struct roster *roster, const struct roster_worker *worker);

// How long the coordinator's loop takes to give each worker a batch and to take its outcome in,
// with half of its time.
int64_t roster_turn_ns(const struct roster *roster);

// How long a batch should take: batch_target_ns, or a turn if that is longer.
int64_t roster_target_ns(const struct roster *roster);

// The working worker with room that has least to do; `other` (may be NULL) only when there is no
// one else. NULL when nobody has room.
struct roster_worker *roster_pick(const struct roster *roster, const struct roster_worker *other);

// A working worker that has nothing to do, as far as one can know, and does not hold `batch`; one
// whose leases are all late if there is no other, and then a stalled one. NULL when there is none.
struct roster_worker *roster_idle(const struct roster *roster, const struct backlog_batch *batch);

// A working worker that has been silent for too long, or NULL.
struct roster_worker *roster_silent(const struct roster *roster, int64_t now_ns);

// How long a worker may be silent: silence_ns, and with very many of them, which announce
// themselves less often (common/base/pace.h), so much longer.
int64_t roster_silence_ns(const struct roster *roster);

// When roster_silent() may find one; INT64_MAX when there is nobody.
int64_t roster_wake_ns(const struct roster *roster);

// Forgets those gone for very long.
void roster_forget(struct roster *roster, int64_t now_ns);

#endif
