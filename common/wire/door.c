#include "common/wire/door.h"

#include "common/base/clock.h"

#include <assert.h>
#include <sodium.h>
#include <string.h>

enum { SEQUENCE_PLACE = 12 }; // of header.sequence in an encoded message

// Kinds that tell how things are now. A batch or a text is answered or sent again anyway.
static bool is_state(enum wire_kind kind)
{
    return kind == WIRE_WORKER_STATUS || kind == WIRE_RUN_STATUS || kind == WIRE_SEARCH_STATUS;
}

struct door *door_create(const struct wire *wire)
{
    struct door *door = g_new0(struct door, 1);
    door->fresh = fresh_create();
    door->origin.sender = wire->sender;
    randombytes_buf(&door->origin.salt, sizeof door->origin.salt);
    fresh_prove(door->fresh, &door->origin); // to itself
    return door;
}

void door_free(struct door *door)
{
    if (door == NULL)
        return;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        if (door->states[kind] != NULL)
            g_byte_array_unref(door->states[kind]);
    fresh_free(door->fresh);
    g_free(door);
}

// ---- Out ----

static void remember(struct door *door, enum wire_kind kind, const uint8_t *message, size_t size)
{
    if (door->states[kind] == NULL)
        door->states[kind] = g_byte_array_new();
    g_byte_array_set_size(door->states[kind], 0);
    g_byte_array_append(door->states[kind], message, (guint)size);
}

void door_seal(struct wire *wire, enum wire_kind kind, size_t size)
{
    struct door *door = wire->door;
    if (is_state(kind))
        remember(door, kind, wire->packet + SEAL_HEAD_SIZE, size);
    door->origin.number++;
    seal_close(wire->packet, size, check_kind(kind)->channel, wire->key, WIRE_PROTOCOL,
               &door->origin);
}

// Says again how things were when they were last told, as a new message.
static void restate(struct wire *wire)
{
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        const GByteArray *state = wire->door->states[kind];
        if (state == NULL)
            continue;
        uint32_t sequence = wire->slots[kind].sequence++;
        uint8_t *message = wire->packet + SEAL_HEAD_SIZE;
        size_t size = state->len;
        memcpy(message, state->data, size);
        for (int i = 0; i < 4; i++)
            message[SEQUENCE_PLACE + i] = (uint8_t)(sequence >> (24 - 8 * i));
        door_seal(wire, kind, size);
        (void)!wire_send(wire, kind, size + SEAL_SIZE);
    }
}

static void hail(struct wire *wire, uint64_t asked, const uint8_t *echo)
{
    sobox_hail_t message = {.asked = (int64_t)asked};
    memcpy(message.challenge, fresh_challenge(wire->door->fresh), FRESH_CHALLENGE_SIZE);
    if (echo != NULL)
        memcpy(message.echo, echo, FRESH_CHALLENGE_SIZE);
    (void)!wire_publish(wire, WIRE_HAIL, &message);
}

// ---- In ----

// Whether the challenge has not been answered just now; marks it as answered.
static bool to_be_answered(struct door *door, const uint8_t *challenge, int64_t now_ns)
{
    for (size_t i = 0; i < DOOR_ANSWERED_MAX; i++) {
        struct door_answer *answer = &door->answered[i];
        if (memcmp(answer->challenge, challenge, FRESH_CHALLENGE_SIZE) != 0)
            continue;
        bool due = now_ns - answer->answered_ns >= FRESH_ASK_NS / 2;
        if (due)
            answer->answered_ns = now_ns;
        return due;
    }
    struct door_answer *oldest = &door->answered[door->answered_next++ % DOOR_ANSWERED_MAX];
    memcpy(oldest->challenge, challenge, FRESH_CHALLENGE_SIZE);
    oldest->answered_ns = now_ns;
    return true;
}

// A question needs no proof of its own: an old one is answered in vain, nothing else.
static void take_hail(struct wire *wire, const sobox_hail_t *message,
                      const struct seal_origin *origin, int64_t now_ns)
{
    struct door *door = wire->door;
    if (memcmp(message->echo, fresh_challenge(door->fresh), FRESH_CHALLENGE_SIZE) == 0)
        fresh_prove(door->fresh, origin);
    if ((uint64_t)message->asked == wire->sender &&
        to_be_answered(door, message->challenge, now_ns)) {
        hail(wire, 0, message->challenge);
        restate(wire);
    }
}

static void reject_old(struct wire *wire)
{
    wire->counters.rejected++;
    wire->counters.replayed++;
}

// A message of a proven sender, or one whose age does not matter.
static void take(struct wire_slot *slot, const uint8_t *bytes, size_t size,
                 const struct seal_origin *origin)
{
    union codec_message message;
    enum check_result result = check_encoded(slot->kind, bytes, size, &message);
    if (result == CHECK_GOOD && (uint64_t)message.header.sender != origin->sender) {
        codec_release(slot->kind, &message);
        result = CHECK_FIELD;
    }
    if (result == CHECK_GOOD && slot->kind == WIRE_HAIL)
        take_hail(slot->wire, &message.hail, origin, clock_monotonic_ns());
    wire_take(slot, result, &message);
}

static void hold(struct wire_slot *slot, const uint8_t *bytes, size_t size,
                 const struct seal_origin *origin)
{
    struct wire *wire = slot->wire;
    int64_t now_ns = clock_monotonic_ns();
    if (fresh_hold(wire->door->fresh, slot->kind, origin, bytes, size, now_ns))
        hail(wire, origin->sender, NULL);
    door_expire(wire);
}

static void judge(struct wire_slot *slot, const uint8_t *bytes, size_t size,
                  const struct seal_origin *origin)
{
    switch (fresh_hear(slot->wire->door->fresh, slot->kind, origin)) {
    case FRESH_NEW:
        take(slot, bytes, size, origin);
        break;
    case FRESH_OLD:
        reject_old(slot->wire);
        break;
    case FRESH_UNPROVEN:
        if (slot->kind == WIRE_HAIL || slot->overheard)
            take(slot, bytes, size, origin);
        else
            hold(slot, bytes, size, origin);
        break;
    }
}

static void judge_released(struct wire *wire)
{
    struct fresh_message *message;
    while ((message = fresh_release(wire->door->fresh)) != NULL) {
        judge(&wire->slots[message->kind], message->bytes, message->size, &message->origin);
        g_free(message);
    }
}

void door_receive(struct wire_slot *slot, const uint8_t *packet, size_t size)
{
    struct wire *wire = slot->wire;
    struct seal_origin origin;
    if (size > WIRE_MTU_MAX || !seal_is(packet, size)) {
        wire_stranger(wire, slot->kind, STRANGER_NO_KEY);
    } else if (!seal_open(wire->opened, packet, size, check_kind(slot->kind)->channel, wire->key,
                          &origin) ||
               origin.sender == 0) {
        wire_stranger(wire, slot->kind, STRANGER_OTHER_KEY);
    } else {
        judge(slot, wire->opened, size - SEAL_SIZE, &origin);
        judge_released(wire);
    }
}

void door_expire(struct wire *wire)
{
    struct fresh *fresh = wire->door->fresh;
    fresh_expire(fresh, clock_monotonic_ns());
    uint64_t refused = fresh_refused(fresh), before = wire->counters.unproven;
    wire->counters.unproven = refused;
    wire->counters.rejected += refused - before;
    stranger_heard(&wire->strangers, STRANGER_SILENT, refused - before, clock_monotonic_ns());
}
