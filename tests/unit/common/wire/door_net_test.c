// Wires with a key over real UDP multicast, and strangers who record, replay and forge. Runs under
// tests/netns.
#include "messages.h"

#include "common/base/log.h"
#include "common/wire/door.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#define GROUP "239.255.76.67"
#define URL "udpm://239.255.76.67:7667"

enum { PORT = 7667, PATIENCE_MS = 120000, PACKET_MAX = 2000, PACKETS_MAX = 64 };

static const uint8_t key_bytes[KEY_SIZE] = {1, 2, 3};
static const uint8_t other_bytes[KEY_SIZE] = {1, 2, 4};
static struct key *key, *other_key;

static int with_keys(void **state)
{
    (void)state;
    log_start("door_net_test", LOG_QUIET);
    key = key_create(key_bytes);
    other_key = key_create(other_bytes);
    return key == NULL || other_key == NULL;
}

static int without_keys(void **state)
{
    (void)state;
    key_free(key);
    key_free(other_key);
    return 0;
}

// ---- Wires ----

struct seen {
    unsigned count[WIRE_KIND_COUNT];
    int64_t run; // of the last message
};

static void note(void *user, enum wire_kind kind, const void *message)
{
    struct seen *seen = user;
    seen->count[kind]++;
    seen->run = ((const sobox_header_t *)message)->run;
}

static struct wire *wire_with(const struct key *its_key, uint64_t sender)
{
    struct wire_settings settings = {.url = URL, .mtu = WIRE_MTU_DEFAULT, .key = its_key};
    struct error error = {0};
    struct wire *wire = NULL;
    if (wire_open(&wire, &settings, sender, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    return wire;
}

static void listen_to(struct wire *wire, enum wire_kind kind, struct seen *seen)
{
    struct error error = {0};
    if (wire_subscribe(wire, kind, note, seen, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

static void publish(struct wire *wire, enum wire_kind kind, int64_t run)
{
    union codec_message message;
    message_make(kind, &message);
    message.header.run = run;
    assert_int_equal(wire_publish(wire, kind, &message), STATUS_OK);
}

static struct wire_counters counters_of(struct wire *wire)
{
    struct wire_counters counters;
    wire_counters(wire, &counters);
    return counters;
}

// Dispatches both (the second may be NULL) until the number is reached.
static void await(struct wire *one, struct wire *other, const unsigned *count, unsigned wanted)
{
    struct wire *wires[] = {one, other};
    while (*count < wanted) {
        struct pollfd ready[2 * WIRE_PORT_COUNT];
        nfds_t total = 0;
        for (size_t i = 0; i < 2 && wires[i] != NULL; i++) {
            int descriptors[WIRE_PORT_COUNT];
            size_t open = wire_descriptors(wires[i], descriptors);
            for (size_t j = 0; j < open; j++)
                ready[total++] = (struct pollfd){.fd = descriptors[j], .events = POLLIN};
        }
        if (poll(ready, total, PATIENCE_MS) <= 0)
            fail_msg("%u of %u messages came", *count, wanted);
        for (size_t i = 0; i < 2 && wires[i] != NULL; i++)
            wire_dispatch(wires[i], 100);
    }
}

// ---- Strangers ----

struct recording {
    int socket;
    size_t count;
    size_t size[PACKETS_MAX];
    uint8_t packets[PACKETS_MAX][PACKET_MAX];
};

static struct recording tape;

// Listens to one port of the group, as anyone on the network can.
static void record_start(unsigned index)
{
    int on = 1;
    struct sockaddr_in port = {.sin_family = AF_INET, .sin_port = htons((uint16_t)(PORT + index))};
    struct ip_mreq group = {0};
    inet_pton(AF_INET, GROUP, &group.imr_multiaddr);
    tape.count = 0;
    tape.socket = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    assert_true(tape.socket >= 0);
    setsockopt(tape.socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    assert_int_equal(bind(tape.socket, (const struct sockaddr *)&port, sizeof port), 0);
    assert_int_equal(setsockopt(tape.socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group),
                     0);
}

// Takes down what has come. Loopback delivers within the sender's call.
static void record_stop(void)
{
    ssize_t size;
    while (tape.count < PACKETS_MAX &&
           (size = recv(tape.socket, tape.packets[tape.count], PACKET_MAX, 0)) >= 0)
        tape.size[tape.count++] = (size_t)size;
    close(tape.socket);
}

// The channel of a recorded packet of LCM's.
static const char *channel_of(size_t i)
{
    return (const char *)tape.packets[i] + 8;
}

// The message in a recorded packet.
static uint8_t *content_of(size_t i)
{
    return tape.packets[i] + 8 + strlen(channel_of(i)) + 1;
}

static void send_to(unsigned index, const uint8_t *bytes, size_t size)
{
    struct sockaddr_in group = {.sin_family = AF_INET, .sin_port = htons((uint16_t)(PORT + index))};
    int stranger = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_true(stranger >= 0);
    inet_pton(AF_INET, GROUP, &group.sin_addr);
    assert_int_equal(
        sendto(stranger, bytes, size, 0, (const struct sockaddr *)&group, sizeof group), size);
    close(stranger);
}

// Plays everything recorded again, and says how many packets were of the channel.
static unsigned replay(unsigned index, const char *channel)
{
    unsigned count = 0;
    for (size_t i = 0; i < tape.count; i++) {
        send_to(index, tape.packets[i], tape.size[i]);
        count += strcmp(channel_of(i), channel) == 0;
    }
    return count;
}

// ---- Those who have the key ----

// The first message of a sender that nobody knows costs a question and an answer, and comes after
// them, once.
static void first_status_arrives_after_a_proof(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *sender = wire_with(key, 1), *receiver = wire_with(key, 2);
    listen_to(receiver, WIRE_RUN_STATUS, &seen);
    publish(sender, WIRE_RUN_STATUS, 12);
    await(receiver, sender, &seen.count[WIRE_RUN_STATUS], 1);
    publish(sender, WIRE_RUN_STATUS, 13);
    await(receiver, sender, &seen.count[WIRE_RUN_STATUS], 2);
    assert_int_equal(seen.run, 13);
    assert_int_equal(seen.count[WIRE_RUN_STATUS], 2);
    assert_int_equal(counters_of(receiver).rejected, 0);
    assert_int_equal(counters_of(receiver).lost, 0);
    wire_close(sender);
    wire_close(receiver);
}

// A batch follows its sender's proof on another port and may be handled before it.
static void messages_right_behind_the_proof_are_not_lost(void **state)
{
    (void)state;
    enum { ROUNDS = 30, BATCHES = 20 };
    for (unsigned round = 0; round < ROUNDS; round++) {
        struct seen seen = {0}, at_sender = {0};
        struct wire *sender = wire_with(key, 1 + round), *receiver = wire_with(key, 100);
        listen_to(receiver, WIRE_RUN_STATUS, &seen);
        listen_to(receiver, WIRE_SAMPLE_BATCH, &seen);
        listen_to(sender, WIRE_HAIL, &at_sender);
        publish(sender, WIRE_RUN_STATUS, 1);
        await(receiver, sender, &at_sender.count[WIRE_HAIL], 1); // asked, and has answered
        for (unsigned i = 0; i < BATCHES; i++)
            publish(sender, WIRE_SAMPLE_BATCH, 1);
        await(receiver, sender, &seen.count[WIRE_SAMPLE_BATCH], BATCHES);
        assert_int_equal(counters_of(receiver).rejected, 0);
        wire_close(sender);
        wire_close(receiver);
    }
}

// Nothing is lost to the question: what came before the answer is handed on with it.
static void first_messages_of_any_kind_arrive(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *sender = wire_with(key, 1), *receiver = wire_with(key, 2);
    listen_to(receiver, WIRE_TEXT, &seen);
    for (int64_t run = 1; run <= 5; run++)
        publish(sender, WIRE_TEXT, run);
    await(receiver, sender, &seen.count[WIRE_TEXT], 5);
    assert_int_equal(seen.run, 5);
    assert_int_equal(counters_of(receiver).rejected, 0);
    wire_close(sender);
    wire_close(receiver);
}

// What a sender that is there said before this receiver began is a recording like any other.
static void older_messages_of_a_living_sender_are_refused(void **state)
{
    (void)state;
    struct seen seen = {0}, hails = {0};
    struct wire *sender = wire_with(key, 1);
    listen_to(sender, WIRE_HAIL, &hails);
    record_start(0);
    publish(sender, WIRE_TEXT, 1);
    record_stop();
    sender->door->moments[0].sent_ns -= 2 * DOOR_SLACK_NS; // as if it had been a while ago
    struct wire *receiver = wire_with(key, 2);
    listen_to(receiver, WIRE_TEXT, &seen);
    assert_int_equal(replay(0, "SOBOX_TEXT"), 1);
    await(receiver, sender, &hails.count[WIRE_HAIL], 1); // the receiver asks about what was played
    assert_int_equal(replay(0, "SOBOX_TEXT"), 1);
    publish(sender, WIRE_TEXT, 2);
    await(receiver, sender, &seen.count[WIRE_TEXT], 1);
    assert_int_equal(seen.run, 2);
    wire_close(sender);
    wire_close(receiver);
}

// Two senders, each with numbers of its own, and the receiver's own messages among theirs.
static void senders_do_not_disturb_each_other(void **state)
{
    (void)state;
    struct seen seen = {0};
    unsigned *count = &seen.count[WIRE_WORKER_STATUS];
    struct wire *one = wire_with(key, 1), *two = wire_with(key, 2), *receiver = wire_with(key, 3);
    listen_to(receiver, WIRE_WORKER_STATUS, &seen);
    publish(one, WIRE_WORKER_STATUS, 1);
    await(receiver, one, count, 1);
    publish(two, WIRE_WORKER_STATUS, 1);
    await(receiver, two, count, 2);
    for (unsigned i = 0; i < 100; i++) {
        publish(one, WIRE_WORKER_STATUS, 1);
        publish(two, WIRE_WORKER_STATUS, 1);
        publish(receiver, WIRE_WORKER_STATUS, 1);
    }
    await(receiver, NULL, count, 302);
    assert_int_equal(counters_of(receiver).rejected, 0);
    wire_close(one);
    wire_close(two);
    wire_close(receiver);
}

// Where hundreds hear hundreds nobody asks for proofs, but a key is still needed.
static void overheard_kinds_need_no_proof(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *sender = wire_with(key, 1), *receiver = wire_with(key, 2);
    struct wire *stranger = wire_with(other_key, 3);
    assert_int_equal(wire_overhear(receiver, WIRE_WORKER_STATUS, note, &seen, NULL), STATUS_OK);
    publish(stranger, WIRE_WORKER_STATUS, 1);
    publish(sender, WIRE_WORKER_STATUS, 2);
    await(receiver, NULL, &seen.count[WIRE_WORKER_STATUS], 1);
    assert_int_equal(seen.run, 2);
    assert_int_equal(counters_of(receiver).unopened, 1);
    assert_int_equal(counters_of(receiver).published, 0);
    wire_close(stranger);
    wire_close(sender);
    wire_close(receiver);
}

// ---- Those who have not ----

// What is told over the network does not show in its packets, and neither does the key.
static void packets_show_nothing(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *wire = wire_with(key, 1);
    listen_to(wire, WIRE_TEXT, &seen);
    record_start(0);
    publish(wire, WIRE_TEXT, 1);
    await(wire, NULL, &seen.count[WIRE_TEXT], 1);
    record_stop();
    assert_int_equal(tape.count, 1);
    assert_null(memmem(tape.packets[0], tape.size[0], "springs", 7));
    assert_null(memmem(tape.packets[0], tape.size[0], "scenario", 8));
    assert_null(memmem(tape.packets[0], tape.size[0], key_bytes, 4));
    wire_close(wire);
}

// Played again in the same run, each packet is refused and counted.
static void replayed_messages_are_refused(void **state)
{
    (void)state;
    struct seen seen = {0};
    unsigned *count = &seen.count[WIRE_WORKER_STATUS];
    struct wire *sender = wire_with(key, 1), *receiver = wire_with(key, 2);
    listen_to(receiver, WIRE_WORKER_STATUS, &seen);
    record_start(2);
    publish(sender, WIRE_WORKER_STATUS, 1);
    await(receiver, sender, count, 1);
    publish(sender, WIRE_WORKER_STATUS, 1);
    await(receiver, sender, count, 2);
    record_stop();
    unsigned replayed = replay(2, "SOBOX_WORKER");
    assert_int_equal(replayed, 2);
    publish(sender, WIRE_WORKER_STATUS, 7);
    await(receiver, sender, count, 3);
    assert_int_equal(seen.run, 7);
    // The receiver's own question is among them, and the answer to it.
    assert_int_equal(counters_of(receiver).replayed, replayed + 2);
    assert_int_equal(counters_of(receiver).rejected, replayed + 2);
    wire_close(sender);
    wire_close(receiver);
}

// Played to a process that was started later, the recording of one that has ended, proof and all,
// does not raise its ghost; nor does it when the ghost's number is one that is there again.
static void recording_of_an_earlier_run_raises_no_ghost(void **state)
{
    (void)state;
    struct seen seen = {0}, later = {0};
    unsigned *count = &seen.count[WIRE_WORKER_STATUS];
    struct wire *ghost = wire_with(key, 1), *receiver = wire_with(key, 2);
    listen_to(receiver, WIRE_WORKER_STATUS, &seen);
    record_start(2);
    publish(ghost, WIRE_WORKER_STATUS, 666);
    await(receiver, ghost, count, 1);
    record_stop();
    wire_close(ghost);
    wire_close(receiver);

    struct wire *sender = wire_with(key, 1), *newcomer = wire_with(key, 2);
    listen_to(newcomer, WIRE_WORKER_STATUS, &later);
    assert_int_equal(replay(2, "SOBOX_WORKER"), 1);
    publish(sender, WIRE_WORKER_STATUS, 5);
    await(newcomer, sender, &later.count[WIRE_WORKER_STATUS], 1);
    assert_int_equal(replay(2, "SOBOX_WORKER"), 1);
    publish(sender, WIRE_WORKER_STATUS, 6);
    await(newcomer, sender, &later.count[WIRE_WORKER_STATUS], 2);
    assert_int_equal(later.run, 6);
    assert_int_equal(later.count[WIRE_WORKER_STATUS], 2);
    wire_close(sender);
    wire_close(newcomer);
}

// A recorded message moved to another channel, or damaged, does not open.
static void altered_recordings_do_not_open(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *wire = wire_with(key, 1);
    listen_to(wire, WIRE_TEXT, &seen);
    listen_to(wire, WIRE_SAMPLE_BATCH, &seen);
    record_start(0);
    publish(wire, WIRE_TEXT, 1);
    await(wire, NULL, &seen.count[WIRE_TEXT], 1);
    record_stop();
    content_of(0)[tape.size[0] / 2] ^= 1;
    replay(0, "SOBOX_TEXT");
    content_of(0)[tape.size[0] / 2] ^= 1;
    uint8_t moved[PACKET_MAX] = "LC02\0\0\0\0SOBOX_BATCH";
    size_t size = tape.size[0] - (size_t)(content_of(0) - tape.packets[0]);
    memcpy(moved + 20, content_of(0), size);
    send_to(0, moved, 20 + size);
    publish(wire, WIRE_TEXT, 2);
    await(wire, NULL, &seen.count[WIRE_TEXT], 2);
    publish(wire, WIRE_SAMPLE_BATCH, 2);
    await(wire, NULL, &seen.count[WIRE_SAMPLE_BATCH], 1);
    assert_int_equal(seen.count[WIRE_TEXT], 2);
    assert_int_equal(counters_of(wire).unopened, 2);
    wire_close(wire);
}

// Every pair that does not have the same key: nothing is handed on, each side counts the other.
static void wires_with_different_keys_do_not_hear_each_other(void **state)
{
    (void)state;
    const struct key *pairs[][2] = {{key, other_key}, {key, NULL}, {NULL, key}};
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        struct seen here = {0}, there = {0};
        struct wire *one = wire_with(pairs[i][0], 1), *other = wire_with(pairs[i][1], 2);
        listen_to(one, WIRE_RUN_STATUS, &here);
        listen_to(other, WIRE_RUN_STATUS, &there);
        publish(one, WIRE_RUN_STATUS, 1);
        publish(other, WIRE_RUN_STATUS, 2);
        // Each hears itself, and the other's message came before or after its own.
        await(one, other, &here.count[WIRE_RUN_STATUS], 1);
        await(one, other, &there.count[WIRE_RUN_STATUS], 1);
        publish(one, WIRE_RUN_STATUS, 1);
        publish(other, WIRE_RUN_STATUS, 2);
        await(one, other, &here.count[WIRE_RUN_STATUS], 2);
        await(one, other, &there.count[WIRE_RUN_STATUS], 2);
        assert_int_equal(here.run, 1);
        assert_int_equal(there.run, 2);
        assert_in_range(counters_of(one).unopened, 1, 2);
        assert_in_range(counters_of(other).unopened, 1, 2);
        assert_int_equal(counters_of(one).unopened, counters_of(one).rejected);
        wire_close(one);
        wire_close(other);
    }
}

// After LCM was opened anew the proofs still hold, and numbers go on.
static void reopened_wire_is_still_known(void **state)
{
    (void)state;
    struct seen seen = {0};
    unsigned *count = &seen.count[WIRE_RUN_STATUS];
    struct wire *sender = wire_with(key, 1), *receiver = wire_with(key, 2);
    listen_to(receiver, WIRE_RUN_STATUS, &seen);
    publish(sender, WIRE_RUN_STATUS, 1);
    await(receiver, sender, count, 1);
    assert_int_equal(wire_reopen(sender, NULL), STATUS_OK);
    assert_int_equal(wire_reopen(receiver, NULL), STATUS_OK);
    uint64_t published = counters_of(receiver).published;
    publish(sender, WIRE_RUN_STATUS, 2);
    await(receiver, sender, count, 2);
    assert_int_equal(counters_of(receiver).published, published); // no question
    assert_int_equal(counters_of(receiver).rejected, 0);
    wire_close(sender);
    wire_close(receiver);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_status_arrives_after_a_proof),
        cmocka_unit_test(messages_right_behind_the_proof_are_not_lost),
        cmocka_unit_test(first_messages_of_any_kind_arrive),
        cmocka_unit_test(older_messages_of_a_living_sender_are_refused),
        cmocka_unit_test(senders_do_not_disturb_each_other),
        cmocka_unit_test(overheard_kinds_need_no_proof),
        cmocka_unit_test(packets_show_nothing),
        cmocka_unit_test(replayed_messages_are_refused),
        cmocka_unit_test(recording_of_an_earlier_run_raises_no_ghost),
        cmocka_unit_test(altered_recordings_do_not_open),
        cmocka_unit_test(wires_with_different_keys_do_not_hear_each_other),
        cmocka_unit_test(reopened_wire_is_still_known),
    };
    return cmocka_run_group_tests(tests, with_keys, without_keys);
}
