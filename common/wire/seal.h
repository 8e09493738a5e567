// The sealed envelope in which messages travel where a key is shared: encrypted and authenticated
// with XChaCha20-Poly1305 (libsodium). Who has not the key learns a message's channel, size and
// moment, and can make none.
//
//     0       4          8        16       24     32              size - 16   size
//     +-------+----------+--------+--------+------+-------------------+---------+
//     | mark  | protocol | sender | number | salt | encoded message   | tag     |
//     |       |          |       nonce            | (encrypted)       |         |
//     +-------+----------+------------------------+-------------------+---------+
//
// Integers are big-endian. The tag also covers mark, protocol, nonce and the channel's name, so
// that a message recorded on one channel is not valid on another. No nonce comes twice under a key:
// `number` counts the messages of one wire, `sender` and `salt` are 127 random bits of its own.
#ifndef SOBOX_COMMON_WIRE_SEAL_H
#define SOBOX_COMMON_WIRE_SEAL_H

#include "common/wire/key.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    SEAL_HEAD_SIZE = 32,                        // [bytes] before the encrypted message
    SEAL_TAG_SIZE = 16,                         // [bytes] after it
    SEAL_SIZE = SEAL_HEAD_SIZE + SEAL_TAG_SIZE, // [bytes] that sealing adds
};

// Which message of whose: what replays are known by (fresh.h).
struct seal_origin {
    uint64_t sender; // of its header; not 0
    uint64_t salt;   // random number of the wire
    uint64_t number; // 1, 2, 3, ... over all messages of the wire
};

// Whether the bytes begin as an envelope does. Says nothing about its content.
bool seal_is(const uint8_t *bytes, size_t size);

// Seals in place: `packet` holds SEAL_HEAD_SIZE bytes of room, then `size` bytes of encoded
// message, then SEAL_TAG_SIZE bytes of room.
void seal_close(uint8_t *packet, size_t size, const char *channel, const struct key *key,
                int32_t protocol, const struct seal_origin *origin);

// Opens an envelope of `size` bytes into `message` (size - SEAL_SIZE bytes, not overlapping). False
// when it is none, or made with another key or for another channel, or damaged.
bool seal_open(uint8_t *message, const uint8_t *packet, size_t size, const char *channel,
               const struct key *key, struct seal_origin *origin);

#endif
