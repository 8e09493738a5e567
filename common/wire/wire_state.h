// What a wire holds; for the sources of this folder only.
#ifndef SOBOX_COMMON_WIRE_WIRE_STATE_H
#define SOBOX_COMMON_WIRE_WIRE_STATE_H

#include "common/wire/check.h"
#include "common/wire/key.h"
#include "common/wire/link.h"
#include "common/wire/sequence.h"
#include "common/wire/stranger.h"
#include "common/wire/tag.h"
#include "common/wire/url.h"
#include "common/wire/wire.h"

#include <glib.h>
#include <lcm/lcm.h>

// One lcm_t a port; with memq:// there is only the first, for all kinds.
struct wire_port {
    lcm_t *lcm;            // NULL while LCM could not be opened
    bool listening;        // its descriptor is polled; a port that only sends never binds
    int socket;            // that LCM receives with, owned by LCM; -1 with memq://
    uint32_t buffer_size;  // the kernel granted [bytes]
    uint32_t dropped_last; // the kernel's count when last read
};

// One kind of message: who handles it, and this process's next number for it.
struct wire_slot {
    struct wire *wire;
    enum wire_kind kind;
    wire_handler *handler; // NULL: not subscribed
    void *user;
    uint32_t sequence;
    bool overheard; // taken from senders that have not proven that they are there
};

struct wire {
    struct url url;
    uint32_t mtu;
    uint64_t sender;
    const struct key *key; // borrowed; NULL: messages travel in clear
    struct door *door;     // NULL without a key
    struct wire_port ports[WIRE_PORT_COUNT];
    struct link *link; // to the hub of tcpq://, for all kinds; else NULL, and the ports are in use
    struct wire_slot slots[WIRE_KIND_COUNT];
    struct wire_counters counters;
    struct sequence *heard;
    struct strangers strangers;
    size_t queued;                // messages in memq's queue
    bool dispatching;             // LCM does not allow to handle within a handler
    bool buffer_noted;            // the user was told of a small receive buffer
    GSource *source;              // NULL while detached
    uint8_t packet[WIRE_MTU_MAX]; // being sent
    uint8_t opened[WIRE_MTU_MAX]; // being received, where a key is shared
};

// The check of a message that arrived for the slot came to `result`: counts it, and hands it on and
// releases it when it is good.
void wire_take(struct wire_slot *slot, enum check_result result, union codec_message *message);

// A message of `kind` that no key of ours opens arrived.
void wire_stranger(struct wire *wire, enum wire_kind kind, enum stranger stranger);

// Hands the `size` bytes of the wire's packet to LCM.
enum status wire_send(struct wire *wire, enum wire_kind kind, size_t size) MUST_USE;

#endif
