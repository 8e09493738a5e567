// cmocka needs these first.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/base/log.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { FLOOD = 20 * LOG_NOTES_BURST };

// Writes FLOOD notes; counts the lines that standard error got and keeps the last
// two.
static unsigned lines_of_flood(enum log_level level, char lines[2][256])
{
    FILE *file = tmpfile();
    int before = dup(STDERR_FILENO);
    unsigned count = 0;
    assert_non_null(file);
    log_start("log_test", level);
    dup2(fileno(file), STDERR_FILENO);
    for (unsigned i = 0; i < FLOOD; i++)
        log_note("note %u", i);
    dup2(before, STDERR_FILENO);
    close(before);
    rewind(file);
    while (fgets(lines[count % 2], 256, file) != NULL)
        count++;
    fclose(file);
    return count;
}

// A stranger on the network can cause notes as fast as it sends; a log that fills a disk is one
// more way to stop a run. The first ones are shown, so that nobody misses what happens.
static void flood_of_notes_is_cut(void **state)
{
    (void)state;
    char lines[2][256];
    unsigned count = lines_of_flood(LOG_NORMAL, lines);
    assert_in_range(count, LOG_NOTES_BURST, FLOOD / 2);
}

// Who asks for every decision gets every one.
static void verbose_log_is_complete(void **state)
{
    (void)state;
    char lines[2][256];
    unsigned count = lines_of_flood(LOG_DEBUG, lines);
    // What the test before left out is told in a line of its own.
    assert_in_range(count, FLOOD, FLOOD + 1);
    assert_non_null(strstr(lines[(count - 1) % 2], "log_test: note 1999\n"));
}

static void quiet_log_shows_no_note(void **state)
{
    (void)state;
    char lines[2][256];
    assert_int_equal(lines_of_flood(LOG_QUIET, lines), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flood_of_notes_is_cut),
        cmocka_unit_test(verbose_log_is_complete),
        cmocka_unit_test(quiet_log_shows_no_note),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
