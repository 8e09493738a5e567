// Who else is there, as far as a worker cares: the coordinators it should introduce itself to, and
// about how many workers will do the same at that moment.
#ifndef SOBOX_WORKER_RUNTIME_PRESENCE_H
#define SOBOX_WORKER_RUNTIME_PRESENCE_H

#include <stdbool.h>
#include <stdint.h>

enum {
    // Coordinators remembered. One more takes the place of the one silent for longest: it costs a
    // greeting too many, never a batch.
    PRESENCE_COORDINATOR_MAX = 64,
    // Workers that may answer a new coordinator all at once; more spread their answers, because a
    // default socket buffer holds a few hundred small messages.
    PRESENCE_CROWD = 8,
    PRESENCE_SPREAD_MS = 20,   // over which a crowd's answers are spread at least [ms]
    PRESENCE_SPREAD_RATE = 20, // of a greater crowd: answers in a millisecond, at most
};

// Coordinators speak once a second; after so long without a word one is gone. [ns]
#define PRESENCE_SILENCE_NS INT64_C(5000000000)

struct presence_coordinator {
    uint64_t sender;
    int64_t heard_ns;
};

struct presence {
    struct presence_coordinator coordinators[PRESENCE_COORDINATOR_MAX]; // (coordinator_count)
    uint32_t coordinator_count;
    uint32_t workers;         // heard in the last whole second, this one included
    uint32_t workers_counted; // heard so far in this second
    uint32_t pace;            // seconds between this worker's announcements; 0: not begun, as 1
    uint32_t waited;          // seconds since the last one
};

// A coordinator was heard. True when it is new, or was silent for so long that it may be.
bool presence_coordinator(struct presence *presence, uint64_t sender, int64_t now_ns);

// A coordinator said that its run has ended.
void presence_coordinator_ended(struct presence *presence, uint64_t sender);

// A worker's status was heard.
void presence_worker(struct presence *presence);

// A second is over. True when this worker should announce itself: with very many workers not in
// every second, see common/base/pace.h.
bool presence_second(struct presence *presence);

// Coordinators that are not silent.
uint32_t presence_coordinator_count(const struct presence *presence, int64_t now_ns);

// Whether so many workers are there that they should not all answer at once.
bool presence_crowded(const struct presence *presence);

// Over how long a crowd's answers should be spread [ms].
uint32_t presence_spread_ms(const struct presence *presence);

#endif
