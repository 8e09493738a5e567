#include "common/wire/door.h"

#include "common/base/clock.h"

#include <assert.h>
#include <sodium.h>
#include <string.h>

struct door *door_create(const struct wire *wire)
{
    struct door *door = g_new0(struct door, 1);
    int64_t now_ns = clock_monotonic_ns();
    door->fresh = fresh_create(now_ns);
    door->origin.sender = wire->sender;
    randombytes_buf(&door->origin.salt, sizeof door->origin.salt);
    fresh_prove(door->fresh, &door->origin, 0, now_ns); // to itself
    return door;
}

void door_free(struct door *door)
{
    if (door == NULL)
        return;
    fresh_free(door->fresh);
    g_free(door);
}

// ---- Out ----

static void note_moment(struct door *door, int64_t now_ns)
{
    const struct door_moment *last = &door->moments[(door->moment_count - 1) % DOOR_MOMENTS_MAX];
    if (door->moment_count > 0 && now_ns - last->sent_ns < DOOR_MOMENT_NS)
        return;
    door->moments[door->moment_count++ % DOOR_MOMENTS_MAX] =
        (struct door_moment){.sent_ns = now_ns, .before = door->origin.number};
}

// The number of the last message that may have been sent before `since_ns`. Rather too great a one:
// what is between two moments counts as old as the first of them.
static uint64_t number_before(const struct door *door, int64_t since_ns)
{
    size_t count = door->moment_count;
    size_t first = count > DOOR_MOMENTS_MAX ? count - DOOR_MOMENTS_MAX : 0;
    for (size_t i = first; i < count; i++)
        if (door->moments[i % DOOR_MOMENTS_MAX].sent_ns >= since_ns)
            return door->moments[i % DOOR_MOMENTS_MAX].before;
    return door->origin.number;
}

void door_seal(struct wire *wire, enum wire_kind kind, size_t size)
{
    struct door *door = wire->door;
    note_moment(door, clock_monotonic_ns());
    door->origin.number++;
    seal_close(wire->packet, size, check_kind(kind)->channel, wire->key, WIRE_PROTOCOL,
               &door->origin);
}

// Says the own challenge: to ask somebody, or with the answer to a question.
static void hail(struct wire *wire, sobox_hail_t *message, int64_t now_ns)
{
    const struct fresh *fresh = wire->door->fresh;
    memcpy(message->challenge, fresh_challenge(fresh), FRESH_CHALLENGE_SIZE);
    message->age_ns = fresh_age_ns(fresh, now_ns);
    (void)!wire_publish(wire, WIRE_HAIL, message);
}

static void ask(struct wire *wire, int64_t now_ns)
{
    uint64_t sender;
    while ((sender = fresh_ask(wire->door->fresh, now_ns)) != 0)
        hail(wire, &(sobox_hail_t){.asked = (int64_t)sender}, now_ns);
}

static void answer(struct wire *wire, const sobox_hail_t *question, int64_t now_ns)
{
    // A challenge older than this machine's clock is as old as that.
    int64_t since_ns = now_ns - MIN(question->age_ns, now_ns) - DOOR_SLACK_NS;
    sobox_hail_t message = {.floor = (int64_t)number_before(wire->door, since_ns)};
    memcpy(message.echo, question->challenge, FRESH_CHALLENGE_SIZE);
    hail(wire, &message, now_ns);
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
        fresh_prove(door->fresh, origin, (uint64_t)message->floor, now_ns);
    if ((uint64_t)message->asked == wire->sender &&
        to_be_answered(door, message->challenge, now_ns))
        answer(wire, message, now_ns);
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
    fresh_hold(wire->door->fresh, slot->kind, origin, bytes, size, now_ns);
    door_tick(wire, now_ns);
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

int64_t door_wake_ns(const struct wire *wire)
{
    return fresh_wake_ns(wire->door->fresh);
}

void door_tick(struct wire *wire, int64_t now_ns)
{
    struct fresh *fresh = wire->door->fresh;
    ask(wire, now_ns);
    fresh_expire(fresh, now_ns);
    uint64_t refused = fresh_refused(fresh), before = wire->counters.unproven;
    wire->counters.unproven = refused;
    wire->counters.rejected += refused - before;
    stranger_heard(&wire->strangers, STRANGER_SILENT, refused - before, now_ns);
}
