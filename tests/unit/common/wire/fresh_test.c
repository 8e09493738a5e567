#include "messages.h"

#include "common/wire/fresh.h"

#include <glib.h>
#include <sodium.h>

#define MS INT64_C(1000000)

static struct fresh *fresh;

static int with_fresh(void **state)
{
    (void)state;
    fresh = fresh_create(0);
    return 0;
}

static int without_fresh(void **state)
{
    (void)state;
    fresh_free(fresh);
    return 0;
}

static enum fresh_result hear_kind(enum wire_kind kind, uint64_t sender, uint64_t number)
{
    return fresh_hear(fresh, kind,
                      &(struct seal_origin){.sender = sender, .salt = 5, .number = number});
}

static enum fresh_result hear(uint64_t sender, uint64_t number)
{
    return hear_kind(WIRE_OUTCOME_BATCH, sender, number);
}

// By a message of this number, which says that those up to `floor` are older than the receiver.
static void prove_from(uint64_t sender, uint64_t number, uint64_t floor)
{
    fresh_prove(fresh, &(struct seal_origin){.sender = sender, .salt = 5, .number = number}, floor,
                1000);
}

static void prove(uint64_t sender, uint64_t number)
{
    prove_from(sender, number, number);
}

// Returns whether the sender is to be asked now.
static bool hold(uint64_t sender, uint64_t number, int64_t now_ns)
{
    const uint8_t bytes[2] = {(uint8_t)sender, (uint8_t)number};
    fresh_hold(fresh, WIRE_OUTCOME_BATCH,
               &(struct seal_origin){.sender = sender, .salt = 5, .number = number}, bytes,
               sizeof bytes, now_ns);
    uint64_t asked = fresh_ask(fresh, now_ns);
    assert_true(asked == 0 || asked == sender);
    return asked == sender;
}

// The number of the next message released, 0 when there is none.
static uint64_t released(void)
{
    struct fresh_message *message = fresh_release(fresh);
    if (message == NULL)
        return 0;
    uint64_t number = message->origin.number;
    assert_int_equal(message->size, 2);
    assert_int_equal(message->bytes[0], (uint8_t)message->origin.sender);
    assert_int_equal(message->bytes[1], (uint8_t)number);
    g_free(message);
    return number;
}

// A recording of a sender that is no more is not told from the first message of one that is there,
// so neither is taken at its word.
static void unknown_sender_is_unproven(void **state)
{
    (void)state;
    assert_int_equal(hear(1, 1), FRESH_UNPROVEN);
    assert_int_equal(hear(1, 1000), FRESH_UNPROVEN);
}

// What is not above the floor is older than this receiver.
static void only_what_is_above_the_floor_is_new(void **state)
{
    (void)state;
    prove_from(1, 10, 7);
    assert_int_equal(hear(1, 6), FRESH_OLD);
    assert_int_equal(hear(1, 7), FRESH_OLD);
    assert_int_equal(hear(1, 8), FRESH_NEW);
    assert_int_equal(hear(1, 11), FRESH_NEW);
    assert_int_equal(hear(2, 11), FRESH_UNPROVEN);
    // The proof itself has been heard.
    assert_int_equal(hear_kind(WIRE_HAIL, 1, 10), FRESH_OLD);
    assert_int_equal(hear_kind(WIRE_HAIL, 1, 9), FRESH_NEW);
}

static void each_number_is_taken_once(void **state)
{
    (void)state;
    prove(1, 0);
    for (uint64_t number = 1; number < 5000; number++)
        assert_int_equal(hear(1, number), FRESH_NEW);
    for (uint64_t number = 1; number < 5000; number++)
        assert_int_equal(hear(1, number), FRESH_OLD);
}

// Multicast reorders: each message counts once in whatever order they come, as long as none is
// later than the window. Blocks of half the window are shuffled here.
static void reordered_messages_are_all_taken(void **state)
{
    (void)state;
    enum { BLOCK = FRESH_WINDOW / 2 };
    uint64_t numbers[BLOCK];
    GRand *dice = g_rand_new_with_seed(20161);
    prove(1, 100);
    for (uint64_t first = 101; first < 20000; first += BLOCK) {
        for (uint64_t i = 0; i < BLOCK; i++) {
            uint64_t other = (uint64_t)g_rand_int_range(dice, 0, (gint32)i + 1);
            numbers[i] = numbers[other];
            numbers[other] = first + i;
        }
        for (uint64_t i = 0; i < BLOCK; i++)
            assert_int_equal(hear(1, numbers[i]), FRESH_NEW);
        for (uint64_t i = 0; i < BLOCK; i++)
            assert_int_equal(hear(1, numbers[i]), FRESH_OLD);
    }
    g_rand_free(dice);
}

// The ring of bits must neither forget what it was told nor remember what it was not, however far
// the numbers leap.
static void leaps_leave_no_trace(void **state)
{
    (void)state;
    static const uint64_t leaps[] = {1, 63, 64, 65, 959, 960, 961, 1023, 1024, 1025, 100000};
    uint64_t greatest = 1;
    prove(1, 0);
    assert_int_equal(hear(1, greatest), FRESH_NEW);
    for (size_t i = 0; i < sizeof leaps / sizeof leaps[0]; i++) {
        uint64_t before = greatest;
        greatest += leaps[i];
        assert_int_equal(hear(1, greatest), FRESH_NEW);
        assert_int_equal(hear(1, greatest), FRESH_OLD);
        assert_int_equal(hear(1, before), FRESH_OLD);
        for (uint64_t late = before + 1; late < greatest; late++) {
            bool within = greatest - late < FRESH_WINDOW;
            assert_int_equal(hear(1, late), within ? FRESH_NEW : FRESH_OLD);
        }
    }
    assert_int_equal(hear(1, UINT64_MAX), FRESH_NEW);
    assert_int_equal(hear(1, UINT64_MAX), FRESH_OLD);
}

// Outcomes wait by the thousand on their port while a status on another is handled at once.
static void kinds_do_not_overtake_each_other(void **state)
{
    (void)state;
    prove(1, 0);
    assert_int_equal(hear_kind(WIRE_WORKER_STATUS, 1, 10000), FRESH_NEW);
    assert_int_equal(hear_kind(WIRE_OUTCOME_BATCH, 1, 1), FRESH_NEW);
    assert_int_equal(hear_kind(WIRE_OUTCOME_BATCH, 1, 1), FRESH_OLD);
}

static void senders_are_independent(void **state)
{
    (void)state;
    prove(1, 0);
    prove(2, 500);
    assert_int_equal(hear(1, 3), FRESH_NEW);
    assert_int_equal(hear(2, 3), FRESH_OLD);
    assert_int_equal(hear(2, 503), FRESH_NEW);
    // The same sender number with another salt is another wire: its numbers begin anew.
    struct seal_origin again = {.sender = 1, .salt = 6, .number = 3};
    assert_int_equal(fresh_hear(fresh, WIRE_OUTCOME_BATCH, &again), FRESH_UNPROVEN);
}

// A second proof must not set the numbers back: it may be the first one, recorded.
static void second_proof_changes_nothing(void **state)
{
    (void)state;
    prove(1, 10);
    assert_int_equal(hear(1, 20), FRESH_NEW);
    prove(1, 10);
    prove(1, 0);
    assert_int_equal(hear(1, 20), FRESH_OLD);
    assert_int_equal(hear(1, 5), FRESH_OLD);
}

// An unknown sender is asked at once, so that a search need not wait, and again as long as
// something of it is held: questions and answers are lost like all messages.
static void unknown_sender_is_asked_at_once_and_again(void **state)
{
    (void)state;
    assert_int_equal(fresh_wake_ns(fresh), INT64_MAX);
    assert_true(hold(1, 1, 0));
    assert_false(hold(1, 2, 1 * MS));
    assert_int_equal(fresh_wake_ns(fresh), FRESH_ASK_NS);
    assert_int_equal(fresh_ask(fresh, FRESH_ASK_NS - 1), 0);
    assert_int_equal(fresh_ask(fresh, FRESH_ASK_NS), 1);
    assert_int_equal(fresh_ask(fresh, FRESH_ASK_NS), 0);
    assert_int_equal(fresh_wake_ns(fresh), 2 * FRESH_ASK_NS);
    prove(1, 3);
    assert_int_equal(fresh_wake_ns(fresh), INT64_MAX);
    assert_int_equal(fresh_ask(fresh, 3 * FRESH_ASK_NS), 0);
}

// Nobody asks for ever: with the last message held the questions end.
static void questions_end_with_what_is_held(void **state)
{
    (void)state;
    int64_t now_ns;
    unsigned asked = 0;
    hold(1, 1, 0);
    while ((now_ns = fresh_wake_ns(fresh)) != INT64_MAX) {
        assert_true(now_ns <= FRESH_PATIENCE_NS);
        asked += fresh_ask(fresh, now_ns) == 1;
        fresh_expire(fresh, now_ns);
    }
    assert_int_equal(asked, FRESH_PATIENCE_NS / FRESH_ASK_NS);
    assert_int_equal(fresh_refused(fresh), 1);
}

// What was held is handed on as far as it is younger than the receiver.
static void held_messages_above_the_floor_are_released(void **state)
{
    (void)state;
    hold(1, 40, 0);
    hold(1, 43, 0);
    hold(1, 42, 0);
    hold(1, 46, 0);
    hold(2, 90, 0);
    assert_int_equal(released(), 0);
    prove_from(1, 45, 41);
    assert_int_equal(released(), 43);
    assert_int_equal(released(), 42);
    assert_int_equal(released(), 46);
    assert_int_equal(released(), 0);
    assert_int_equal(fresh_refused(fresh), 0); // of a sender that is there
    assert_int_equal(hear(1, 43), FRESH_NEW);
}

// A recording waits in vain, and is counted.
static void sender_that_never_proves_itself_is_refused(void **state)
{
    (void)state;
    hold(1, 1, 0);
    hold(1, 2, 500 * MS);
    fresh_expire(fresh, 1999 * MS);
    assert_int_equal(fresh_refused(fresh), 0);
    fresh_expire(fresh, 2000 * MS);
    assert_int_equal(fresh_refused(fresh), 1);
    fresh_expire(fresh, 2500 * MS);
    assert_int_equal(fresh_refused(fresh), 2);
    prove(1, 0);
    assert_int_equal(released(), 0);
}

// Who plays ten thousand recordings must not fill the memory; what does not fit is refused.
static void held_messages_are_bounded(void **state)
{
    (void)state;
    static const uint8_t bytes[50000];
    for (uint64_t number = 1; number <= 1000; number++)
        hold(1, number, 0);
    assert_int_equal(fresh_refused(fresh), 1000 - FRESH_HELD_MAX);
    for (uint64_t sender = 2; sender <= 10000; sender++)
        hold(sender, 1, (int64_t)sender);
    assert_int_equal(fresh_refused(fresh), 1000 + 9999 - FRESH_WAITING_MAX);
    for (uint64_t number = 2; number < 100; number++) {
        struct seal_origin origin = {.sender = 9999, .salt = 5, .number = number};
        fresh_hold(fresh, WIRE_TEXT, &origin, bytes, sizeof bytes, 10001);
    }
    prove(9999, 1);
    unsigned kept = 0;
    for (struct fresh_message *m; (m = fresh_release(fresh)) != NULL; kept++)
        g_free(m);
    assert_int_equal(kept, FRESH_HELD_BYTES / sizeof bytes);
}

// The oldest sender goes when there is no room; the proof it once gave must then be worth nothing.
static void forgotten_sender_must_prove_itself_anew(void **state)
{
    (void)state;
    uint8_t before[FRESH_CHALLENGE_SIZE];
    memcpy(before, fresh_challenge(fresh), sizeof before);
    for (uint64_t sender = 1; sender <= FRESH_PROVEN_MAX; sender++)
        prove(sender, 0);
    assert_memory_equal(before, fresh_challenge(fresh), sizeof before);
    assert_int_equal(hear(1, 1), FRESH_NEW); // now the second is the oldest
    prove(FRESH_PROVEN_MAX + 1, 0);
    assert_memory_not_equal(before, fresh_challenge(fresh), sizeof before);
    assert_int_equal(fresh_age_ns(fresh, 1500), 500); // what is older than it counts as old now
    assert_int_equal(hear(2, 1), FRESH_UNPROVEN);
    assert_int_equal(hear(1, 1), FRESH_OLD);
    assert_int_equal(hear(FRESH_PROVEN_MAX + 1, 1), FRESH_NEW);
}

// Recordings of an earlier run hold proofs for an earlier receiver.
static void every_receiver_has_a_challenge_of_its_own(void **state)
{
    (void)state;
    struct fresh *other = fresh_create(0);
    assert_memory_not_equal(fresh_challenge(fresh), fresh_challenge(other), FRESH_CHALLENGE_SIZE);
    fresh_free(other);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, with_fresh, without_fresh)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(unknown_sender_is_unproven),
        TEST(only_what_is_above_the_floor_is_new),
        TEST(each_number_is_taken_once),
        TEST(reordered_messages_are_all_taken),
        TEST(leaps_leave_no_trace),
        TEST(kinds_do_not_overtake_each_other),
        TEST(senders_are_independent),
        TEST(second_proof_changes_nothing),
        TEST(unknown_sender_is_asked_at_once_and_again),
        TEST(questions_end_with_what_is_held),
        TEST(held_messages_above_the_floor_are_released),
        TEST(sender_that_never_proves_itself_is_refused),
        TEST(held_messages_are_bounded),
        TEST(forgotten_sender_must_prove_itself_anew),
        TEST(every_receiver_has_a_challenge_of_its_own),
    };
    return sodium_init() < 0 ? 1 : cmocka_run_group_tests(tests, NULL, NULL);
}
