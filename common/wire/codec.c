#include "common/wire/codec.h"

#include <string.h>

size_t codec_encoded_size(enum wire_kind kind, const void *message)
{
    switch (kind) {
#define CODEC_CASE(value, name) \
    case value:                 \
        return (size_t)sobox_##name##_t_encoded_size(message);
        CODEC_LIST(CODEC_CASE)
#undef CODEC_CASE
    case WIRE_KIND_COUNT:
        break;
    }
    return 0;
}

bool codec_encode(enum wire_kind kind, const void *message, uint8_t *bytes, size_t size)
{
    switch (kind) {
#define CODEC_CASE(value, name) \
    case value:                 \
        return sobox_##name##_t_encode(bytes, 0, (int)size, message) >= 0;
        CODEC_LIST(CODEC_CASE)
#undef CODEC_CASE
    case WIRE_KIND_COUNT:
        break;
    }
    return false;
}

bool codec_decode(enum wire_kind kind, const uint8_t *bytes, size_t size,
                  union codec_message *message)
{
    // Zeroed, because a decoder that fails leaves its pointers unset.
    memset(message, 0, sizeof *message);
    switch (kind) {
#define CODEC_CASE(value, name) \
    case value:                 \
        return sobox_##name##_t_decode(bytes, 0, (int)size, &message->name) == (int)size;
        CODEC_LIST(CODEC_CASE)
#undef CODEC_CASE
    case WIRE_KIND_COUNT:
        break;
    }
    return false;
}

void codec_release(enum wire_kind kind, union codec_message *message)
{
    switch (kind) {
#define CODEC_CASE(value, name)                          \
    case value:                                          \
        sobox_##name##_t_decode_cleanup(&message->name); \
        break;
        CODEC_LIST(CODEC_CASE)
#undef CODEC_CASE
    case WIRE_KIND_COUNT:
        break;
    }
    memset(message, 0, sizeof *message);
}

int64_t codec_fingerprint(enum wire_kind kind)
{
    switch (kind) {
#define CODEC_CASE(value, name) \
    case value:                 \
        return __sobox_##name##_t_get_hash();
        CODEC_LIST(CODEC_CASE)
#undef CODEC_CASE
    case WIRE_KIND_COUNT:
        break;
    }
    return 0;
}
