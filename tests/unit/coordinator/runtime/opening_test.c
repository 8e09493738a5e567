// The rule alone: when another search is opened, and when not.
#include "coordinator/runtime/opening.h"

#include "common/scenario/scenario_read.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const char yaml[] = "name: opening\n"
                           "model: hypersphere\n"
                           "variables:\n"
                           "  - {name: a, lower: -1, upper: 1}\n"
                           "  - {name: b, lower: -1, upper: 1}\n"
                           "constraints: {distance: {max: 0}}\n";

static struct scenario scenario;

static const struct schedule_counters hungry = {.workers = 4096};

static int setup(void **state)
{
    (void)state;
    struct error error;
    assert_int_equal(scenario_read_text(&scenario, "opening", yaml, strlen(yaml), NULL, 0, &error),
                     STATUS_OK);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    scenario_fini(&scenario);
    return 0;
}

static struct opening open_many(uint64_t memory_size, uint32_t count)
{
    struct opening opening = {.memory_size = memory_size};
    for (uint32_t i = 0; i < count; i++)
        opening_open(&opening, &scenario);
    return opening;
}

// How many are opened one after the other while every worker stays hungry.
static uint32_t opened(uint64_t memory_size)
{
    struct opening opening = {.memory_size = memory_size};
    while (opening_wanted(&opening, &hungry, 0))
        opening_open(&opening, &scenario);
    return opening.open_count;
}

// The first search is opened before any worker has come, so that workers find it.
static void first_search_waits_for_nobody(void **state)
{
    (void)state;
    const struct opening opening = {0};
    assert_true(opening_wanted(&opening, &(struct schedule_counters){0}, 5));
}

static void another_is_opened_when_nothing_waits_for_a_worker(void **state)
{
    (void)state;
    const struct opening opening = open_many(UINT64_MAX, 1);
    assert_true(opening_wanted(&opening, &hungry, 0));
    const struct schedule_counters fed = {.workers = 4096, .batches_waiting = 1};
    assert_false(opening_wanted(&opening, &fed, 0));
    const struct schedule_counters nobody = {0};
    assert_false(opening_wanted(&opening, &nobody, 0));
    assert_false(opening_wanted(&opening, &hungry, OPENING_TRIMS_MAX));
}

// Thousands of hungry workers open as many as workers can know, and not one more.
static void many_workers_open_many(void **state)
{
    (void)state;
    assert_int_equal(opened(UINT64_MAX), OPENING_MAX);
}

// What searches will take counts, not what they take at first: all of them grow.
static void memory_bounds_what_is_open(void **state)
{
    (void)state;
    assert_int_equal(opened(10 * opening_size(&scenario)), 10);
    assert_int_equal(opened(0), OPENING_LEAST);
}

static void closed_search_makes_room(void **state)
{
    (void)state;
    struct opening opening = open_many(10 * opening_size(&scenario), 10);
    assert_false(opening_wanted(&opening, &hungry, 0));
    opening_close(&opening, &scenario);
    assert_true(opening_wanted(&opening, &hungry, 0));
}

// A greater scenario takes more, up to the bound on what a search remembers.
static void size_follows_samples_and_steps(void **state)
{
    (void)state;
    const uint64_t size = opening_size(&scenario);
    struct scenario greater = scenario;
    greater.search.samples *= 10;
    assert_true(opening_size(&greater) > 5 * size);
    greater.search.exploration_steps = UINT32_MAX;
    const uint64_t most = opening_size(&greater);
    greater.search.consolidation_steps = UINT32_MAX;
    assert_int_equal(opening_size(&greater), most);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_search_waits_for_nobody),
        cmocka_unit_test(another_is_opened_when_nothing_waits_for_a_worker),
        cmocka_unit_test(many_workers_open_many),
        cmocka_unit_test(memory_bounds_what_is_open),
        cmocka_unit_test(closed_search_makes_room),
        cmocka_unit_test(size_follows_samples_and_steps),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
