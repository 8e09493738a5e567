#include "common/wire/frame.h"

#include <assert.h>
#include <string.h>

#define MAGIC_HUB 0x287617fau
#define MAGIC_CLIENT 0x287617fbu
#define VERSION 0x0100u

enum { WORD_SIZE = 4 }; // [bytes]

static uint32_t read_word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

static uint8_t *write_word(uint8_t *bytes, uint32_t word)
{
    for (int shift = 24; shift >= 0; shift -= 8)
        *bytes++ = (uint8_t)(word >> shift);
    return bytes;
}

void frame_hello(enum frame_side side, uint8_t bytes[FRAME_HELLO_SIZE])
{
    write_word(write_word(bytes, side == FRAME_HUB ? MAGIC_HUB : MAGIC_CLIENT), VERSION);
}

bool frame_is_hello(enum frame_side side, const uint8_t bytes[FRAME_HELLO_SIZE])
{
    return read_word(bytes) == (side == FRAME_HUB ? MAGIC_HUB : MAGIC_CLIENT);
}

static enum frame_result cut(struct frame *frame, size_t needed)
{
    frame->size = needed;
    return FRAME_CUT;
}

enum frame_result frame_read(enum frame_side side, const uint8_t *bytes, size_t size,
                             size_t data_max, struct frame *frame)
{
    size_t place = 2 * WORD_SIZE;
    if (size < place)
        return cut(frame, place);
    uint32_t type = read_word(bytes), name_size = read_word(bytes + WORD_SIZE);
    bool publishes = type == FRAME_PUBLISH;
    if (!publishes && (side == FRAME_HUB || (type != FRAME_SUBSCRIBE && type != FRAME_UNSUBSCRIBE)))
        return FRAME_WRONG;
    if (name_size == 0 || name_size > (publishes ? FRAME_CHANNEL_MAX : FRAME_PATTERN_MAX))
        return FRAME_WRONG;
    *frame = (struct frame){.type = (enum frame_type)type, .name_size = name_size};
    place += name_size + (publishes ? WORD_SIZE : 0);
    if (size < place)
        return cut(frame, place);
    frame->name = (const char *)bytes + 2 * WORD_SIZE;
    if (memchr(frame->name, '\0', name_size) != NULL)
        return FRAME_WRONG;
    if (publishes)
        frame->data_size = read_word(bytes + place - WORD_SIZE);
    frame->data = bytes + place;
    frame->size = place + frame->data_size;
    if (frame->data_size > data_max)
        return FRAME_LARGE;
    return size < frame->size ? FRAME_CUT : FRAME_WHOLE;
}

size_t frame_head(uint8_t *bytes, enum frame_type type, const char *name, size_t name_size,
                  size_t data_size)
{
    assert(name_size > 0 && data_size <= UINT32_MAX);
    uint8_t *end = write_word(write_word(bytes, type), (uint32_t)name_size);
    memcpy(end, name, name_size);
    end += name_size;
    if (type == FRAME_PUBLISH)
        end = write_word(end, (uint32_t)data_size);
    return (size_t)(end - bytes);
}
