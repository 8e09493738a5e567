// The 16 bytes behind every encoded message that travels without a key: BLAKE2b (libsodium) over
// the channel's name with its NUL and the encoded bytes. It is a checksum that catches damage and
// foreign traffic and keeps nobody out: anyone can make one. With a key messages are sealed instead
// (seal.h).
//
// The channel is part of it, so that a message recorded on one channel is not valid on another.
// Decoders of LCM's own tools ignore what follows an encoded message, so lcm-spy still reads ours.
#ifndef SOBOX_COMMON_WIRE_TAG_H
#define SOBOX_COMMON_WIRE_TAG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { TAG_SIZE = 16 }; // [bytes]

// Computes the tag of `size` encoded bytes.
void tag_compute(uint8_t tag[TAG_SIZE], const char *channel, const uint8_t *bytes, size_t size);

// Whether `tag` is theirs.
bool tag_matches(const uint8_t tag[TAG_SIZE], const char *channel, const uint8_t *bytes,
                 size_t size);

#endif
