#define LANES_PATH_PLAIN
#include "worker/kinematics/trigonometry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// The figures that trigonometry.h states.
static const double error_max = 1.8e-16;
static const double angle_max = 1000.0;

static double sine(double angle)
{
    struct lanes s;
    struct lanes c;
    trigonometry_sine_cosine(lanes_set(angle), lanes_set(fabs(angle)), &s, &c);
    return s.v[0];
}

static double cosine(double angle)
{
    struct lanes s;
    struct lanes c;
    trigonometry_sine_cosine(lanes_set(angle), lanes_set(fabs(angle)), &s, &c);
    return c.v[0];
}

static void assert_accurate(double angle)
{
    const long double exact = angle;
    const double sine_error = (double)fabsl(sine(angle) - sinl(exact));
    const double cosine_error = (double)fabsl(cosine(angle) - cosl(exact));
    if (!(sine_error < error_max && cosine_error < error_max)) {
        fail_msg("at %.17g the errors are %.3g and %.3g", angle, sine_error, cosine_error);
    }
}

// Against the C library in extended precision: the yaw angles of crashes densely, the rest of the
// domain at an irrational pitch. A wrong digit in a coefficient shows at the ends of the interval.
static void error_stays_below_the_stated_figure(void **state)
{
    (void)state;
    for (int i = -200000; i <= 200000; i++) {
        assert_accurate(1.7 * i / 200000);
    }
    for (double angle = 0.0; angle <= angle_max; angle += 0.0031415927) {
        assert_accurate(angle);
        assert_accurate(-angle);
    }
}

// Multiples of pi/4 are where the quarter changes and where the reduction cancels most.
static void quarters_meet_without_a_jump(void **state)
{
    (void)state;
    for (int i = -1200; i <= 1200; i++) {
        const double angle = 0.78539816339744830962 * i;
        assert_accurate(angle);
        assert_accurate(nextafter(angle, INFINITY));
        assert_accurate(nextafter(angle, -INFINITY));
    }
}

// The short cut for small angles must give the same bits, because which one a design gets depends
// on its neighbours.
static void short_cut_gives_the_same_bits(void **state)
{
    (void)state;
    for (int i = -100000; i <= 100000; i++) {
        const struct lanes angle = lanes_set(TRIGONOMETRY_SMALL * i / 100000);
        struct lanes full[2];
        struct lanes small[2];
        trigonometry_full(angle, &full[0], &full[1]);
        trigonometry_kernel(angle, &small[0], &small[1]);
        assert_memory_equal(full, small, sizeof full);
    }
}

// Symmetry to the bit: a mirrored crash is the mirrored result.
static void sine_is_odd_and_cosine_is_even(void **state)
{
    (void)state;
    for (double angle = 0.001; angle < 100.0; angle *= 1.001) {
        assert_true(sine(-angle) == -sine(angle));
        assert_true(cosine(-angle) == cosine(angle));
    }
    assert_true(sine(0.0) == 0.0);
    assert_true(cosine(0.0) == 1.0);
}

static void infinite_angle_has_no_sine(void **state)
{
    (void)state;
    assert_true(isnan(sine(INFINITY)));
    assert_true(isnan(cosine(-INFINITY)));
    assert_true(isnan(sine(NAN)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(error_stays_below_the_stated_figure),
        cmocka_unit_test(quarters_meet_without_a_jump),
        cmocka_unit_test(short_cut_gives_the_same_bits),
        cmocka_unit_test(sine_is_odd_and_cosine_is_even),
        cmocka_unit_test(infinite_angle_has_no_sine),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
