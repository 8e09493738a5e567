#include "coordinator/search/stagnation.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// e to the power of `exponent`, also far below the least double.
static struct volume volume_at(double exponent)
{
    const double binary = exponent / log(2);
    const double whole = floor(binary) + 1;
    return (struct volume){.mantissa = exp2(binary - whole), .exponent = (int64_t)whole};
}

// After how many steps of that log-volume it stagnates; 1000: not until then.
static int steps_until(uint32_t window, double log_volume(int))
{
    struct stagnation stagnation;
    stagnation_init(&stagnation, window);
    int steps = 0;
    while (steps < 1000 && !stagnation_note(&stagnation, volume_at(log_volume(steps))))
        steps++;
    stagnation_fini(&stagnation);
    return steps;
}

static double rising(int step)
{
    return -5000 + 0.001 * step;
}

static double level_after_hundred(int step)
{
    return step < 100 ? -200 + step : -100;
}

static double level(int step)
{
    (void)step;
    return -2000; // a box of 720 variables
}

// Up and down by more than it gains in a step.
static double rising_with_noise(int step)
{
    return 0.05 * step + (step % 3 == 0 ? 0.1 : 0);
}

// As long as the box grows, however little, the search goes on; and a volume that no double can
// hold is compared like any other.
static void gain_is_no_stagnation(void **state)
{
    (void)state;
    assert_int_equal(steps_until(10, rising), 1000);
    assert_int_equal(steps_until(10, rising_with_noise), 1000);
}

// It takes both windows to know, and both must lie where nothing is gained.
static void two_windows_without_gain_are(void **state)
{
    (void)state;
    assert_int_equal(steps_until(10, level), 19);
    assert_int_equal(steps_until(1, level), 1);
    assert_in_range(steps_until(10, level_after_hundred), 110, 121);
}

// Off, which is the default.
static void no_window_never_stagnates(void **state)
{
    (void)state;
    assert_int_equal(steps_until(0, level), 1000);
    struct stagnation zeroed = {0};
    assert_false(stagnation_note(&zeroed, volume_at(0)));
    stagnation_fini(&zeroed);
}

// Another phase begins with nothing known.
static void reset_forgets(void **state)
{
    (void)state;
    struct stagnation stagnation;
    stagnation_init(&stagnation, 5);
    for (int i = 0; i < 9; i++)
        assert_false(stagnation_note(&stagnation, volume_at(-1)));
    stagnation_reset(&stagnation);
    for (int i = 0; i < 9; i++)
        assert_false(stagnation_note(&stagnation, volume_at(-1)));
    assert_true(stagnation_note(&stagnation, volume_at(-1)));
    stagnation_fini(&stagnation);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gain_is_no_stagnation),
        cmocka_unit_test(two_windows_without_gain_are),
        cmocka_unit_test(no_window_never_stagnates),
        cmocka_unit_test(reset_forgets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
