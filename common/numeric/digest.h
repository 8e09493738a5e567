// A 128-bit BLAKE2b hash (libsodium): the name of a text or a box on the network, and the digest by
// which two runs are compared. Numbers are fed as little-endian bytes.
#ifndef SOBOX_COMMON_NUMERIC_DIGEST_H
#define SOBOX_COMMON_NUMERIC_DIGEST_H

#include <sodium.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { DIGEST_SIZE = 16, DIGEST_HEX_SIZE = 2 * DIGEST_SIZE + 1 }; // [bytes]

struct digest {
    uint8_t bytes[DIGEST_SIZE];
};

struct digest_state {
    crypto_generichash_state state;
};

void digest_start(struct digest_state *state);
void digest_bytes(struct digest_state *state, const void *bytes, size_t size);
void digest_u64(struct digest_state *state, uint64_t value);
void digest_doubles(struct digest_state *state, const double *values, size_t count); // IEEE bits
struct digest digest_end(struct digest_state *state);

// The digest of one piece of memory.
struct digest digest_of(const void *bytes, size_t size);

bool digest_equal(const struct digest *a, const struct digest *b);

// Writes 32 lower-case hexadecimal digits and a NUL; returns `hex`.
const char *digest_hex(const struct digest *digest, char hex[DIGEST_HEX_SIZE]);

#endif
