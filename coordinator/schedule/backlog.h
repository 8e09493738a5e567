// What is to be done: the step each search waits for, the batches cut from it, and in which order
// they are handed out.
//
//            cut               lapsed, worker gone
//    (step) ----> [leased] ------------------------> [waiting]
//                  |    ^                             |   |
//                  |    +-----------------------------+   |
//                  |            handed out again          |
//                  +-----------> [counted] <--------------+
//                     outcome                 outcome
//
// A batch is cut when a worker takes it, so that its size follows what is known of that worker
// then. Once cut it keeps its identity over all attempts. Batches of a step never overlap; where
// their borders lie has no influence on any sample.
//
// Order: batches that wait again come first, because their steps wait for them; then one batch of
// each open step in turn, so that a search with huge steps does not hold up a thousand small ones;
// then, for idle workers, copies of late batches.
#ifndef SOBOX_COORDINATOR_SCHEDULE_BACKLOG_H
#define SOBOX_COORDINATOR_SCHEDULE_BACKLOG_H

#include "coordinator/schedule/lease.h"
#include "coordinator/schedule/schedule.h"

#include <glib.h>

enum backlog_state {
    BACKLOG_LEASED,  // to one worker or two
    BACKLOG_WAITING, // to be handed out again
    BACKLOG_COUNTED,
    BACKLOG_STATE_COUNT
};

struct backlog_batch {
    struct batch_identity identity; // attempt: of the next lease
    struct backlog_step *step;
    enum backlog_state state;
    uint64_t holder; // the last one's sender number
    struct lease leases[LEASE_KEPT_MAX];
    GList link;    // in `again` or `late`
    GQueue *queue; // the one it is in, or NULL
};

struct backlog_step {
    struct backlog_search *search;
    uint32_t step;
    uint32_t samples;
    uint32_t cut;     // samples in batches already
    uint32_t counted; // samples
    enum verdict_detail detail;
    double sample_ns;   // what a sample is thought to take one core [ns], > 0
    bool sample_known;  // said by the search, not assumed
    GPtrArray *batches; // by number
    GList link;         // in `open` while cut < samples
};

// A search is remembered after its step is done, so that an outcome that comes once more is known
// as a duplicate.
struct backlog_search {
    uint32_t search;
    bool any_done;
    uint32_t step_done;        // last finished
    struct backlog_step *step; // or NULL
};

struct backlog {
    GHashTable *searches;                 // number -> struct backlog_search, owned
    GQueue open;                          // steps with samples not cut, next turn first
    GQueue again;                         // batches that wait
    GQueue late;                          // leased batches that an idle worker may copy
    GPtrArray *spare;                     // batches of finished steps, to be used again
    uint64_t samples;                     // not counted yet
    uint64_t uncut[VERDICT_DETAIL_COUNT]; // samples not cut, of steps by detail
    uint32_t leased;                      // batches
};

// What an outcome is to the backlog.
enum backlog_match { BACKLOG_MATCH_OPEN, BACKLOG_MATCH_DUPLICATE, BACKLOG_MATCH_UNKNOWN };

void backlog_init(struct backlog *backlog);
void backlog_fini(struct backlog *backlog);

// A search wants a step; it has none open.
void backlog_add(struct backlog *backlog, uint32_t search, uint32_t step, uint32_t samples,
                 enum verdict_detail detail, double sample_ns);

// The search's open step, or NULL.
struct backlog_step *backlog_step(const struct backlog *backlog, uint32_t search);

// Removes a step whose leases have all ended; it is remembered as done, or the search forgotten.
void backlog_finish(struct backlog *backlog, struct backlog_step *step);
void backlog_cancel(struct backlog *backlog, struct backlog_step *step);

// Cuts the next `count` samples of an open step into a leased batch, and lets the next step have
// its turn.
struct backlog_batch *backlog_cut(struct backlog *backlog, struct backlog_step *step,
                                  uint32_t count);

// Moves a batch from state to state.
void backlog_move(struct backlog *backlog, struct backlog_batch *batch, enum backlog_state state);

// A leased batch may, or may no longer, be copied.
void backlog_set_late(struct backlog *backlog, struct backlog_batch *batch, bool late);

// Finds the batch an outcome belongs to: NULL when it is unknown or its step is done.
enum backlog_match backlog_match(const struct backlog *backlog,
                                 const struct batch_identity *identity,
                                 struct backlog_batch **found);

#endif
