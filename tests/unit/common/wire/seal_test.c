#include "messages.h"

#include "common/wire/seal.h"

#include <sodium.h>

static const uint8_t key_bytes[KEY_SIZE] = {7, 1, 2, 3};
static const uint8_t other_bytes[KEY_SIZE] = {7, 1, 2, 2};
static struct key *key, *other_key;
static uint8_t packet[WIRE_MTU_MAX], opened[WIRE_MTU_MAX];
static const struct seal_origin origin = {.sender = 77, .salt = UINT64_MAX - 5, .number = 1u << 31};

static int with_keys(void **state)
{
    (void)state;
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

// Seals a valid message of the kind; returns the envelope's size.
static size_t seal_valid(enum wire_kind kind)
{
    size_t size = packet_valid(kind, packet + SEAL_HEAD_SIZE) - TAG_SIZE;
    seal_close(packet, size, check_kind(kind)->channel, key, WIRE_PROTOCOL, &origin);
    return size + SEAL_SIZE;
}

static bool opens(enum wire_kind kind, size_t size)
{
    struct seal_origin ignored;
    return seal_open(opened, packet, size, check_kind(kind)->channel, key, &ignored);
}

// What was sealed comes out, with where it comes from.
static void sealed_message_opens(void **state)
{
    (void)state;
    static uint8_t plain[WIRE_MTU_MAX];
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        struct seal_origin found;
        union codec_message message;
        size_t size = seal_valid(kind), plain_size = packet_valid(kind, plain) - TAG_SIZE;
        assert_int_equal(size, plain_size + SEAL_SIZE);
        assert_true(seal_is(packet, size));
        assert_true(seal_open(opened, packet, size, check_kind(kind)->channel, key, &found));
        assert_memory_equal(opened, plain, plain_size);
        assert_int_equal(found.sender, origin.sender);
        assert_int_equal(found.salt, origin.salt);
        assert_int_equal(found.number, origin.number);
        assert_int_equal(check_encoded(kind, opened, size - SEAL_SIZE, &message), CHECK_GOOD);
        codec_release(kind, &message);
    }
}

// The cipher is libsodium's XChaCha20-Poly1305 over what the drawing in seal.h shows: another
// implementation of it opens the envelope.
static void envelope_is_as_drawn(void **state)
{
    (void)state;
    static const uint8_t nonce[24] = {0,    0,    0,    0,    0,    0,    0,    77,
                                      0,    0,    0,    0,    0x80, 0,    0,    0,
                                      0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfa};
    static const uint8_t covered[] = "SBX1\0\0\0\1SOBOX_TEXT";
    static const uint8_t text[] = "springs";
    uint8_t sealed[64], small[sizeof text + SEAL_SIZE];
    memcpy(small + SEAL_HEAD_SIZE, text, sizeof text);
    seal_close(small, sizeof text, "SOBOX_TEXT", key, 1, &origin);
    crypto_aead_xchacha20poly1305_ietf_encrypt(sealed, NULL, text, sizeof text, covered,
                                               sizeof covered, NULL, nonce, key_bytes);
    assert_memory_equal(small, covered, 8);
    assert_memory_equal(small + 8, nonce, sizeof nonce);
    assert_memory_equal(small + SEAL_HEAD_SIZE, sealed, sizeof text + SEAL_TAG_SIZE);
}

// Each bit of the envelope is under its tag: mark, protocol, sender, number, salt, content, tag.
static void every_flipped_bit_keeps_it_shut(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t size = seal_valid(kind);
        for (size_t bit = 0; bit < 8 * size; bit++) {
            packet[bit / 8] ^= (uint8_t)(1 << bit % 8);
            assert_false(opens(kind, size));
            packet[bit / 8] ^= (uint8_t)(1 << bit % 8);
        }
        assert_true(opens(kind, size));
    }
}

static void cut_or_stretched_envelope_stays_shut(void **state)
{
    (void)state;
    size_t whole = seal_valid(WIRE_SAMPLE_BATCH);
    for (size_t size = 0; size < whole + 40; size++)
        assert_int_equal(opens(WIRE_SAMPLE_BATCH, size), size == whole);
}

static void another_key_does_not_open_it(void **state)
{
    (void)state;
    struct seal_origin ignored;
    size_t size = seal_valid(WIRE_RUN_STATUS);
    assert_false(seal_open(opened, packet, size, "SOBOX_RUN", other_key, &ignored));
    assert_true(seal_open(opened, packet, size, "SOBOX_RUN", key, &ignored));
}

// A message recorded on one channel is not valid on another.
static void envelope_is_bound_to_its_channel(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t size = seal_valid(kind);
        for (enum wire_kind other = 0; other < WIRE_KIND_COUNT; other++)
            assert_int_equal(opens(other, size), other == kind);
    }
}

// The same message sealed twice shows no likeness: an observer cannot even see that nothing
// changed.
static void equal_messages_differ_when_sealed(void **state)
{
    (void)state;
    static uint8_t first[WIRE_MTU_MAX];
    struct seal_origin next = origin;
    size_t size = seal_valid(WIRE_WORKER_STATUS) - SEAL_SIZE, equal = 0;
    memcpy(first, packet, sizeof first);
    packet_valid(WIRE_WORKER_STATUS, packet + SEAL_HEAD_SIZE);
    next.number++;
    seal_close(packet, size, "SOBOX_WORKER", key, WIRE_PROTOCOL, &next);
    for (size_t i = SEAL_HEAD_SIZE; i < size + SEAL_SIZE; i++)
        equal += first[i] == packet[i];
    assert_in_range(equal, 0, 15); // of 193; one in 256 by chance
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sealed_message_opens),
        cmocka_unit_test(envelope_is_as_drawn),
        cmocka_unit_test(every_flipped_bit_keeps_it_shut),
        cmocka_unit_test(cut_or_stretched_envelope_stays_shut),
        cmocka_unit_test(another_key_does_not_open_it),
        cmocka_unit_test(envelope_is_bound_to_its_channel),
        cmocka_unit_test(equal_messages_differ_when_sealed),
    };
    return cmocka_run_group_tests(tests, with_keys, without_keys);
}
