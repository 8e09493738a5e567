#include "common/sampling/box_text.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { VARIABLES = 3, ATTACKS = 2, BOUNDS_SIZE = 2 * VARIABLES * 8, ROW = 1 + VARIABLES };

static double lower[VARIABLES] = {0, -1e5, 3};
static double upper[VARIABLES] = {1, 450e3, 3};
static const struct box box = {.count = VARIABLES, .lower = lower, .upper = upper};

// The second one attacks constraint 255: a target is no level.
static uint8_t rows[ATTACKS * ROW] = {4, 0, MOVES_LEVEL_MAX, 127, 255, 1, 2, 3};
static const struct moves moves = {.variables = VARIABLES, .attacks = ATTACKS, .rows = rows};

static GByteArray *text_of(const struct moves *of)
{
    GByteArray *text = g_byte_array_new();
    box_text_put(text, &box, of);
    return text;
}

// A step's box and attacks reach the worker as they are, fixed variables among them.
static void box_with_attacks_survives_the_round_trip(void **state)
{
    (void)state;
    GByteArray *text = text_of(&moves);
    assert_int_equal(text->len, BOUNDS_SIZE + sizeof rows);
    assert_true(box_text_size_ok(text->len, VARIABLES));
    struct box box_read;
    struct moves moves_read;
    assert_null(box_text_get(text->data, text->len, VARIABLES, &box_read, &moves_read));
    assert_memory_equal(box_read.lower, lower, sizeof lower);
    assert_memory_equal(box_read.upper, upper, sizeof upper);
    assert_int_equal(moves_read.variables, VARIABLES);
    assert_int_equal(moves_read.attacks, ATTACKS);
    assert_memory_equal(moves_read.rows, rows, sizeof rows);
    box_fini(&box_read);
    moves_fini(&moves_read);
    g_byte_array_unref(text);
}

// Without attacks the text is that of the bounds alone, which is what steps of points had before
// there were attacks: their digests stay.
static void box_without_attacks_is_its_bounds(void **state)
{
    (void)state;
    GByteArray *text = text_of(NULL);
    assert_int_equal(text->len, BOUNDS_SIZE);
    static const uint8_t one[8] = {0, 0, 0, 0, 0, 0, 0xF0, 0x3F}; // low byte first
    assert_memory_equal(text->data + BOUNDS_SIZE / 2, one, sizeof one);
    struct box box_read;
    struct moves moves_read;
    assert_null(box_text_get(text->data, text->len, VARIABLES, &box_read, &moves_read));
    assert_int_equal(moves_read.attacks, 0);
    box_fini(&box_read);
    moves_fini(&moves_read);
    g_byte_array_unref(text);
}

// A text is bounds and whole rows, nothing else.
static void sizes_that_no_box_has_are_refused(void **state)
{
    (void)state;
    GByteArray *text = text_of(&moves);
    for (size_t size = 0; size <= text->len; size++) {
        const bool whole = size >= BOUNDS_SIZE && (size - BOUNDS_SIZE) % ROW == 0;
        struct box box_read;
        struct moves moves_read;
        assert_int_equal(box_text_size_ok(size, VARIABLES), whole);
        // Exactly so long, so that the sanitizers see a byte read beyond.
        uint8_t *exact = g_memdup2(text->data, size);
        const char *wrong = box_text_get(exact, size, VARIABLES, &box_read, &moves_read);
        assert_int_equal(wrong == NULL, whole);
        if (wrong == NULL) {
            box_fini(&box_read);
            moves_fini(&moves_read);
        }
        g_free(exact);
    }
    assert_false(box_text_size_ok(0, 0));
    assert_false(box_text_size_ok(16, 0));
    assert_false(box_text_size_ok(16, UINT32_MAX));
    g_byte_array_unref(text);
}

static void assert_refused(const GByteArray *text, const char *part)
{
    struct box box_read;
    struct moves moves_read;
    const char *wrong = box_text_get(text->data, text->len, VARIABLES, &box_read, &moves_read);
    assert_non_null(wrong);
    assert_non_null(strstr(wrong, part));
}

// Bounds from the network may be upside down or no numbers.
static void bounds_that_are_no_interval_are_refused(void **state)
{
    (void)state;
    static const double bad[] = {2, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < G_N_ELEMENTS(bad); i++) {
        GByteArray *text = text_of(&moves);
        memcpy(text->data, &bad[i], sizeof bad[i]); // above the upper bound of 1, or not finite
        assert_refused(text, "interval");
        g_byte_array_unref(text);
    }
    GByteArray *text = text_of(NULL);
    const double infinite = INFINITY;
    memcpy(text->data + BOUNDS_SIZE - sizeof infinite, &infinite, sizeof infinite);
    assert_refused(text, "interval");
    g_byte_array_unref(text);
}

// A level beyond the greatest would be a design outside the box, which no promise covers.
static void levels_beyond_the_bounds_are_refused(void **state)
{
    (void)state;
    for (size_t at = 0; at < sizeof rows; at++) {
        if (at % ROW == 0)
            continue;
        GByteArray *text = text_of(&moves);
        text->data[BOUNDS_SIZE + at] = MOVES_LEVEL_MAX + 1;
        assert_refused(text, "beyond");
        g_byte_array_unref(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_with_attacks_survives_the_round_trip),
        cmocka_unit_test(box_without_attacks_is_its_bounds),
        cmocka_unit_test(sizes_that_no_box_has_are_refused),
        cmocka_unit_test(bounds_that_are_no_interval_are_refused),
        cmocka_unit_test(levels_beyond_the_bounds_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
