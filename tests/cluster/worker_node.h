// A worker of the simulated cluster: the real intake and the real evaluation, with a virtual clock,
// a virtual duration, and virtual misfortunes. A node is a machine: processes on it come and go,
// each with a sender number of its own.
//
//     dead --start--> running --stop--> stopped (packets pile up in its socket) --continue-->
//     running
//       ^               |   ^
//       +---- kill, ----+   |  stuck: the evaluation in work does not end before a given time,
//             leave         |  announcements go on
#ifndef SOBOX_TESTS_CLUSTER_WORKER_NODE_H
#define SOBOX_TESTS_CLUSTER_WORKER_NODE_H

#include "tests/cluster/network.h"
#include "worker/batch/intake.h"

#include <glib.h>

struct worker_node {
    // Where and how.
    struct network *network;
    struct dice *dice;
    uint32_t place;
    double sample_ns;   // one thread, one sample
    double overhead_ns; // a batch, whatever its size
    uint32_t threads;
    bool wrong_version; // its kernel is another one's

    // The process.
    bool running;
    uint64_t sender;
    struct intake *intake;
    int64_t status_ns; // next announcement
    bool busy;
    struct intake_work work;
    int64_t work_start_ns;
    int64_t work_end_ns;

    // Misfortunes.
    int64_t stopped_until_ns;
    int64_t stuck_until_ns;
    double slowness; // factor on every duration
    GQueue socket;   // packets that wait while it is stopped

    // What it did.
    uint64_t evaluated; // samples
    uint32_t queue_most;
};

enum { WORKER_NODE_SOCKET_MAX = 300 }; // packets that wait at most; the others are lost

void worker_node_init(struct worker_node *node, struct network *network, struct dice *dice,
                      uint32_t place);
void worker_node_fini(struct worker_node *node);

// A process starts, or ends: at once, or with a last word.
void worker_node_start(struct worker_node *node, int64_t now_ns);
void worker_node_kill(struct worker_node *node);
void worker_node_leave(struct worker_node *node, int64_t now_ns);

// Takes a packet (and releases it).
void worker_node_receive(struct worker_node *node, struct packet *packet, int64_t now_ns);

// Does what is due.
void worker_node_wake(struct worker_node *node, int64_t now_ns);

// When something will be; INT64_MAX when nothing.
int64_t worker_node_wake_ns(const struct worker_node *node);

#endif
