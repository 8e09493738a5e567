#include "common/numeric/statistics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void assert_near(double value, double expected, double margin)
{
    if (!(fabs(value - expected) <= margin))
        fail_msg("%.17g is not within %g of %.17g", value, margin, expected);
}

// Without a bad sample the bound is 0.05^(1/n).
static void no_bad_sample_gives_the_closed_form(void **state)
{
    (void)state;
    static const uint64_t samples[] = {1, 100, 299, 2995, 100000, 100000000};
    for (size_t i = 0; i < sizeof samples / sizeof *samples; i++) {
        double expected = pow(0.05, 1 / (double)samples[i]);
        assert_near(statistics_share_lower(samples[i], 0, 0.95), expected, 1e-12);
    }
    assert_near(statistics_share_lower(100, 0, 0.95), 0.9705, 5e-5);
    assert_near(statistics_share_lower(299, 0, 0.95), 0.9900, 5e-5);
    assert_near(statistics_share_lower(2995, 0, 0.95), 0.9990, 5e-7);
}

// With one good sample of n, P(at least one good) = 1 - (1 - p)^n gives p = 1 - 0.95^(1/n).
static void one_good_sample_gives_the_closed_form(void **state)
{
    (void)state;
    assert_near(statistics_share_lower(10, 9, 0.95), 1 - pow(0.95, 0.1), 1e-12);
    assert_near(statistics_share_lower(5000, 4999, 0.95), 1 - pow(0.95, 1.0 / 5000), 1e-12);
}

// The bound is where the binomial tail equals 5 %: here the tail is summed with lgamma, another
// way.
static void bound_solves_the_binomial_tail(void **state)
{
    (void)state;
    static const uint64_t cases[][2] = {{50, 3}, {1000, 10}, {10000, 80}, {10000, 5000}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double n = (double)cases[i][0];
        const double share = statistics_share_lower(cases[i][0], cases[i][1], 0.95);
        double tail = 0;
        for (double k = 0; k <= (double)cases[i][1]; k++)
            tail += exp(lgamma(n + 1) - lgamma(k + 1) - lgamma(n - k + 1) + k * log(1 - share) +
                        (n - k) * log(share));
        assert_near(tail, 0.05, 1e-9);
    }
}

// More bad samples or more confidence can only lower the bound; nothing known gives 0.
static void bound_is_monotonic(void **state)
{
    (void)state;
    double last = 1;
    for (uint64_t bad = 0; bad <= 200; bad++) {
        double share = statistics_share_lower(200, bad, 0.95);
        assert_true(share < last);
        assert_true(share <= 1 - (double)bad / 200);
        last = share;
    }
    assert_true(statistics_share_lower(200, 3, 0.99) < statistics_share_lower(200, 3, 0.95));
    assert_true(statistics_share_lower(0, 0, 0.95) == 0);
    assert_true(statistics_share_lower(200, 200, 0.95) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_bad_sample_gives_the_closed_form),
        cmocka_unit_test(one_good_sample_gives_the_closed_form),
        cmocka_unit_test(bound_solves_the_binomial_tail),
        cmocka_unit_test(bound_is_monotonic),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
