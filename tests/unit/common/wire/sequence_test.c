#include "messages.h"

#include "common/wire/sequence.h"

static void hear(struct sequence *sequence, uint32_t number)
{
    sequence_hear(sequence, MESSAGE_SENDER, WIRE_TEXT, number);
}

// The losses after these numbers, in this order, from one sender.
static uint64_t lost_after(const uint32_t *numbers, size_t count)
{
    struct sequence *sequence = sequence_create();
    for (size_t i = 0; i < count; i++)
        hear(sequence, numbers[i]);
    uint64_t lost = sequence_lost(sequence);
    sequence_free(sequence);
    return lost;
}
#define LOST(...) lost_after((const uint32_t[]){__VA_ARGS__}, sizeof((uint32_t[]){__VA_ARGS__}) / 4)

// Nothing is lost before the first, whatever number it has: listeners join when they like.
static void first_message_starts_the_count(void **state)
{
    (void)state;
    assert_int_equal(LOST(0), 0);
    assert_int_equal(LOST(4000000000u), 0);
    assert_int_equal(LOST(100, 99, 98), 0); // older ones that come late take nothing back
    assert_int_equal(LOST(100, 102, 99), 1);
}

static void gaps_count_once(void **state)
{
    (void)state;
    assert_int_equal(LOST(1, 2, 3), 0);
    assert_int_equal(LOST(1, 3), 1);
    assert_int_equal(LOST(1, 3, 6), 3);
    assert_int_equal(LOST(1, 1001), 999);
}

// Multicast doubles and reorders: neither is a loss, and a double takes no loss back.
static void doubled_and_late_messages_are_no_losses(void **state)
{
    (void)state;
    assert_int_equal(LOST(1, 1, 2, 2), 0);
    assert_int_equal(LOST(1, 3, 2, 4), 0);
    assert_int_equal(LOST(1, 4, 2, 2), 1);
    assert_int_equal(LOST(1, 4, 2, 3), 0);
    assert_int_equal(LOST(1, 200, 150, 150), 197);
    assert_int_equal(LOST(1, 200, 120), 198); // beyond the window: stays counted
}

static void numbers_wrap(void **state)
{
    (void)state;
    assert_int_equal(LOST(UINT32_MAX - 1, UINT32_MAX, 0, 1), 0);
    assert_int_equal(LOST(UINT32_MAX, 1), 1);
    assert_int_equal(LOST(UINT32_MAX, 1, 0), 0);
}

// A stranger that jumps about must not turn the counter into nonsense.
static void great_leap_starts_anew(void **state)
{
    (void)state;
    assert_int_equal(LOST(1, 2000000000u, 2000000001u), 0);
    assert_int_equal(LOST(3000000000u, 5, 7), 1);
}

// Each kind of each sender has numbers of its own.
static void senders_and_kinds_are_counted_apart(void **state)
{
    (void)state;
    struct sequence *sequence = sequence_create();
    sequence_hear(sequence, 1, WIRE_TEXT, 0);
    sequence_hear(sequence, 2, WIRE_TEXT, 50);
    sequence_hear(sequence, 1, WIRE_RUN_STATUS, 90);
    sequence_hear(sequence, 1, WIRE_TEXT, 1);
    sequence_hear(sequence, 2, WIRE_TEXT, 51);
    assert_int_equal(sequence_lost(sequence), 0);
    sequence_hear(sequence, 2, WIRE_TEXT, 53);
    assert_int_equal(sequence_lost(sequence), 1);
    sequence_free(sequence);
}

// Made-up senders do not fill the memory, do not push out a sender that is heard, and the losses of
// those forgotten stay.
static void remembered_senders_are_bounded(void **state)
{
    (void)state;
    struct sequence *sequence = sequence_create();
    hear(sequence, 1);
    hear(sequence, 3);
    for (uint64_t sender = 1000; sender < 1000 + 3 * SEQUENCE_SENDERS_MAX; sender++) {
        sequence_hear(sequence, sender, WIRE_TEXT, 0);
        hear(sequence, 3);
    }
    assert_int_equal(sequence_senders(sequence), SEQUENCE_SENDERS_MAX);
    hear(sequence, 5);
    assert_int_equal(sequence_lost(sequence), 2);
    sequence_free(sequence);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_message_starts_the_count),
        cmocka_unit_test(gaps_count_once),
        cmocka_unit_test(doubled_and_late_messages_are_no_losses),
        cmocka_unit_test(numbers_wrap),
        cmocka_unit_test(great_leap_starts_anew),
        cmocka_unit_test(senders_and_kinds_are_counted_apart),
        cmocka_unit_test(remembered_senders_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
