// One storm: a cluster drawn from a seed, run to its end through everything that can go wrong, and
// held against the calm run.
//
// Until the weather clears (at clear_ns) packets are lost, doubled, delayed and overtaken, and
// faults strike; after that the network is clean, everyone who should be there is started, and the
// run must end soon. Checked all along: a sample counts once, nothing is sent to a worker of
// another version, leases and queues stay within their bounds. Checked at the end: the digests of
// the calm run, all samples counted, no lease left.
#ifndef SOBOX_TESTS_CLUSTER_STORM_H
#define SOBOX_TESTS_CLUSTER_STORM_H

#include "coordinator/schedule/schedule.h"
#include "tests/cluster/problem.h"

struct storm_report {
    int64_t end_ns;   // virtual time at which all searches were done
    int64_t after_ns; // of it after the weather cleared; 0 when it was done before
    uint32_t workers;
    uint32_t faults;    // that struck
    uint64_t packets;   // sent
    uint64_t batches;   // sent
    uint64_t samples;   // of the searches
    uint64_t evaluated; // by all workers
    struct schedule_counters counters;
};

// Runs storm `seed`; ends the program when it fails. With `calm` the same cluster under a clear
// sky: nothing may be wasted then.
void storm_run(const struct problem *problem, uint64_t seed, bool calm,
               struct storm_report *report);

#endif
