// The names of a sweep's cases, told in turn again and again, in any order.
#include "monitor/feed/cases.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static int setup(void **state)
{
    static struct cases cases;
    cases_init(&cases);
    *state = &cases;
    return 0;
}

static int teardown(void **state)
{
    cases_fini(*state);
    return 0;
}

#define HEAR(state, index, count, texts, version)            \
    cases_hear(*(state),                                     \
               &(sobox_cases_t){.first = (index),            \
                                .columns = (count),          \
                                .text_size = sizeof(texts),  \
                                .text = (uint8_t *)(texts)}, \
               version)

static void cases_are_found_by_their_place(void **state)
{
    const struct cases *cases = *state;
    assert_true(HEAR(state, 5, 2, "mass=1500\0001500\0mass=1800\0001800", 1));
    assert_true(HEAR(state, -1, 2, "case\0vehicle.mass", 2));
    assert_string_equal(cases_find(cases, 5)[0], "mass=1500");
    assert_string_equal(cases_find(cases, 6)[1], "1800");
    assert_null(cases_find(cases, 4));
    assert_null(cases_find(cases, 7));
    assert_string_equal(cases->axes[1], "vehicle.mass");
    assert_int_equal(cases->changed, 2);
}

// Every case is told of again and again: that is no news, and nobody is sent it.
static void what_is_told_again_is_no_news(void **state)
{
    const struct cases *cases = *state;
    assert_true(HEAR(state, 0, 2, "a\0001\0b\0002", 1));
    assert_false(HEAR(state, 0, 2, "a\0001\0b\0002", 2));
    assert_true(HEAR(state, 0, 2, "a\0001\0b\0003", 3));
    assert_int_equal(g_array_index(cases->entries, struct cases_entry, 0).changed, 1);
    assert_int_equal(g_array_index(cases->entries, struct cases_entry, 1).changed, 3);
}

// Whoever invents cases without end costs a bounded memory.
static void cases_beyond_measure_are_not_kept(void **state)
{
    const struct cases *cases = *state;
    assert_false(HEAR(state, INT32_MAX, 1, "far", 1));
    assert_true(HEAR(state, CASES_KNOWN_MAX - 1, 1, "last\0beyond", 2));
    assert_int_equal(cases->entries->len, CASES_KNOWN_MAX);
}

// What could move the cursor of a terminal is not handed on.
static void unprintable_letters_are_marked(void **state)
{
    assert_true(HEAR(state, 0, 1, "a\x1b[2Jb", 1));
    assert_string_equal(cases_find(*state, 0)[0], "a?[2Jb");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(cases_are_found_by_their_place, setup, teardown),
        cmocka_unit_test_setup_teardown(what_is_told_again_is_no_news, setup, teardown),
        cmocka_unit_test_setup_teardown(cases_beyond_measure_are_not_kept, setup, teardown),
        cmocka_unit_test_setup_teardown(unprintable_letters_are_marked, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
