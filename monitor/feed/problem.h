// What is wrong in a feed, in plain words and with the remedy where there is one.
#ifndef SOBOX_MONITOR_FEED_PROBLEM_H
#define SOBOX_MONITOR_FEED_PROBLEM_H

#include "monitor/feed/feed.h"

// Name of each kind, as programs see it.
#define PROBLEM_LIST(X)                                 \
    X(PROBLEM_COORDINATOR_SILENT, "coordinator_silent") \
    X(PROBLEM_NO_WORKERS, "no_workers")                 \
    X(PROBLEM_WORKERS_REFUSED, "workers_refused")       \
    X(PROBLEM_WORKER_SILENT, "worker_silent")           \
    X(PROBLEM_BATCHES_RELEASED, "batches_released")     \
    X(PROBLEM_WORKERS_IDLE, "workers_idle")             \
    X(PROBLEM_MESSAGES_LOST, "messages_lost")           \
    X(PROBLEM_DATAGRAMS_DROPPED, "datagrams_dropped")   \
    X(PROBLEM_FOREIGN_PROTOCOL, "foreign_protocol")     \
    X(PROBLEM_OTHER_KEY, "other_key")                   \
    X(PROBLEM_MONITOR_DEAF, "monitor_misses_messages")

enum problem_kind {
#define PROBLEM_ENUM(name, text) name,
    PROBLEM_LIST(PROBLEM_ENUM)
#undef PROBLEM_ENUM
        PROBLEM_KIND_COUNT
};

enum {
    PROBLEM_TEXT_SIZE = 256, // [bytes]
    PROBLEM_NAMED_MAX = 8,   // workers named one by one for the same reason; the rest are counted
};

struct problem {
    enum problem_kind kind;
    uint64_t run; // that it is about; 0: of the network
    char text[PROBLEM_TEXT_SIZE];
};

// The problems at this moment, as an array of struct problem that the caller frees. Seconds in the
// texts are whole, so that a text changes at most once a second.
GArray *problem_list(const struct feed *feed, int64_t now_ns);

const char *problem_name(enum problem_kind kind);

#endif
