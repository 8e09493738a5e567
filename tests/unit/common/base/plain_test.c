#include "common/base/plain.h"

#include "common/base/log.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

// A name from elsewhere must not move the cursor, end a line, or hide what stands behind it; what
// is not UTF-8 costs its own bytes only, so that a file of another alphabet can still be named.
static void text_loses_what_a_terminal_obeys(void **state)
{
    (void)state;
    static const struct {
        const char *text, *plain;
    } texts[] = {
        {"a\x1b[2J\nb \xc3\xa9", "a?[2J?b \xc3\xa9"}, // C0
        {"\xc2\x9b"
         "31m",
         "?31m"},                          // C1 as UTF-8
        {"M\xfcller.yaml", "M?ller.yaml"}, // Latin-1
        {"cut \xe2\x82", "cut ??"},        // half a character
        {"\xe2\x80\xaetxt", "?txt"},       // right to left from here on
        {"\x7f", "?"},
        {"", ""},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(texts); i++) {
        char *plain = plain_text(texts[i].text);
        assert_string_equal(plain, texts[i].plain);
        g_free(plain);
    }
}

// Every road to standard error takes them out.
static void log_shows_no_control_characters(void **state)
{
    (void)state;
    static const char owned[] = "\x1b]0;owned\a";
    char text[4096] = "";
    FILE *file = tmpfile();
    int before = dup(STDERR_FILENO);
    assert_non_null(file);
    log_start("plain_test", LOG_DEBUG);
    dup2(fileno(file), STDERR_FILENO);
    struct error error;
    error_set(&error, STATUS_INVALID, "failure %s", owned);
    log_failure(&error);
    error_set(&error, STATUS_IO, "failure %s", owned);
    log_failure(&error);
    log_error("error %s", owned);
    log_note("note %s", owned);
    log_debug("debug %s", owned);
    log_warning(owned, owned);
    log_progress("progress %s", owned);
    log_progress_end();
    dup2(before, STDERR_FILENO);
    close(before);
    rewind(file);
    const size_t size = fread(text, 1, sizeof text - 1, file);
    fclose(file);
    uint32_t shown = 0;
    for (const char *at = text; (at = strstr(at, "?]0;owned?")) != NULL; at++)
        shown++;
    assert_int_equal(shown, 8);
    for (size_t i = 0; i < size; i++)
        assert_true(text[i] == '\n' || !g_ascii_iscntrl(text[i]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(text_loses_what_a_terminal_obeys),
        cmocka_unit_test(log_shows_no_control_characters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
