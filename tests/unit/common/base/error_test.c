#include "common/base/error.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// The first layer says what is wrong and returns the status, so that it can be a return statement.
static void set_formats_and_returns_the_status(void **state)
{
    (void)state;
    struct error error = {0};
    assert_int_equal(error_set(&error, STATUS_IO, "%s: %d", "run.db", 7), STATUS_IO);
    assert_int_equal(error.status, STATUS_IO);
    assert_string_equal(error.text, "run.db: 7");
}

// A caller who does not want the sentence still gets the status.
static void nobody_has_to_listen(void **state)
{
    (void)state;
    assert_int_equal(error_set(NULL, STATUS_NETWORK, "silence"), STATUS_NETWORK);
}

// Each layer puts what it knows in front and leaves the rest alone.
static void wrapping_puts_the_context_in_front(void **state)
{
    (void)state;
    struct error error = {0};
    error_set(&error, STATUS_INVALID, "expected more than 0");
    assert_int_equal(error_wrap(&error, "%s", "mass"), STATUS_INVALID);
    error_wrap(&error, "car.yaml:%d:%d", 3, 9);
    assert_string_equal(error.text, "car.yaml:3:9: mass: expected more than 0");
}

// A message may be made from the one it replaces, where a careless vsnprintf would read what it
// writes.
static void a_message_can_quote_itself(void **state)
{
    (void)state;
    struct error error = {0};
    error_set(&error, STATUS_FAILED, "inner");
    error_set(&error, STATUS_FAILED, "outer (%s)", error.text);
    assert_string_equal(error.text, "outer (inner)");
}

// Messages contain names from files and networks, so any length must fit; the end is what is lost.
static void long_messages_are_cut(void **state)
{
    (void)state;
    char name[3 * ERROR_TEXT_SIZE];
    memset(name, 'n', sizeof name - 1);
    name[sizeof name - 1] = '\0';

    struct error error = {0};
    error_set(&error, STATUS_INVALID, "%s", name);
    assert_int_equal(strlen(error.text), ERROR_TEXT_SIZE - 1);
    error_wrap(&error, "front");
    assert_int_equal(strlen(error.text), ERROR_TEXT_SIZE - 1);
    assert_memory_equal(error.text, "front: nnn", 10);
    error_wrap(&error, "%s", name);
    assert_int_equal(strlen(error.text), ERROR_TEXT_SIZE - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(set_formats_and_returns_the_status),
        cmocka_unit_test(nobody_has_to_listen),
        cmocka_unit_test(wrapping_puts_the_context_in_front),
        cmocka_unit_test(a_message_can_quote_itself),
        cmocka_unit_test(long_messages_are_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
