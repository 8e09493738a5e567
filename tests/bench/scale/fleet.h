// The simulated workers. Each has a queue that its cores work off in order, as the engine does: a
// batch takes its samples' time divided by the cores, and the next one is begun before the last
// part of the one before is done. What they compute is nobody's business here (the coordinator
// fills in the verdicts); when they answer is.
#ifndef SOBOX_TESTS_BENCH_SCALE_FLEET_H
#define SOBOX_TESTS_BENCH_SCALE_FLEET_H

#include "tests/bench/scale/costs.h"
#include "tests/cluster/network.h"

#include <glib.h>

struct fleet_worker {
    uint64_t sender;
    uint32_t place;        // in the network
    GQueue queue;          // of struct packet: batches not answered, in order
    int64_t free_ns;       // when its cores are done with what is in the queue
    int64_t answer_ns;     // when it answers the last of the queue
    GQueue answers;        // of int64_t: when it answers each
    struct heap_entry due; // the first of them
    uint64_t heard;        // of fleet.told, up to its last batch
};

struct fleet {
    const struct costs *costs;
    struct network *network;
    struct dice *dice;
    uint32_t count;
    uint32_t threads;             // of each
    struct fleet_worker *workers; // (count)
    struct heap due;
    uint64_t told;           // messages that all workers hear: batches and statuses
    int64_t status_ns;       // when the next one announces itself
    uint32_t status_next;    // which
    int64_t status_every_ns; // between two of all of them
};

void fleet_init(struct fleet *fleet, const struct costs *costs, struct network *network,
                struct dice *dice, uint32_t count, uint32_t threads);
void fleet_fini(struct fleet *fleet);

// A batch has arrived; the packet is the fleet's from now on.
void fleet_receive(struct fleet *fleet, struct packet *packet, int64_t now_ns);

// Sends what is due, and when something will be.
void fleet_wake(struct fleet *fleet, int64_t now_ns);
int64_t fleet_wake_ns(const struct fleet *fleet);

#endif
