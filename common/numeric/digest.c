#include "common/numeric/digest.h"

#include <string.h>

_Static_assert(DIGEST_SIZE >= crypto_generichash_BYTES_MIN, "libsodium makes no shorter hash");

void digest_start(struct digest_state *state)
{
    crypto_generichash_init(&state->state, NULL, 0, DIGEST_SIZE);
}

void digest_bytes(struct digest_state *state, const void *bytes, size_t size)
{
    crypto_generichash_update(&state->state, bytes, size);
}

void digest_u64(struct digest_state *state, uint64_t value)
{
    uint8_t bytes[8];
    for (int i = 0; i < 8; i++)
        bytes[i] = (uint8_t)(value >> (8 * i));
    digest_bytes(state, bytes, sizeof bytes);
}

void digest_doubles(struct digest_state *state, const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        digest_u64(state, bits);
    }
}

struct digest digest_end(struct digest_state *state)
{
    struct digest digest;
    crypto_generichash_final(&state->state, digest.bytes, DIGEST_SIZE);
    return digest;
}

struct digest digest_of(const void *bytes, size_t size)
{
    struct digest_state state;
    digest_start(&state);
    digest_bytes(&state, bytes, size);
    return digest_end(&state);
}

bool digest_equal(const struct digest *a, const struct digest *b)
{
    return memcmp(a->bytes, b->bytes, DIGEST_SIZE) == 0;
}

const char *digest_hex(const struct digest *digest, char hex[DIGEST_HEX_SIZE])
{
    return sodium_bin2hex(hex, DIGEST_HEX_SIZE, digest->bytes, DIGEST_SIZE);
}
