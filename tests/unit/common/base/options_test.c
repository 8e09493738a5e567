#include "common/base/options.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

struct options {
    char *name;
    long threads;
    gboolean quiet;
};

static struct options options;

// Reads a command line of words separated by blanks.
static enum status read_line(const char *line, const char *argument, struct options_common *common,
                             struct error *error)
{
    static const struct options_number numbers[] = {
        {"--threads", offsetof(struct options, threads), 1, 16}, {0}};
    const GOptionEntry entries[] = {
        {"name", 'n', 0, G_OPTION_ARG_FILENAME, &options.name, "A name", "NAME"},
        {"threads", 't', 0, G_OPTION_ARG_CALLBACK, options_number, "Threads", "N"},
        {"quiet", 'q', 0, G_OPTION_ARG_NONE, &options.quiet, "Less", NULL},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_program program = {
        .argument = argument, .entries = entries, .numbers = numbers, .options = &options};
    options = (struct options){.threads = 7};
    g_auto(GStrv) words = g_strsplit(line, " ", -1);
    g_autofree char **argv = g_memdup2(words, (g_strv_length(words) + 1) * sizeof *words);
    *error = (struct error){0};
    return options_read(&program, (int)g_strv_length(words), argv, common, error);
}

static void assert_refused(const char *line, const char *argument, const char *complaint)
{
    struct options_common common;
    struct error error;
    assert_int_equal(read_line(line, argument, &common, &error), STATUS_INVALID);
    if (strncmp(error.text, complaint, strlen(complaint)) != 0)
        fail_msg("expected \"%s...\", found \"%s\"", complaint, error.text);
    assert_null(common.argument);
    g_free(options.name);
}

// Options, numbers by their long and short names, and the argument in any order.
static void command_line_fills_the_options(void **state)
{
    (void)state;
    struct options_common common;
    struct error error;
    assert_int_equal(read_line("p --threads=3 file -q -n x", "FILE", &common, &error), STATUS_OK);
    assert_int_equal(options.threads, 3);
    assert_true(options.quiet);
    assert_string_equal(options.name, "x");
    assert_string_equal(common.argument, "file");
    assert_false(common.version);
    g_free(common.argument);
    g_free(options.name);
    assert_int_equal(read_line("p -t 16 --version", NULL, &common, &error), STATUS_OK);
    assert_int_equal(options.threads, 16);
    assert_null(common.argument);
    assert_true(common.version);
    assert_int_equal(read_line("p", "FILE", &common, &error), STATUS_OK);
    assert_int_equal(options.threads, 7);
}

// What is wrong is named, with what would be right or where to look.
static void wrong_usage_is_explained(void **state)
{
    (void)state;
    assert_refused("p --threads=0", NULL,
                   "--threads: expected a whole number from 1 to 16, found '0'");
    assert_refused("p -t 1x", NULL, "-t: expected a whole number from 1 to 16, found '1x'");
    assert_refused("p --weight", NULL, "Unknown option --weight (see --help)");
    assert_refused("p file", NULL, "unexpected 'file': expected options only");
    assert_refused("p a.yaml b.yaml", "FILE", "b.yaml: one FILE is expected, this is a second");
}

static void quiet_and_verbose_set_the_level(void **state)
{
    (void)state;
    assert_int_equal(options_log_level(FALSE, FALSE), LOG_NORMAL);
    assert_int_equal(options_log_level(TRUE, TRUE), LOG_QUIET);
    assert_int_equal(options_log_level(FALSE, TRUE), LOG_DEBUG);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(command_line_fills_the_options),
        cmocka_unit_test(wrong_usage_is_explained),
        cmocka_unit_test(quiet_and_verbose_set_the_level),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
