// A message in clear: the first byte is the kind, the rest the encoded message, to which the right
// tag is added, as anyone can. What passes the checks encodes to the very same bytes. The rest is
// also given as it is, with the tag that it happens to have.
#include "tests/fuzz/fuzz.h"

#include "common/wire/check.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static void give(enum wire_kind kind, const uint8_t *bytes, size_t size)
{
    static uint8_t again[WIRE_MTU_MAX];
    union codec_message message;
    if (check_packet(kind, bytes, size, &message) != CHECK_GOOD)
        return;
    assert(codec_encoded_size(kind, &message) == size - TAG_SIZE);
    assert(codec_encode(kind, &message, again, size - TAG_SIZE));
    assert(memcmp(again, bytes, size - TAG_SIZE) == 0);
    codec_release(kind, &message);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0 || size > WIRE_MTU_MAX)
        return 0;
    enum wire_kind kind = data[0] % WIRE_KIND_COUNT;
    give(kind, data + 1, size - 1);
    uint8_t *packet = malloc(size - 1 + TAG_SIZE);
    assert(packet != NULL);
    memcpy(packet, data + 1, size - 1);
    tag_compute(packet + size - 1, check_kind(kind)->channel, packet, size - 1);
    give(kind, packet, size - 1 + TAG_SIZE);
    free(packet);
    return 0;
}
