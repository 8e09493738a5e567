#include "common/wire/tag.h"

#include <sodium.h>
#include <string.h>

void tag_compute(uint8_t tag[TAG_SIZE], const char *channel, const uint8_t *bytes, size_t size)
{
    crypto_generichash_state state;
    crypto_generichash_init(&state, NULL, 0, TAG_SIZE);
    crypto_generichash_update(&state, (const uint8_t *)channel, strlen(channel) + 1);
    crypto_generichash_update(&state, bytes, size);
    crypto_generichash_final(&state, tag, TAG_SIZE);
}

bool tag_matches(const uint8_t tag[TAG_SIZE], const char *channel, const uint8_t *bytes,
                 size_t size)
{
    uint8_t right[TAG_SIZE];
    tag_compute(right, channel, bytes, size);
    return memcmp(right, tag, TAG_SIZE) == 0;
}
