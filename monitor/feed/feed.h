// What a monitor knows: the runs, searches and workers it has heard of, from the status messages
// alone. Pure: messages and time come in, the picture is read out. It only listens, so any number
// of monitors may come and go without a run noticing.
//
// Everything is bounded. When a table is full the entry unheard for longest makes room.
#ifndef SOBOX_MONITOR_FEED_FEED_H
#define SOBOX_MONITOR_FEED_FEED_H

#include "sobox_run_status_t.h"
#include "sobox_search_status_t.h"
#include "sobox_worker_status_t.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    FEED_RUN_MAX = 64,
    FEED_SEARCH_MAX = 16384, // of all runs
    FEED_WORKER_MAX = 4096,
};

struct feed_worker {
    uint64_t id;   // its sender number
    char name[96]; // host/process
    uint32_t threads;
    uint32_t queue; // batches waiting and in work
    uint64_t batches, samples;
    double rate;      // samples a second, between its last two messages
    double busy;      // share of that time spent evaluating, 0 .. 1
    uint64_t lost;    // messages it knows it missed
    uint64_t dropped; // datagrams its kernel dropped
    bool left;        // it said that it ends
    int64_t heard_ns;
    int64_t busy_ns, uptime_ns; // as it last said
};

struct feed_search {
    uint64_t run;
    uint32_t index;
    int phase;  // enum search_phase
    int status; // enum search_status
    uint32_t step, step_count;
    uint64_t evaluations;
    double good_share;
    double log_volume;
    double purity_lower95; // 0 until certified
    GArray *bounds;        // double: lower, then upper; empty where the box was too large to travel
    int64_t heard_ns;
};

struct feed_run {
    uint64_t id;
    char name[64];
    int state; // as in run_status_t.lcm
    uint32_t searches, searches_done;
    uint32_t workers, workers_refused;
    uint64_t samples, batches, released, duplicates, rejected, lost;
    double rate; // samples a second, between its last two messages
    int64_t elapsed_ns;
    int64_t heard_ns;
};

// Read-only to all but the functions below. Entries stand in the order in which they were first
// heard.
struct feed {
    GPtrArray *runs;     // struct feed_run *
    GPtrArray *searches; // struct feed_search *
    GPtrArray *workers;  // struct feed_worker *
};

void feed_init(struct feed *feed);
void feed_fini(struct feed *feed);

// A message was heard at `now_ns` (monotonic). Nothing of it is kept but copies.
void feed_run_heard(struct feed *feed, const sobox_run_status_t *message, int64_t now_ns);
void feed_search_heard(struct feed *feed, const sobox_search_status_t *message, int64_t now_ns);
void feed_worker_heard(struct feed *feed, const sobox_worker_status_t *message, int64_t now_ns);

// The search of a run, or NULL.
const struct feed_search *feed_search_find(const struct feed *feed, uint64_t run, uint32_t index);

#endif
