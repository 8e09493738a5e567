// Steps with their samples as a monitor puts them together from messages: whole or in parts, with
// parts lost, doubled and of two steps at once, and whatever strangers send.
#include "monitor/feed/album.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { VARIABLES = 5, SAMPLES = 3 };

static int setup(void **state)
{
    static struct album album;
    album_init(&album);
    *state = &album;
    return 0;
}

static int teardown(void **state)
{
    album_fini(*state);
    return 0;
}

// Lower bounds are 10, 11, ... and upper ones one more; of the box after the step half of that.
static void part_fill(uint8_t *at, uint32_t first, uint32_t window)
{
    static const double shift[] = {10, 11, 5, 5.5};
    for (int side = 0; side < 4; side++) {
        for (uint32_t i = 0; i < window; i++) {
            const double value = shift[side] + (first + i) * (side < 2 ? 1 : 0.5);
            memcpy(at, &value, sizeof value);
            at += sizeof value;
        }
    }
}

// Gives the album the bounds of `window` variables of a step; the verdicts are in the first part:
// good, bad by constraint 2, good.
static bool hear(struct album *album, int32_t step, uint32_t first, uint32_t window)
{
    static const struct verdict verdicts[SAMPLES] = {{0}, {.violation = 900, .constraint = 2}, {0}};
    uint8_t packed[512];
    const size_t size =
        first == 0 ? verdict_pack(verdicts, SAMPLES, VERDICT_DETAIL_FULL, packed) : 0;
    part_fill(packed + size, first, window);
    const sobox_step_status_t message = {
        .seed = 7,
        .step = step,
        .phase = 1,
        .samples = 200,
        .good = 150,
        .count = first == 0 ? SAMPLES : 0,
        .variables = VARIABLES,
        .first_variable = (int32_t)first,
        .window = (int32_t)window,
        .packed_size = (int32_t)(size + window * 4 * sizeof(double)),
        .packed = packed,
    };
    return album_hear(album, &message);
}

static void assert_whole(const struct album_picture *picture, uint32_t step)
{
    assert_non_null(picture);
    assert_int_equal(picture->sampling.step, step);
    assert_int_equal(picture->sampling.samples, 200);
    assert_int_equal(picture->count, SAMPLES);
    assert_int_equal(picture->verdicts[1].constraint, 2);
    assert_int_equal(picture->verdicts[1].violation, 900);
    for (uint32_t i = 0; i < VARIABLES; i++) {
        assert_float_equal(picture->sampled.lower[i], 10 + i, 0);
        assert_float_equal(picture->sampled.upper[i], 11 + i, 0);
        assert_float_equal(picture->box.lower[i], 5 + 0.5 * i, 0);
        assert_float_equal(picture->box.upper[i], 5.5 + 0.5 * i, 0);
    }
}

static void step_of_one_message_is_whole_at_once(void **state)
{
    assert_true(hear(*state, 4, 0, VARIABLES));
    assert_whole(album_find(*state, UINT32_MAX), 4);
    assert_null(album_find(*state, 3));
}

// Parts overtake each other and come twice; nothing is shown before the last has come.
static void parts_make_a_whole(void **state)
{
    assert_false(hear(*state, 4, 0, 2));
    assert_false(hear(*state, 4, 4, 1));
    assert_false(hear(*state, 4, 4, 1));
    assert_null(album_find(*state, UINT32_MAX));
    assert_true(hear(*state, 4, 2, 2));
    assert_whole(album_find(*state, UINT32_MAX), 4);
}

// A part of one step never completes another, and without the verdicts the rest tells nothing.
static void steps_are_not_mixed(void **state)
{
    assert_false(hear(*state, 4, 0, 3));
    assert_false(hear(*state, 5, 3, 2));
    assert_null(album_find(*state, UINT32_MAX));
    assert_false(hear(*state, 6, 0, 3));
    assert_true(hear(*state, 6, 3, 2));
    assert_whole(album_find(*state, UINT32_MAX), 6);
}

// A coordinator that was started anew stands some steps before what was shown.
static void earlier_step_takes_the_place_of_later_ones(void **state)
{
    for (int32_t step = 1; step <= 5; step++)
        assert_true(hear(*state, step, 0, VARIABLES));
    assert_true(hear(*state, 3, 0, VARIABLES));
    const struct album *album = *state;
    assert_int_equal(album->pictures->len, 3);
    assert_whole(album_find(album, UINT32_MAX), 3);
    assert_whole(album_find(album, 1), 1);
}

// However long a search is: what is kept is bounded, begins at its beginning and ends at its end.
static void long_course_is_spanned(void **state)
{
    const struct album *album = *state;
    for (int32_t step = 0; step < 5000; step++) {
        assert_true(hear(*state, step, 0, VARIABLES));
        assert_true(album->pictures->len <= ALBUM_PICTURE_MAX);
    }
    assert_whole(album_find(album, UINT32_MAX), 4999);
    assert_whole(album_find(album, 0), 0);
    assert_true(album->pictures->len >= ALBUM_PICTURE_MAX / 2);
}

// Bounds that are none, or verdicts that do not unpack, are nobody's step.
static void nonsense_is_dropped(void **state)
{
    uint8_t packed[2 + 3 * 3 + 32];
    memset(packed, 0, sizeof packed);
    sobox_step_status_t message = {
        .samples = SAMPLES,
        .count = SAMPLES,
        .variables = 1,
        .window = 1,
        .packed_size = 1 + 32,
        .packed = packed,
    };
    packed[0] = 0xff; // unused bits are set
    assert_false(album_hear(*state, &message));
    packed[0] = 7;
    assert_true(album_hear(*state, &message));
    const double bad[] = {NAN, INFINITY, 1};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        memcpy(packed + 1, &bad[i], sizeof bad[i]); // the upper bound is 0
        message.step++;
        assert_false(album_hear(*state, &message));
    }
    const struct album *album = *state;
    assert_int_equal(album->pictures->len, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(step_of_one_message_is_whole_at_once, setup, teardown),
        cmocka_unit_test_setup_teardown(parts_make_a_whole, setup, teardown),
        cmocka_unit_test_setup_teardown(steps_are_not_mixed, setup, teardown),
        cmocka_unit_test_setup_teardown(earlier_step_takes_the_place_of_later_ones, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(long_course_is_spanned, setup, teardown),
        cmocka_unit_test_setup_teardown(nonsense_is_dropped, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
