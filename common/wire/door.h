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
    // Moments at which messages were sent, one in DOOR_MOMENT_NS at most, by which a question finds
    // out what is younger than its challenge: the last second of a busy sender, minutes of others.
    DOOR_MOMENTS_MAX = 256,
};

#define DOOR_MOMENT_NS INT64_C(5000000)

// A question is on its way while the challenge grows older; on a busy machine for some tens of
// milliseconds or more, in which the first status of a worker would pass for old. So much older
// than the challenge a message of a sender that is there may be. [ns]
#define DOOR_SLACK_NS INT64_C(1000000000)

struct door_answer {
    uint8_t challenge[FRESH_CHALLENGE_SIZE];
    int64_t answered_ns;
};

struct door_moment {
    int64_t sent_ns;
    uint64_t before; // number of the last message before
};

struct door {
    struct fresh *fresh;
    struct seal_origin origin; // of this wire's last message
    struct door_answer answered[DOOR_ANSWERED_MAX];
    size_t answered_next; // place of the oldest
    struct door_moment moments[DOOR_MOMENTS_MAX];
    size_t moment_count; // so far: the last is at moment_count - 1, wrapped
};

// A door for the wire, which has its key and sender number.
struct door *door_create(const struct wire *wire);
void door_free(struct door *door); // NULL is fine

// Seals the message of `size` bytes that was encoded into the wire's packet behind SEAL_HEAD_SIZE
// bytes.
void door_seal(struct wire *wire, enum wire_kind kind, size_t size);

// Takes a packet that arrived for the slot.
void door_receive(struct wire_slot *slot, const uint8_t *packet, size_t size);

// When door_tick() has something to do; INT64_MAX: not before a packet arrives.
int64_t door_wake_ns(const struct wire *wire);

// Asks again who has not answered, refuses what has been held too long.
void door_tick(struct wire *wire, int64_t now_ns);

#endif
