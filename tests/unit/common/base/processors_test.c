#include "common/base/processors.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// What users and batch systems write there; what cannot be meant limits nothing.
static void variables_are_read(void **state)
{
    (void)state;
    assert_int_equal(processors_of_variable("3"), 3);
    assert_int_equal(processors_of_variable(" 3 "), 3);
    assert_int_equal(processors_of_variable("4,2"), 4);
    assert_int_equal(processors_of_variable(NULL), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_variable(""), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_variable("0"), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_variable("-1"), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_variable("many"), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_variable("99999999999999999999"), PROCESSORS_NO_LIMIT);
}

static void quotas_are_read(void **state)
{
    (void)state;
    assert_int_equal(processors_of_quota("max 100000\n"), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_quota("200000 100000\n"), 2);
    assert_int_equal(processors_of_quota("150000 100000\n"), 2);
    assert_int_equal(processors_of_quota("50000 100000\n"), 1);
    assert_int_equal(processors_of_quota("50000"), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_quota("50000 0"), PROCESSORS_NO_LIMIT);
    assert_int_equal(processors_of_quota(""), PROCESSORS_NO_LIMIT);
}

// Of all limits the least holds; one above what there is changes nothing.
static void the_least_limit_holds(void **state)
{
    (void)state;
    g_unsetenv("OMP_NUM_THREADS");
    g_unsetenv("OMP_THREAD_LIMIT");
    const int all = processors_usable();
    assert_in_range(all, 1, g_get_num_processors());
    assert_int_equal(processors_limited(1000), 1000);
    g_setenv("OMP_NUM_THREADS", "1", 1);
    assert_int_equal(processors_usable(), 1);
    g_setenv("OMP_NUM_THREADS", "100000", 1);
    assert_int_equal(processors_usable(), all);
    g_setenv("OMP_THREAD_LIMIT", "1", 1);
    assert_int_equal(processors_usable(), 1);
    assert_int_equal(processors_limited(1000), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(variables_are_read),
        cmocka_unit_test(quotas_are_read),
        cmocka_unit_test(the_least_limit_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
