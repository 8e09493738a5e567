#include "common/wire/seal.h"

#include <assert.h>
#include <sodium.h>
#include <string.h>

// No message without a key begins like this: those begin with a type's fingerprint.
static const uint8_t mark[4] = {'S', 'B', 'X', '1'};

enum {
    PROTOCOL_PLACE = 4,
    NONCE_PLACE = 8,
    COVERED_SIZE = 96, // [bytes] for the clear bytes before the nonce and a channel's name
};

_Static_assert(SEAL_HEAD_SIZE - NONCE_PLACE == crypto_aead_xchacha20poly1305_ietf_NPUBBYTES,
               "the nonce is all of the head behind mark and protocol: adapt its numbers");
_Static_assert(SEAL_TAG_SIZE == crypto_aead_xchacha20poly1305_ietf_ABYTES,
               "the tag is the cipher's: adapt SEAL_TAG_SIZE");
_Static_assert(KEY_SIZE == crypto_aead_xchacha20poly1305_ietf_KEYBYTES,
               "the key is the cipher's: adapt KEY_SIZE");

static void put_u64(uint8_t *at, uint64_t value)
{
    for (int i = 7; i >= 0; i--, value >>= 8)
        at[i] = (uint8_t)value;
}

static uint64_t get_u64(const uint8_t *at)
{
    uint64_t value = 0;
    for (int i = 0; i < 8; i++)
        value = value << 8 | at[i];
    return value;
}

// What the tag covers besides the message and, as its nonce, the rest of the head.
static size_t cover(uint8_t covered[COVERED_SIZE], const uint8_t *head, const char *channel)
{
    size_t name = strlen(channel) + 1;
    assert(NONCE_PLACE + name <= COVERED_SIZE);
    memcpy(covered, head, NONCE_PLACE);
    memcpy(covered + NONCE_PLACE, channel, name);
    return NONCE_PLACE + name;
}

bool seal_is(const uint8_t *bytes, size_t size)
{
    return size >= SEAL_SIZE && memcmp(bytes, mark, sizeof mark) == 0;
}

void seal_close(uint8_t *packet, size_t size, const char *channel, const struct key *key,
                int32_t protocol, const struct seal_origin *origin)
{
    uint8_t covered[COVERED_SIZE];
    memcpy(packet, mark, sizeof mark);
    for (int i = 0; i < 4; i++)
        packet[PROTOCOL_PLACE + i] = (uint8_t)((uint32_t)protocol >> (24 - 8 * i));
    put_u64(packet + NONCE_PLACE, origin->sender);
    put_u64(packet + NONCE_PLACE + 8, origin->number);
    put_u64(packet + NONCE_PLACE + 16, origin->salt);
    size_t covered_size = cover(covered, packet, channel);
    uint8_t *message = packet + SEAL_HEAD_SIZE;
    crypto_aead_xchacha20poly1305_ietf_encrypt(message, NULL, message, size, covered, covered_size,
                                               NULL, packet + NONCE_PLACE, key->bytes);
}

bool seal_open(uint8_t *message, const uint8_t *packet, size_t size, const char *channel,
               const struct key *key, struct seal_origin *origin)
{
    uint8_t covered[COVERED_SIZE];
    if (!seal_is(packet, size))
        return false;
    size_t covered_size = cover(covered, packet, channel);
    *origin = (struct seal_origin){.sender = get_u64(packet + NONCE_PLACE),
                                   .number = get_u64(packet + NONCE_PLACE + 8),
                                   .salt = get_u64(packet + NONCE_PLACE + 16)};
    return crypto_aead_xchacha20poly1305_ietf_decrypt(message, NULL, NULL, packet + SEAL_HEAD_SIZE,
                                                      size - SEAL_HEAD_SIZE, covered, covered_size,
                                                      packet + NONCE_PLACE, key->bytes) == 0;
}
