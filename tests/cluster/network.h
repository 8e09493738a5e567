// The network of the simulated cluster: packets on their way, with everything UDP multicast does to
// them. Place 0 is the coordinator's, 1 .. NETWORK_PLACE_MAX - 1 are the workers'.
//
//     network_send() -> lost?  -> doubled? -> delayed, now and then much longer ->
//     network_receive()
//                       cut off?                (so packets overtake each other)
#ifndef SOBOX_TESTS_CLUSTER_NETWORK_H
#define SOBOX_TESTS_CLUSTER_NETWORK_H

#include "common/numeric/digest.h"
#include "common/numeric/verdict.h"
#include "common/sampling/sampling.h"
#include "coordinator/schedule/heap.h"
#include "coordinator/schedule/schedule.h"
#include "tests/cluster/dice.h"

enum {
    NETWORK_PLACE_MAX = 8200, // a worker each but one
    NETWORK_SEND_NS = 2000,   // a packet takes its sender: packets of one place leave one by one
};

enum message_kind {
    MESSAGE_BATCH,        // coordinator -> worker
    MESSAGE_TEXT,         // coordinator -> worker
    MESSAGE_OUTCOME,      // worker -> coordinator
    MESSAGE_TEXT_REQUEST, // worker -> coordinator
    MESSAGE_WORKER,       // worker -> coordinator
};

// What the messages of lcmtypes/ say, in memory.
struct message {
    enum message_kind kind;
    uint64_t sender;
    uint64_t run;
    union {
        struct {
            uint64_t holder;
            struct batch_identity identity;
            struct digest scenario;
            struct digest box;
            struct sampling sampling;
            enum verdict_detail detail;
            uint32_t variables; // payload: the text of the box
        } batch;
        struct {
            struct digest digest;
            uint32_t total;
            uint32_t offset; // payload: the piece
        } text;
        struct {
            struct batch_identity identity;
            enum verdict_detail detail;
            uint32_t queue;
            int64_t service_ns; // payload: the packed verdicts
        } outcome;
        struct {
            struct digest digest;
            uint32_t offset;
        } request;
        struct {
            uint32_t threads;
            uint32_t queue;
            bool leaving;
            bool acceptable;
        } worker;
    };
    uint32_t payload_size;  // [bytes]
    const uint8_t *payload; // borrowed by network_send(), owned by a received packet
};

// How bad it is.
struct weather {
    double loss;      // probability that a packet is lost
    double twice;     // probability that it comes twice
    double stray;     // probability that it is delayed by stray_ns more: it is overtaken
    double delay_ns;  // one way, at least
    double jitter_ns; // mean of what comes on top
    double stray_ns;
};

struct packet {
    uint32_t from;
    uint32_t to;
    struct message message;
    struct heap_entry due;
};

struct network {
    struct weather weather;
    struct dice *dice;
    struct heap packets;
    uint64_t sent;
    int64_t free_ns[NETWORK_PLACE_MAX]; // when a place's interface has sent what it was given
    int64_t cut_until_ns[NETWORK_PLACE_MAX][2]; // nothing comes from / goes to that place before
};

void network_init(struct network *network, struct dice *dice);
void network_fini(struct network *network);

// Sends a copy of the message from place to place.
void network_send(struct network *network, uint32_t from, uint32_t to,
                  const struct message *message, int64_t now_ns);

// When the next packet arrives; INT64_MAX when none is on its way.
int64_t network_wake_ns(const struct network *network);

// The next packet that has arrived, or NULL. The caller releases it with network_drop().
struct packet *network_receive(struct network *network, int64_t now_ns);

void network_drop(struct packet *packet);

#endif
