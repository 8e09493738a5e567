#include "coordinator/search/certificate.h"

#include "common/numeric/random.h"
#include "common/numeric/statistics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// However many looks are taken, together they may err in at most 5 % of searches.
static void looks_share_five_percent(void **state)
{
    (void)state;
    double sum = 0;
    for (uint32_t look = 0; look < CERTIFICATE_LOOKS; look++) {
        assert_true(certificate_alpha(look) > 0);
        sum += certificate_alpha(look);
    }
    assert_true(sum <= 0.05);
    assert_true(certificate_alpha(0) >= 0.045);
}

// Each look's bound is that of Clopper and Pearson at the confidence the look has left.
static void bound_is_taken_at_the_looks_confidence(void **state)
{
    (void)state;
    struct certificate certificate = {0};
    certificate_look(&certificate, 10000, 50);
    assert_true(certificate.lower95 == statistics_share_lower(10000, 50, 1 - certificate_alpha(0)));
    assert_true(certificate.lower95 <= statistics_share_lower(10000, 50, 0.95));
    certificate_look(&certificate, 10000, 50);
    assert_int_equal(certificate.looks, 2);
    assert_true(certificate.lower95 == statistics_share_lower(10000, 50, 1 - certificate_alpha(1)));
}

// The limit is sharp: with that many bad samples the look passes, with one more it does not.
static void most_bad_samples_are_just_allowed(void **state)
{
    (void)state;
    static const struct certificate none = {0};
    static const uint64_t samples[] = {310, 1000, 10000, 100000};
    for (int i = 0; i < 4; i++) {
        int64_t most = certificate_bad_max(&none, samples[i], 0.99);
        assert_true(most >= 0);
        struct certificate passed = none;
        certificate_look(&passed, samples[i], (uint64_t)most);
        assert_true(passed.lower95 >= 0.99);
        struct certificate missed = none;
        certificate_look(&missed, samples[i], (uint64_t)most + 1);
        assert_true(missed.lower95 < 0.99);
    }
    assert_int_equal(certificate_bad_max(&none, 100, 0.99), -1);
}

// A box of purity just below the target, looked at until the looks are used up, passes in less than
// 5 % of searches. Taking each look at 95 % would let a fifth of them through.
static void repeated_looks_do_not_wear_the_bound_down(void **state)
{
    (void)state;
    enum { SEARCHES = 1000, SAMPLES = 500 };
    uint32_t passed = 0;
    uint32_t naive = 0;
    for (uint32_t search = 0; search < SEARCHES; search++) {
        struct certificate certificate = {0};
        bool pass = false;
        bool naive_pass = false;
        for (uint32_t look = 0; look < CERTIFICATE_LOOKS; look++) {
            uint64_t bad = 0;
            for (uint32_t i = 0; i < SAMPLES; i++)
                bad += random_uniform(11, search, look, i, 0) > 0.9499;
            certificate_look(&certificate, SAMPLES, bad);
            pass = pass || certificate.lower95 >= 0.95;
            naive_pass = naive_pass || statistics_share_lower(SAMPLES, bad, 0.95) >= 0.95;
        }
        passed += pass;
        naive += naive_pass;
    }
    assert_true(passed <= 0.065 * SEARCHES);
    assert_true(naive > 0.1 * SEARCHES);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(looks_share_five_percent),
        cmocka_unit_test(bound_is_taken_at_the_looks_confidence),
        cmocka_unit_test(most_bad_samples_are_just_allowed),
        cmocka_unit_test(repeated_looks_do_not_wear_the_bound_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
