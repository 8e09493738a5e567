// The 16 bytes behind every encoded message: BLAKE2b (libsodium) over the channel's name with its
// NUL and the encoded bytes. Without a key it is a checksum that catches damage and foreign
// traffic; with a key nobody without it can make one.
//
// The channel is part of it, so that a message recorded on one channel is not valid on another.
// Decoders of LCM's own tools ignore what follows an encoded message, so lcm-spy still reads ours.
#ifndef SOBOX_COMMON_WIRE_TAG_H
#define SOBOX_COMMON_WIRE_TAG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { TAG_SIZE = 16, TAG_KEY_SIZE = 32 }; // [bytes]

struct tag_key {
    uint8_t bytes[TAG_KEY_SIZE];
};

// Computes the tag of `size` encoded bytes. `key` is NULL where none is shared.
void tag_compute(uint8_t tag[TAG_SIZE], const char *channel, const uint8_t *bytes, size_t size,
                 const struct tag_key *key);

// Whether `tag` is theirs; takes the same time wherever it differs.
bool tag_matches(const uint8_t tag[TAG_SIZE], const char *channel, const uint8_t *bytes,
                 size_t size, const struct tag_key *key);

#endif
