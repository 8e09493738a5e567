#include "common/wire/codec.h"

#include <string.h>

sobox_batch_t codec_batch(const struct batch_identity *identity)
{
    return (sobox_batch_t){
        .search = (int32_t)identity->search,
        .step = (int32_t)identity->step,
        .batch = (int32_t)identity->batch,
        .attempt = (int32_t)identity->attempt,
        .first = (int32_t)identity->first,
        .count = (int32_t)identity->count,
    };
}

struct batch_identity codec_identity(const sobox_batch_t *batch)
{
    return (struct batch_identity){
        .search = (uint32_t)batch->search,
        .step = (uint32_t)batch->step,
        .batch = (uint32_t)batch->batch,
        .attempt = (uint32_t)batch->attempt,
        .first = (uint32_t)batch->first,
        .count = (uint32_t)batch->count,
    };
}

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
