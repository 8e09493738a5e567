// Sealed messages at a wire that has their key: senders with any numbers in any order, questions
// and answers to its challenge, content of any shape, envelopes that do not open. Whatever comes,
// what is handed on has passed the checks, and no number of a sender is handed on twice.
//
// A record is: what to do, kind, sender, number (2 bytes), size (1 byte), then as many bytes.
#include "tests/fuzz/fuzz.h"

#include "common/base/log.h"
#include "common/wire/door.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum {
    SENDERS = 8,
    NUMBERS = 1 << 16,
    RECORDS_MAX = 300,
    OWN = 100, // sender number of the wire under test
};

// What a record is about: bytes as they are, bytes sealed, a question or answer, or a batch, whose
// header.run tells that its header.sequence is its number.
enum what { RAW, SEALED, HAIL, BATCH, WHAT_COUNT };

static uint8_t handed_on[SENDERS][NUMBERS / 8]; // a bit a number, of batches
static uint8_t packet[WIRE_MTU_MAX];

static void note(void *user, enum wire_kind kind, const void *message)
{
    (void)user;
    const sobox_header_t *header = message;
    assert(check_fields(kind, message));
    if (kind != WIRE_SAMPLE_BATCH || header->run != BATCH)
        return;
    assert(header->sender >= 1 && header->sender <= SENDERS);
    uint32_t number = (uint32_t)header->sequence;
    uint8_t *byte = &handed_on[header->sender - 1][number / 8], bit = (uint8_t)(1 << number % 8);
    assert((*byte & bit) == 0);
    *byte |= bit;
}

static struct wire *open_wire(void)
{
    static struct key *key;
    static const uint8_t bytes[KEY_SIZE] = {1, 2, 3};
    struct wire *wire = NULL;
    if (key == NULL)
        key = key_create(bytes);
    const struct wire_settings settings = {.url = "memq://", .mtu = WIRE_MTU_DEFAULT, .key = key};
    if (wire_open(&wire, &settings, OWN, NULL) != STATUS_OK)
        abort();
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        if (wire_subscribe(wire, kind, note, NULL, NULL) != STATUS_OK)
            abort();
    return wire;
}

static void seal_and_give(struct wire *wire, enum wire_kind kind, size_t size, uint64_t sender,
                          uint64_t number)
{
    const struct seal_origin origin = {.sender = sender, .salt = 1, .number = number};
    seal_close(packet, size, check_kind(kind)->channel, wire->key, WIRE_PROTOCOL, &origin);
    door_receive(&wire->slots[kind], packet, size + SEAL_SIZE);
}

static void give_message(struct wire *wire, enum wire_kind kind, void *message, uint64_t sender,
                         uint64_t number)
{
    size_t size = codec_encoded_size(kind, message);
    if (codec_encode(kind, message, packet + SEAL_HEAD_SIZE, size))
        seal_and_give(wire, kind, size, sender, number);
}

static void give_hail(struct wire *wire, uint8_t flags, uint64_t sender, uint64_t number)
{
    sobox_hail_t hail = {.floor = flags >> 2,
                         .header = {.protocol = WIRE_PROTOCOL, .sender = (int64_t)sender},
                         .challenge = {(uint8_t)sender, flags},
                         .asked = (flags & 1) != 0 ? OWN : 0};
    if ((flags & 2) != 0)
        memcpy(hail.echo, fresh_challenge(wire->door->fresh), FRESH_CHALLENGE_SIZE);
    give_message(wire, WIRE_HAIL, &hail, sender, number);
}

static void give_batch(struct wire *wire, uint64_t sender, uint64_t number)
{
    sobox_sample_batch_t batch = {.header = {.protocol = WIRE_PROTOCOL,
                                             .sequence = (int32_t)number,
                                             .sender = (int64_t)sender,
                                             .run = BATCH},
                                  .holder = 1,
                                  .batch.count = 1,
                                  .step_samples = 1};
    give_message(wire, WIRE_SAMPLE_BATCH, &batch, sender, number);
}

static void give_record(struct wire *wire, struct fuzz_input *input)
{
    enum what what = fuzz_byte(input) % WHAT_COUNT;
    enum wire_kind kind = fuzz_byte(input) % WIRE_KIND_COUNT;
    uint64_t sender = 1 + fuzz_byte(input) % SENDERS, number = fuzz_u16(input);
    size_t size;
    uint8_t wanted = fuzz_byte(input);
    if (what == HAIL) {
        give_hail(wire, wanted, sender, number);
    } else if (what == BATCH) {
        give_batch(wire, sender, number);
    } else {
        const uint8_t *bytes = fuzz_bytes(input, wanted, &size);
        if (what == RAW) {
            door_receive(&wire->slots[kind], bytes, size);
            return;
        }
        // Sealed by somebody with the key, and therefore never a batch that is marked as such.
        memcpy(packet + SEAL_HEAD_SIZE, bytes, size);
        if (size > 31)
            packet[SEAL_HEAD_SIZE + 31] = 0;
        seal_and_give(wire, kind, size, sender, number);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_input input = {.data = data, .size = size};
    struct wire_counters counters;
    log_start("door_fuzz", LOG_QUIET);
    memset(handed_on, 0, sizeof handed_on);
    // Opening LCM takes longer than all the rest, so one wire gets a new door each time.
    static struct wire *wire;
    if (wire == NULL)
        wire = open_wire();
    door_free(wire->door);
    wire->door = door_create(wire);
    wire->counters = (struct wire_counters){0};
    for (unsigned i = 0; i < RECORDS_MAX && input.size > 0; i++)
        give_record(wire, &input);
    while (wire_dispatch(wire, 1000) > 0)
        ;
    wire_counters(wire, &counters);
    assert(counters.rejected >= counters.unopened + counters.replayed + counters.unproven);
    return 0;
}
