#include "common/base/status.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// Texts come from one list; a status without one would print "(null)".
static void every_status_has_a_text(void **state)
{
    (void)state;
#define CHECK_TEXT(name, text) assert_string_equal(status_text(name), text);
    STATUS_LIST(CHECK_TEXT)
#undef CHECK_TEXT
}

// Scripts rely on the exit statuses: wrong input is told from failure, and both from success.
static void exit_status_tells_input_from_failure(void **state)
{
    (void)state;
    assert_int_equal(status_exit(STATUS_OK), 0);
    assert_int_equal(status_exit(STATUS_INVALID), 2);
    assert_int_equal(status_exit(STATUS_INTERRUPTED), 130);
    assert_int_equal(status_exit(STATUS_IO), 1);
    assert_int_equal(status_exit(STATUS_NETWORK), 1);
    assert_int_equal(status_exit(STATUS_REFUSED), 1);
    assert_int_equal(status_exit(STATUS_FAILED), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_status_has_a_text),
        cmocka_unit_test(exit_status_tells_input_from_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
