// The way in and out for a wire that has a key: seals what is sent, opens what arrives, asks
// unknown senders for a proof that they are there and gives its own (fresh.h says why). For the
// sources of this folder only.
#ifndef SOBOX_COMMON_WIRE_DOOR_H
#define SOBOX_COMMON_WIRE_DOOR_H

#include "common/wire/fresh.h"
#include "common/wire/wire_state.h"

enum {
    // Challenges answered lately: a recorded question that is played again and again is answered
    // once in FRESH_ASK_NS / 2.
    DOOR_ANSWERED_MAX = 64,
};

struct door_answer {
    uint8_t challenge[FRESH_CHALLENGE_SIZE];
    int64_t answered_ns;
};

struct door {
    struct fresh *fresh;
    struct seal_origin origin; // of this wire's last message
    struct door_answer answered[DOOR_ANSWERED_MAX];
    size_t answered_next;                // place of the oldest
    GByteArray *states[WIRE_KIND_COUNT]; // the last message of a kind that tells a state; or NULL
};

// A door for the wire, which has its key and sender number.
struct door *door_create(const struct wire *wire);
void door_free(struct door *door); // NULL is fine

// Seals the message of `size` bytes that was encoded into the wire's packet behind SEAL_HEAD_SIZE
// bytes. What tells a state is remembered, to be said again to those who listen later.
void door_seal(struct wire *wire, enum wire_kind kind, size_t size);

// Takes a packet that arrived for the slot.
void door_receive(struct wire_slot *slot, const uint8_t *packet, size_t size);

// Refuses what has waited too long for its sender's proof.
void door_expire(struct wire *wire);

#endif
