#include "common/base/arithmetic.h"

#include "common/base/log.h"

#include <fenv.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// A foreign rounding mode changes the last bit of a sum, and so every digest.
static void foreign_rounding_is_set_right(void **state)
{
    (void)state;
    volatile double one = 1, little = 1e-17;
    log_start("arithmetic_test", LOG_QUIET);
    assert_int_equal(fesetround(FE_UPWARD), 0);
    assert_true(one + little > 1);
    arithmetic_start();
    assert_int_equal(fegetround(), FE_TONEAREST);
    assert_true(one + little == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(foreign_rounding_is_set_right)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
