#include "messages.h"

#include "common/wire/neighbours.h"
#include "common/wire/seal.h"

#include <arpa/inet.h>
#include <sodium.h>

enum { OUR_NONCE = 7, PACKET_SIZE = 4096 };

static struct in_addr address(const char *text)
{
    struct in_addr in;
    assert_int_equal(inet_pton(AF_INET, text, &in), 1);
    return in;
}

static void take(struct neighbours *us, const char *from, unsigned index, const void *packet,
                 size_t size)
{
    neighbours_take(us, address(from), index, packet, size, OUR_NONCE, NULL);
}

// Two who hear each other both know it after three calls.
static void calls_tell_who_hears_whom(void **state)
{
    (void)state;
    struct neighbours us = {0}, them = {0};
    uint8_t packet[NEIGHBOURS_CALL_SIZE];
    size_t size = neighbours_call(&them, 9, packet);
    take(&us, "10.0.0.2", 0, packet, size);
    assert_int_equal(us.count, 1);
    assert_int_equal(us.list[0].nonce, 9);
    assert_false(us.list[0].hears_us);
    size = neighbours_call(&us, OUR_NONCE, packet);
    neighbours_take(&them, address("10.0.0.1"), 2, packet, size, 9, NULL);
    assert_true(them.list[0].hears_us);
    assert_true(them.list[0].heard[2] && !them.list[0].heard[0]);
    size = neighbours_call(&them, 9, packet);
    take(&us, "10.0.0.2", 1, packet, size);
    assert_true(us.list[0].hears_us);
    assert_int_equal(us.count, 1);
    assert_int_equal(us.list[0].calls, 2);
}

// LCM's header, the channel, then the message.
static size_t wrap(uint8_t *packet, const char *channel, const uint8_t *data, size_t size)
{
    memcpy(packet, "LC02\0\0\0\1", 8);
    memcpy(packet + 8, channel, strlen(channel) + 1);
    memcpy(packet + 9 + strlen(channel), data, size);
    return 9 + strlen(channel) + size;
}

// Programs that run are known by what they say anyway.
static void programs_and_keys_are_known_by_their_messages(void **state)
{
    (void)state;
    static uint8_t data[PACKET_SIZE], packet[PACKET_SIZE];
    static const uint8_t key_bytes[KEY_SIZE] = {1}, other_bytes[KEY_SIZE] = {2};
    struct neighbours us = {0};
    const char *channel = check_kind(WIRE_WORKER_STATUS)->channel;
    size_t size = packet_valid(WIRE_WORKER_STATUS, data);
    take(&us, "10.0.0.2", 2, packet, wrap(packet, channel, data, size));
    assert_true(us.list[0].worker && us.list[0].clear && !us.list[0].coordinator);
    struct key *key = key_create(key_bytes), *other = key_create(other_bytes);
    const struct seal_origin origin = {.sender = 1, .salt = 2, .number = 3};
    size = packet_valid(WIRE_RUN_STATUS, data + SEAL_HEAD_SIZE) - TAG_SIZE;
    channel = check_kind(WIRE_RUN_STATUS)->channel;
    seal_close(data, size, channel, key, WIRE_PROTOCOL, &origin);
    size = wrap(packet, channel, data, size + SEAL_SIZE);
    neighbours_take(&us, address("10.0.0.3"), 2, packet, size, OUR_NONCE, other);
    assert_true(us.list[1].coordinator && us.list[1].sealed && !us.list[1].opened);
    neighbours_take(&us, address("10.0.0.3"), 2, packet, size, OUR_NONCE, key);
    assert_true(us.list[1].opened);
    key_free(key);
    key_free(other);
}

// Anything may come to these ports, cut anywhere, from more machines than there is room for.
static void any_packet_is_survived(void **state)
{
    (void)state;
    static struct neighbours us;
    uint8_t packet[NEIGHBOURS_CALL_SIZE];
    size_t size = neighbours_call(&us, 9, packet);
    for (size_t cut = 0; cut < size; cut++) {
        uint8_t *exact = test_malloc(cut + 1);
        memcpy(exact, packet, cut);
        take(&us, "10.0.0.2", 0, exact, cut);
        test_free(exact);
    }
    assert_int_equal(us.count, 1); // from the one of which the channel is whole
    assert_int_equal(us.list[0].nonce, 0);
    take(&us, "10.0.0.4", 0, "what LCM never sends", 21);
    assert_int_equal(us.count, 1);
    for (unsigned i = 0; i < 2 * NEIGHBOURS_MAX; i++)
        neighbours_take(&us, (struct in_addr){htonl(i + 1)}, 0, packet, size, OUR_NONCE, NULL);
    assert_int_equal(us.count, NEIGHBOURS_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(calls_tell_who_hears_whom),
        cmocka_unit_test(programs_and_keys_are_known_by_their_messages),
        cmocka_unit_test(any_packet_is_survived),
    };
    return sodium_init() < 0 ? 1 : cmocka_run_group_tests(tests, NULL, NULL);
}
