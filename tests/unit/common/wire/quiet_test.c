#include "messages.h"

#include "common/wire/quiet.h"

#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

// What a library prints is kept for our own message, on one line, and standard error is what it was
// afterwards.
static void printed_lines_are_kept_aside(void **state)
{
    (void)state;
    struct quiet quiet;
    struct stat before, after;
    assert_int_equal(fstat(STDERR_FILENO, &before), 0);
    quiet_start(&quiet);
    fprintf(stderr, "No route to %s\n", "nowhere");
    assert_true(write(STDERR_FILENO, "help\n", 5) == 5);
    quiet_end(&quiet);
    assert_string_equal(quiet.text, "No route to nowhere help ");
    assert_int_equal(fstat(STDERR_FILENO, &after), 0);
    assert_int_equal(before.st_ino, after.st_ino);
    assert_int_equal(before.st_dev, after.st_dev);
}

// More than is kept is cut, and neither overruns nor blocks.
static void long_output_is_cut(void **state)
{
    (void)state;
    struct quiet quiet;
    quiet_start(&quiet);
    for (int i = 0; i < 100000; i++)
        fputs("0123456789", stderr);
    quiet_end(&quiet);
    assert_int_equal(strlen(quiet.text), QUIET_TEXT_SIZE - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(printed_lines_are_kept_aside),
        cmocka_unit_test(long_output_is_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
