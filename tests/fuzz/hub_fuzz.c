// Bytes from two clients of a hub: a record is whose (1 byte: bit 0 the client, bits 1 and up how
// many seconds later), its size (2 bytes), then the bytes. Whatever comes, what a third client that
// has subscribed to everything is given are whole frames, and the relay's memory stays in its
// bounds.
#include "tests/fuzz/fuzz.h"

#include "common/wire/frame.h"
#include "hub/relay/relay.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_MAX = 2000, QUEUE_MAX = 20000, GIVEN_SIZE = 1 << 20 };

static uint8_t given[GIVEN_SIZE];

static void expect_frames(struct relay_client *client)
{
    struct iovec piece;
    size_t size = 0, place = FRAME_HELLO_SIZE;
    while (relay_peek(client, &piece, 1) == 1) {
        assert(size + piece.iov_len <= QUEUE_MAX + FRAME_HELLO_SIZE);
        memcpy(given + size, piece.iov_base, piece.iov_len);
        size += piece.iov_len;
        relay_pop(client, piece.iov_len);
    }
    assert(size >= FRAME_HELLO_SIZE && frame_is_hello(FRAME_HUB, given));
    while (place < size) {
        struct frame frame;
        enum frame_result result =
            frame_read(FRAME_HUB, given + place, size - place, MESSAGE_MAX, &frame);
        assert(result == FRAME_WHOLE);
        place += frame.size;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_input input = {data, size};
    struct relay_settings settings = relay_settings_default();
    settings.message_max = MESSAGE_MAX;
    settings.queue_max = QUEUE_MAX;
    struct relay *relay = relay_create(&settings);
    const char *why;
    int64_t now_ns = 1;
    struct relay_client *clients[2], *ear = relay_join(relay, "ear", NULL, now_ns);
    uint8_t bytes[32];
    frame_hello(FRAME_CLIENT, bytes);
    size_t length = FRAME_HELLO_SIZE;
    length += frame_head(bytes + length, FRAME_SUBSCRIBE, ".*", 2, 0);
    bool good = relay_take(relay, ear, bytes, length, now_ns, &why);
    assert(good);
    for (unsigned i = 0; i < 2; i++)
        clients[i] = relay_join(relay, "client", NULL, now_ns);
    while (input.size > 0) {
        uint8_t whose = fuzz_byte(&input);
        size_t taken, wanted = fuzz_u16(&input);
        const uint8_t *piece = fuzz_bytes(&input, wanted, &taken);
        struct relay_client **client = &clients[whose & 1];
        now_ns += (int64_t)(whose >> 1) * 1000000000;
        if (taken > 0 && !relay_take(relay, *client, piece, taken, now_ns, &why)) {
            relay_leave(relay, *client);
            *client = relay_join(relay, "client", NULL, now_ns);
        }
        struct relay_client *late = relay_overdue(relay, now_ns);
        assert(late != ear);
    }
    expect_frames(ear);
    relay_free(relay);
    return 0;
}
