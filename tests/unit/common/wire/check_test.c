#include "messages.h"

#include "common/numeric/verdict.h"
#include "common/protocol/protocol.h"

#include <math.h>

static uint8_t packet[WIRE_MTU_MAX + 1];

static void put_u32(uint8_t *at, uint32_t value)
{
    for (unsigned i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> (24 - 8 * i));
}

// The table of sizes is written by hand; if a field is added to a .lcm file, every packet of the
// kind would be refused. An empty array gives the encoder's own figure.
static void layouts_agree_with_the_encoders(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        union codec_message message;
        memset(&message, 0, sizeof message);
        assert_int_equal(check_kind(kind)->fixed_size, codec_encoded_size(kind, &message));
        assert_true(check_size_max(kind) <= WIRE_MTU_MAX);
    }
}

// The checks must not be in the way of what is right.
static void valid_messages_are_good(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t size = packet_valid(kind, packet);
        assert_int_equal(packet_check(kind, packet, size), CHECK_GOOD);
    }
}

// What was encoded comes out of the check: numbers, digests, names and arrays.
static void decoded_message_is_the_one_encoded(void **state)
{
    (void)state;
    union codec_message message;
    size_t size = packet_valid(WIRE_SAMPLE_BATCH, packet);
    assert_int_equal(check_packet(WIRE_SAMPLE_BATCH, packet, size, &message), CHECK_GOOD);
    assert_int_equal(message.sample_batch.header.run, 12);
    assert_int_equal(message.sample_batch.seed, -1);
    assert_int_equal(message.sample_batch.step_samples, 200);
    assert_memory_equal(message.sample_batch.text, message_bytes, MESSAGE_PIECE_SIZE);
    codec_release(WIRE_SAMPLE_BATCH, &message);
    size = packet_valid(WIRE_WORKER_STATUS, packet);
    assert_int_equal(check_packet(WIRE_WORKER_STATUS, packet, size, &message), CHECK_GOOD);
    assert_string_equal((const char *)message.worker_status.host, "höst7");
    codec_release(WIRE_WORKER_STATUS, &message);
}

// A packet cut anywhere, or longer than it says, is refused and never read beyond its end. With the
// tag made right again too, so that size and count stand the test and not the tag alone.
static void cut_or_stretched_packets_are_rejected(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t whole = packet_valid(kind, packet);
        for (size_t size = 0; size < whole + 40; size++) {
            if (size == whole)
                continue;
            packet_valid(kind, packet);
            assert_true(packet_check(kind, packet, size) > CHECK_FOREIGN);
            if (size >= TAG_SIZE)
                packet_tag(kind, packet, size);
            assert_true(packet_check(kind, packet, size) > CHECK_FOREIGN);
        }
    }
}

// Each bit of a packet is under the tag: damage on the way cannot change a number unseen.
static void every_flipped_bit_is_rejected(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t size = packet_valid(kind, packet);
        for (size_t bit = 0; bit < 8 * size; bit++) {
            packet[bit / 8] ^= (uint8_t)(1 << bit % 8);
            assert_true(packet_check(kind, packet, size) > CHECK_FOREIGN);
            packet[bit / 8] ^= (uint8_t)(1 << bit % 8);
        }
        assert_int_equal(packet_check(kind, packet, size), CHECK_GOOD);
    }
}

// Without a key anyone can make a right tag, so the count must be refused for itself: these values
// crash LCM's decoders (negative ones, 2^29 whose bytes wrap to 0), or disagree with the size.
static void hostile_counts_are_rejected(void **state)
{
    (void)state;
    static const uint32_t counts[] = {0xffffffff, 0x80000000, 0x80000006, 0x20000000, 0x20000001,
                                      0x10000000, 0x7fffffff, 0xfffffffa, 100000000,  0,
                                      1,          5,          7,          60000,      60001};
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        if (check_kind(kind)->unit == 0)
            continue;
        size_t size = packet_valid(kind, packet);
        for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
            put_u32(packet + check_kind(kind)->fixed_size - 4, counts[i]);
            packet_tag(kind, packet, size);
            assert_int_equal(packet_check(kind, packet, size), CHECK_COUNT);
        }
    }
}

// A message recorded on one channel is not valid on another, whatever its bytes.
static void message_is_bound_to_its_channel(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t size = packet_valid(kind, packet);
        for (enum wire_kind other = 0; other < WIRE_KIND_COUNT; other++)
            if (other != kind)
                assert_true(packet_check(other, packet, size) > CHECK_FOREIGN);
    }
}

// Another type with a right tag and a fitting size is not decoded as ours.
static void other_fingerprint_is_rejected(void **state)
{
    (void)state;
    size_t size = packet_valid(WIRE_TEXT_REQUEST, packet);
    packet[0] ^= 1;
    packet_tag(WIRE_TEXT_REQUEST, packet, size);
    assert_int_equal(packet_check(WIRE_TEXT_REQUEST, packet, size), CHECK_TYPE);
}

// A worker of another version is told from damage, even when its messages have other sizes and
// fields, so that the user can be told.
static void other_protocol_is_foreign(void **state)
{
    (void)state;
    union codec_message message;
    size_t size = packet_valid(WIRE_RUN_STATUS, packet) + 13;
    packet[0] ^= 1;
    put_u32(packet + 8, 9);
    assert_int_equal(packet_check(WIRE_RUN_STATUS, packet, size), CHECK_TAG);
    packet_tag(WIRE_RUN_STATUS, packet, size);
    assert_int_equal(check_packet(WIRE_RUN_STATUS, packet, size, &message), CHECK_FOREIGN);
    assert_int_equal(message.header.protocol, 9);
}

// What was in an envelope passes the same checks; it has no tag of its own.
static void opened_message_passes_the_same_checks(void **state)
{
    (void)state;
    union codec_message message;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t size = packet_valid(kind, packet) - TAG_SIZE;
        assert_int_equal(check_encoded(kind, packet, size, &message), CHECK_GOOD);
        codec_release(kind, &message);
        for (size_t cut = 0; cut < size; cut++)
            assert_true(check_encoded(kind, packet, cut, &message) > CHECK_FOREIGN);
        assert_int_equal(check_encoded(kind, packet, size + 1, &message),
                         check_kind(kind)->unit == 0 ? CHECK_SIZE : CHECK_COUNT);
        put_u32(packet + 8, 9);
        assert_int_equal(check_encoded(kind, packet, size, &message), CHECK_FOREIGN);
    }
}

// Encodes the changed message with a right tag: only the field can be the reason. A field has to be
// refused both before it is sent and after it was received.
static void assert_field_refused(enum wire_kind kind, const union codec_message *message)
{
    assert_false(check_fields(kind, message));
    size_t size = packet_make(kind, message, packet);
    assert_int_equal(packet_check(kind, packet, size), CHECK_FIELD);
}

#define REFUSED(kind, member, field, value) \
    do {                                    \
        union codec_message m_;             \
        message_make(kind, &m_);            \
        m_.member.field = value;            \
        assert_field_refused(kind, &m_);    \
    } while (0)

// Every range that a .lcm file states is kept, at its first value outside.
static void fields_out_of_range_are_rejected(void **state)
{
    (void)state;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        REFUSED(kind, header, sender, 0);
#define BATCH(field, value) REFUSED(WIRE_SAMPLE_BATCH, sample_batch, field, value)
    BATCH(holder, 0);
    BATCH(batch.search, -1);
    BATCH(batch.step, -1);
    BATCH(batch.batch, INT32_MIN);
    BATCH(batch.attempt, -1);
    BATCH(batch.first, -1);
    BATCH(batch.first, 151);
    BATCH(batch.first, INT32_MAX);
    BATCH(batch.count, 0);
    BATCH(batch.count, 65537);
    BATCH(step_samples, 149);
    BATCH(sampling, SAMPLING_METHOD_COUNT);
    BATCH(sampling, -1);
    BATCH(detail, VERDICT_DETAIL_COUNT);
    BATCH(variables, 0);
    BATCH(variables, PROTOCOL_VARIABLE_MAX + 1);
#define OUTCOME(field, value) REFUSED(WIRE_OUTCOME_BATCH, outcome_batch, field, value)
    OUTCOME(batch.search, -1);
    OUTCOME(batch.first, -1);
    OUTCOME(batch.count, 0);
    OUTCOME(batch.count, 65537);
    OUTCOME(batch.count, 7);   // 25 bytes are more than 7 verdicts pack into
    OUTCOME(batch.count, 201); // 25 bytes hold the bits of 200
    OUTCOME(detail, -1);
    OUTCOME(non_finite, 51);
    OUTCOME(non_finite, -1);
    OUTCOME(queue, -1);
    OUTCOME(service_ns, -1);
    OUTCOME(packed_size, 0);
#define TEXT(field, value) REFUSED(WIRE_TEXT, text, field, value)
    TEXT(total_size, 0);
    TEXT(total_size, 1048577);
    TEXT(total_size, INT32_MIN);
    TEXT(offset, -1);
    TEXT(offset, 961);
    TEXT(piece_size, 0);
    REFUSED(WIRE_TEXT_REQUEST, text_request, offset, -1);
#define WORKER(field, value) REFUSED(WIRE_WORKER_STATUS, worker_status, field, value)
    WORKER(process, -1);
    WORKER(threads, 0);
    WORKER(queue, -1);
    WORKER(leaving, 2);
    WORKER(batches, -1);
    WORKER(uptime_ns, -1);
    WORKER(dropped, INT64_MIN);
    WORKER(buffer_size, -1);
#define RUN(field, value) REFUSED(WIRE_RUN_STATUS, run_status, field, value)
    RUN(state, 5);
    RUN(searches, 0);
    RUN(searches_done, 4);
    RUN(searches_done, -1);
    RUN(workers, -1);
    RUN(samples, -1);
    RUN(service_ns, -1);
#define SEARCH(field, value) REFUSED(WIRE_SEARCH_STATUS, search_status, field, value)
    SEARCH(search, -1);
    SEARCH(phase, 6);
    SEARCH(status, 4);
    SEARCH(evaluations, -1);
    SEARCH(good_share, NAN);
    SEARCH(good_share, 1.0000001);
    SEARCH(log_volume, NAN);
    SEARCH(log_volume, 1e-9);
    SEARCH(purity_lower95, -0.1);
    SEARCH(standing, 4);
    SEARCH(variables, -1);
    SEARCH(variables, 4097);
    SEARCH(first_variable, -1);
    SEARCH(first_variable, 5); // three variables from there are one too many
#define STEP(field, value) REFUSED(WIRE_STEP_STATUS, step_status, field, value)
    STEP(search, -1);
    STEP(phase, 6);
    STEP(sampling, SAMPLING_METHOD_COUNT);
    STEP(detail, VERDICT_DETAIL_COUNT);
    STEP(samples, 0);
    STEP(samples, 15); // sixteen are told of
    STEP(good, 201);
    STEP(count, -1);
    STEP(count, 0); // then no verdicts are expected
    STEP(count, 8); // eight verdicts have not so many bytes
    STEP(variables, 6);
    STEP(variables, 4097);
    STEP(first_variable, 6);
    STEP(window, 0);
    STEP(window, 1);
    STEP(window, 1 << 30);
#define CASES(field, value) REFUSED(WIRE_CASES, cases, field, value)
    CASES(first, -2);
    CASES(first, -1); // two cases are not one row of paths
    CASES(columns, 0);
    CASES(columns, 3); // four texts are no whole number of cases
    CASES(columns, 66);
#define DESIGNS(field, value) REFUSED(WIRE_DESIGN_BATCH, design_batch, field, value)
    DESIGNS(holder, 0);
    DESIGNS(batch.search, -1);
    DESIGNS(batch.first, -1);
    DESIGNS(batch.count, 0);
    DESIGNS(batch.count, -3);
    DESIGNS(batch.count, 4); // 6 values are not those of 4 designs
    DESIGNS(batch.count, 7); // nor of 7
#define VALUES(field, value) REFUSED(WIRE_VALUE_BATCH, value_batch, field, value)
    VALUES(batch.attempt, -1);
    VALUES(batch.count, 0);
    VALUES(batch.count, 65537);
    VALUES(batch.count, 4);
    VALUES(queue, -1);
    VALUES(service_ns, -1);
    REFUSED(WIRE_HAIL, hail, age_ns, -1);
    REFUSED(WIRE_HAIL, hail, floor, -1);
}

// A design is a place to evaluate; what came of it is whatever the simulation made of it.
static void designs_are_finite_and_outcomes_anything(void **state)
{
    (void)state;
    static const double odd[] = {NAN, INFINITY, -INFINITY};
    union codec_message message;
    double values[MESSAGE_BOUND_COUNT] = {0};
    for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++) {
        values[MESSAGE_BOUND_COUNT - 1] = odd[i];
        message_make(WIRE_DESIGN_BATCH, &message);
        message.design_batch.values = values;
        assert_field_refused(WIRE_DESIGN_BATCH, &message);
        message_make(WIRE_VALUE_BATCH, &message);
        message.value_batch.values = values;
        const size_t size = packet_make(WIRE_VALUE_BATCH, &message, packet);
        assert_int_equal(packet_check(WIRE_VALUE_BATCH, packet, size), CHECK_GOOD);
    }
}

// Boxes that would poison a search: not finite, upside down, or with half a bound.
static void broken_bounds_are_rejected(void **state)
{
    (void)state;
    static const double bad[] = {NAN, INFINITY, -INFINITY, 1.0001};
    union codec_message message;
    double bounds[MESSAGE_BOUND_COUNT];
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        message_make(WIRE_SEARCH_STATUS, &message);
        memcpy(bounds, message_bounds, sizeof bounds);
        bounds[0] = bad[i]; // its upper bound is 1
        message.search_status.bounds = bounds;
        assert_field_refused(WIRE_SEARCH_STATUS, &message);
    }
    message_make(WIRE_SEARCH_STATUS, &message);
    message.search_status.bound_count = 5;
    assert_field_refused(WIRE_SEARCH_STATUS, &message);
}

// Names end up on terminals and in web pages: they must end, be UTF-8 and hold no escape.
static void broken_names_are_rejected(void **state)
{
    (void)state;
    union codec_message message;
    static const char *const names[] = {"\xff", "a\xc3", "red\x1b[31m", "two\nlines", "\xc2\x9b"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        message_make(WIRE_WORKER_STATUS, &message);
        memcpy(message.worker_status.host, names[i], strlen(names[i]) + 1);
        assert_field_refused(WIRE_WORKER_STATUS, &message);
    }
    // An escape, no UTF-8, a text without an end.
    static uint8_t cases[][4] = {"a\0\x1b", "a\0\xff", {'a', '\0', 'b', 'c'}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        message_make(WIRE_CASES, &message);
        message.cases.text = cases[i];
        message.cases.text_size = sizeof cases[i];
        assert_field_refused(WIRE_CASES, &message);
    }
    message_make(WIRE_RUN_STATUS, &message);
    memset(message.run_status.name, 'x', sizeof message.run_status.name);
    assert_field_refused(WIRE_RUN_STATUS, &message);
}

// Random damage with a right tag, as a stranger without scruples sends it: it is refused, or it is
// a message like any other, which encodes to the very same bytes. Run with sanitizers this is the
// test that no byte is read or trusted too far.
static void damaged_packets_are_rejected_or_whole(void **state)
{
    (void)state;
    static uint8_t again[WIRE_MTU_MAX];
    uint32_t random = 20161;
    for (unsigned round = 0; round < 70000; round++) {
        enum wire_kind kind = round % WIRE_KIND_COUNT;
        union codec_message message;
        size_t size = packet_valid(kind, packet);
        for (unsigned i = 0; i <= round % 5; i++) {
            random = random * 1664525 + 1013904223;
            packet[8 + (random >> 16) % (size - TAG_SIZE - 8)] = (uint8_t)(random >> 8);
        }
        packet_tag(kind, packet, size);
        if (check_packet(kind, packet, size, &message) != CHECK_GOOD)
            continue;
        assert_int_equal(packet_make(kind, &message, again), size);
        assert_memory_equal(again, packet, size);
        codec_release(kind, &message);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layouts_agree_with_the_encoders),
        cmocka_unit_test(valid_messages_are_good),
        cmocka_unit_test(decoded_message_is_the_one_encoded),
        cmocka_unit_test(cut_or_stretched_packets_are_rejected),
        cmocka_unit_test(every_flipped_bit_is_rejected),
        cmocka_unit_test(hostile_counts_are_rejected),
        cmocka_unit_test(message_is_bound_to_its_channel),
        cmocka_unit_test(other_fingerprint_is_rejected),
        cmocka_unit_test(other_protocol_is_foreign),
        cmocka_unit_test(opened_message_passes_the_same_checks),
        cmocka_unit_test(fields_out_of_range_are_rejected),
        cmocka_unit_test(designs_are_finite_and_outcomes_anything),
        cmocka_unit_test(broken_bounds_are_rejected),
        cmocka_unit_test(broken_names_are_rejected),
        cmocka_unit_test(damaged_packets_are_rejected_or_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
