// The coordinator of the simulated cluster: the real dispatcher and the real searches, a journal in
// memory, and the check that every sample of every step is counted once.
//
// Killed, it loses everything but its journal; started again, it replays that and goes on, as a run
// that is resumed.
#ifndef SOBOX_TESTS_CLUSTER_COORDINATOR_NODE_H
#define SOBOX_TESTS_CLUSTER_COORDINATOR_NODE_H

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/search/search.h"
#include "tests/cluster/network.h"
#include "tests/cluster/problem.h"

#include <glib.h>

struct coordinator_search {
    const struct scenario *scenario;
    GPtrArray *journal; // verdicts of each finished step; survives a kill
    struct search *search;
    struct search_request request; // while active
    bool active;
    GByteArray *text; // of the step's box
    struct digest box;
    struct verdict *verdicts;
    uint8_t *counted; // (samples) how often
};

struct coordinator_node {
    struct network *network;
    struct dice *dice;
    uint32_t worker_count;
    const struct schedule_settings *settings;
    bool boxes_by_request; // as if they were too large for a batch's message
    uint32_t piece_size;   // of texts [bytes]
    uint64_t run;

    bool running;
    uint64_t sender;
    int64_t stopped_until_ns;
    GQueue socket;
    struct dispatcher *dispatcher;
    int64_t now_ns;              // of the event being taken
    const struct verdict *heard; // of the outcome being taken
    GHashTable *places;          // sender number -> place of the worker
    struct coordinator_search searches[PROBLEM_SEARCHES];
    uint32_t search_count;
    uint32_t done_count;
    GQueue ready; // searches whose step is complete

    // What it did, over all its lives.
    struct schedule_counters counters; // of lives that ended
    uint64_t batches_sent;
};

void coordinator_node_init(struct coordinator_node *node, struct network *network,
                           struct dice *dice, const struct problem *problem, uint32_t search_count,
                           const struct schedule_settings *settings);
void coordinator_node_fini(struct coordinator_node *node);

void coordinator_node_start(struct coordinator_node *node, int64_t now_ns);
void coordinator_node_kill(struct coordinator_node *node);

void coordinator_node_receive(struct coordinator_node *node, struct packet *packet, int64_t now_ns);
void coordinator_node_wake(struct coordinator_node *node, int64_t now_ns);
int64_t coordinator_node_wake_ns(const struct coordinator_node *node);

// All searches are done.
bool coordinator_node_done(const struct coordinator_node *node);

// The counters of all its lives; gauges of this one.
void coordinator_node_counters(const struct coordinator_node *node,
                               struct schedule_counters *counters);

#endif
