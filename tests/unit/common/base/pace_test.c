// Workers that hear each other and slow down alike, second by second.
#include "common/base/pace.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// The pace at which so many workers settle that begin at `seconds`.
static uint32_t settled(uint32_t workers, uint32_t seconds)
{
    for (int second = 0; second < 20; second++)
        seconds = pace_next(seconds, workers / seconds);
    assert_int_equal(pace_next(seconds, workers / seconds), seconds);
    return seconds;
}

static void few_workers_speak_every_second(void **state)
{
    (void)state;
    assert_int_equal(settled(1, 1), 1);
    assert_int_equal(settled(PACE_HEARD_MAX, 1), 1);
    assert_int_equal(settled(10, PACE_MAX), 1);
}

// What all hear together stays the same from some hundred workers on: traffic that would grow with
// the square grows with the number.
static void thousands_are_heard_as_often_as_hundreds(void **state)
{
    (void)state;
    for (uint32_t workers = PACE_HEARD_MAX; workers <= 20000; workers += 37) {
        const uint32_t heard = workers / settled(workers, 1);
        assert_in_range(heard, PACE_HEARD_MIN, PACE_HEARD_MAX);
    }
    assert_int_equal(settled(4096, 1), 8);
}

// Whoever waits waits long enough, whether the workers became many or were more before.
static void nobody_speaks_less_often_than_is_waited_for(void **state)
{
    (void)state;
    for (uint32_t workers = 1; workers <= 20000; workers += 7) {
        assert_true(settled(workers, 1) <= pace_most(workers));
        assert_true(workers < PACE_HEARD_MAX ||
                    settled(workers, PACE_MAX) <= 2 * pace_most(workers));
    }
    assert_int_equal(pace_most(0), 1);
    assert_int_equal(pace_most(PACE_HEARD_MAX), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_workers_speak_every_second),
        cmocka_unit_test(thousands_are_heard_as_often_as_hundreds),
        cmocka_unit_test(nobody_speaks_less_often_than_is_waited_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
