#include "worker/runtime/presence.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// A coordinator is new once; after a long silence it may have forgotten this worker, so it is new
// again.
static void coordinator_is_new_once(void **state)
{
    (void)state;
    struct presence presence = {0};
    assert_true(presence_coordinator(&presence, 1, 0));
    assert_false(presence_coordinator(&presence, 1, PRESENCE_SILENCE_NS));
    assert_true(presence_coordinator(&presence, 2, PRESENCE_SILENCE_NS));
    assert_int_equal(presence_coordinator_count(&presence, PRESENCE_SILENCE_NS), 2);
    assert_int_equal(presence_coordinator_count(&presence, 2 * PRESENCE_SILENCE_NS + 1), 0);
    assert_true(presence_coordinator(&presence, 1, 2 * PRESENCE_SILENCE_NS + 1));
    assert_int_equal(presence.coordinator_count, 2);
}

// One that has ended is forgotten, and only that one.
static void ended_coordinator_is_forgotten(void **state)
{
    (void)state;
    struct presence presence = {0};
    presence_coordinator(&presence, 1, 0);
    presence_coordinator(&presence, 2, 0);
    presence_coordinator_ended(&presence, 1);
    presence_coordinator_ended(&presence, 3);
    assert_int_equal(presence_coordinator_count(&presence, 0), 1);
    assert_false(presence_coordinator(&presence, 2, 0));
    assert_true(presence_coordinator(&presence, 1, 0));
}

// More coordinators than are remembered push out the one silent for longest and nothing else.
static void oldest_coordinator_makes_room(void **state)
{
    (void)state;
    struct presence presence = {0};
    for (uint64_t i = 0; i < PRESENCE_COORDINATOR_MAX; i++)
        assert_true(presence_coordinator(&presence, i + 1, (int64_t)i));
    assert_false(presence_coordinator(&presence, 1, 1000)); // now the second is the oldest
    assert_true(presence_coordinator(&presence, 777, 1000));
    assert_int_equal(presence.coordinator_count, PRESENCE_COORDINATOR_MAX);
    assert_false(presence_coordinator(&presence, 1, 1001));
    assert_false(presence_coordinator(&presence, 3, 1001));
    assert_true(presence_coordinator(&presence, 2, 1001));
}

// Whether it is crowded is decided by the last whole second, not by the one that has just begun.
static void crowd_is_counted_by_the_second(void **state)
{
    (void)state;
    struct presence presence = {0};
    for (int i = 0; i <= PRESENCE_CROWD; i++)
        presence_worker(&presence);
    assert_false(presence_crowded(&presence));
    assert_true(presence_second(&presence));
    assert_true(presence_crowded(&presence));
    for (int i = 0; i < PRESENCE_CROWD; i++)
        presence_worker(&presence);
    presence_second(&presence);
    assert_false(presence_crowded(&presence));
}

// Thousands of workers, each of which hears all the others: they speak less often, and more often
// again when the others are gone. Answers to a new coordinator are spread by how many there are,
// not by how many are heard.
static void thousands_of_workers_speak_less_often(void **state)
{
    (void)state;
    struct presence presence = {0};
    uint32_t pace = 1;
    for (int second = 0; second < 10; second++) {
        for (uint32_t i = 0; i < 4096 / pace; i++)
            presence_worker(&presence);
        presence_second(&presence);
        pace = presence.pace;
    }
    assert_int_equal(pace, 8);
    assert_int_equal(presence_spread_ms(&presence), 4096 / PRESENCE_SPREAD_RATE);
    uint32_t spoken = 0;
    for (int second = 0; second < 16; second++) {
        for (uint32_t i = 0; i < 4096 / pace; i++)
            presence_worker(&presence);
        spoken += presence_second(&presence);
    }
    assert_int_equal(spoken, 2);
    for (int second = 0; second < 3; second++)
        presence_second(&presence);
    assert_int_equal(presence.pace, 1);
    assert_true(presence_second(&presence));
    assert_int_equal(presence_spread_ms(&presence), PRESENCE_SPREAD_MS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coordinator_is_new_once),
        cmocka_unit_test(ended_coordinator_is_forgotten),
        cmocka_unit_test(oldest_coordinator_makes_room),
        cmocka_unit_test(crowd_is_counted_by_the_second),
        cmocka_unit_test(thousands_of_workers_speak_less_often),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
