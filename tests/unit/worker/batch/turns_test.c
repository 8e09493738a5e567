#include "worker/batch/turns.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { ENTRIES = 16 };

struct fixture {
    struct turns turns;
    struct turn entries[ENTRIES];
    unsigned count;
};

static int set_up(void **state)
{
    struct fixture *fixture = g_new0(struct fixture, 1);
    turns_init(&fixture->turns);
    *state = fixture;
    return 0;
}

static int tear_down(void **state)
{
    struct fixture *fixture = *state;
    turns_fini(&fixture->turns);
    g_free(fixture);
    return 0;
}

static void add(struct fixture *fixture, uint64_t coordinator, uint64_t arrival)
{
    assert_true(fixture->count < ENTRIES);
    struct turn *turn = &fixture->entries[fixture->count++];
    *turn = (struct turn){.coordinator = coordinator, .arrival = arrival};
    turns_add(&fixture->turns, turn);
}

// Takes until nothing is left: these arrivals, up to a 0.
static void assert_taken(struct fixture *fixture, const uint64_t *arrivals)
{
    const struct turn *turn;
    while ((turn = turns_take(&fixture->turns)) != NULL)
        assert_int_equal(turn->arrival, *arrivals++);
    assert_int_equal(*arrivals, 0);
}
#define ASSERT_TAKEN(fixture, ...) assert_taken(fixture, (const uint64_t[]){__VA_ARGS__, 0})

static void oldest_is_first_whenever_it_became_ready(void **state)
{
    add(*state, 7, 3);
    add(*state, 7, 1);
    add(*state, 7, 4);
    add(*state, 7, 2);
    ASSERT_TAKEN(*state, 1, 2, 3, 4);
}

// The drawing of the header.
static void coordinators_take_turns(void **state)
{
    static const uint64_t coordinators[] = {1, 1, 2, 3, 1, 1, 1};
    for (unsigned i = 0; i < G_N_ELEMENTS(coordinators); i++)
        add(*state, coordinators[i], i + 1);
    ASSERT_TAKEN(*state, 1, 3, 4, 2, 5, 6, 7);
}

// One that always has more must not be served twice while another waits once.
static void newcomer_waits_for_one_batch_of_each_other(void **state)
{
    struct fixture *fixture = *state;
    add(fixture, 1, 1);
    add(fixture, 1, 2);
    add(fixture, 1, 3);
    assert_int_equal(turns_take(&fixture->turns)->arrival, 1);
    add(fixture, 2, 4);
    assert_int_equal(turns_take(&fixture->turns)->arrival, 2);
    add(fixture, 1, 5);
    assert_int_equal(turns_take(&fixture->turns)->arrival, 4);
    ASSERT_TAKEN(fixture, 3, 5);
}

static void nothing_is_taken_where_nothing_waits(void **state)
{
    struct fixture *fixture = *state;
    assert_null(turns_take(&fixture->turns));
    add(fixture, 1, 1);
    ASSERT_TAKEN(fixture, 1);
    add(fixture, 1, 2);
    ASSERT_TAKEN(fixture, 2);
}

int main(void)
{
#define TURNS_TEST(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TURNS_TEST(oldest_is_first_whenever_it_became_ready),
        TURNS_TEST(coordinators_take_turns),
        TURNS_TEST(newcomer_waits_for_one_batch_of_each_other),
        TURNS_TEST(nothing_is_taken_where_nothing_waits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
