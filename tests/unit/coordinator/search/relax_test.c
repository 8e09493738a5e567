#include "coordinator/search/relax.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// Tries amounts until it is done; those up to `most` are kept.
static double found(double most)
{
    struct relax relax;
    relax_init(&relax);
    uint32_t trials = 1;
    while (relax_next(&relax, relax.amount <= most))
        assert_true(++trials <= RELAX_TRIALS);
    return relax.kept;
}

// From thousandths to whole units the amount comes close from below, and never above.
static void greatest_amount_is_found_from_below(void **state)
{
    (void)state;
    for (double most = 0.004; most < 0.6; most *= 1.7) {
        const double kept = found(most);
        assert_true(kept <= most);
        assert_true(kept >= 0.7 * most);
    }
}

// Where nothing may be missed the box without bad designs is kept.
static void nothing_is_kept_where_nothing_passes(void **state)
{
    (void)state;
    assert_true(found(0) == 0);
}

// A missed certificate takes the amount back, and always below what had passed before.
static void going_back_lowers_what_is_kept(void **state)
{
    (void)state;
    struct relax relax;
    relax_init(&relax);
    assert_true(relax_next(&relax, true));
    const double kept = relax.kept;
    relax_back(&relax);
    assert_true(relax.kept < kept && relax.kept > 0);
    assert_true(relax.amount == relax.kept);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(greatest_amount_is_found_from_below),
        cmocka_unit_test(nothing_is_kept_where_nothing_passes),
        cmocka_unit_test(going_back_lowers_what_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
