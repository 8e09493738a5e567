#include "common/base/options.h"

#include <assert.h>
#include <string.h>

gboolean options_number(const char *name, const char *value, gpointer user, GError **error)
{
    const struct options_program *program = user;
    const struct options_number *number = program->numbers;
    // GLib gives the name as it was typed: "--threads", or "-t" with its first letter.
    while (strcmp(number->name, name) != 0 && (name[1] == '-' || name[1] != number->name[2])) {
        number++;
        assert(number->name != NULL); // every entry with this callback has its range
    }
    gint64 found;
    if (!g_ascii_string_to_signed(value, 10, number->min, number->max, &found, NULL)) {
        g_set_error(error, G_OPTION_ERROR, G_OPTION_ERROR_BAD_VALUE,
                    "%s: expected a whole number from %ld to %ld, found '%s'", name, number->min,
                    number->max, value);
        return FALSE;
    }
    *(long *)((char *)program->options + number->offset) = (long)found;
    return TRUE;
}

static GOptionContext *context_of(const struct options_program *program,
                                  struct options_common *common)
{
    const GOptionEntry last[] = {
        {"version", 0, 0, G_OPTION_ARG_NONE, &common->version,
         program->version != NULL ? program->version : "Print the version and end", NULL},
        G_OPTION_ENTRY_NULL,
    };
    GOptionContext *context = g_option_context_new(program->argument);
    GOptionGroup *group = g_option_group_new("main", "", "", (gpointer)program, NULL);
    g_option_group_add_entries(group, program->entries);
    g_option_group_add_entries(group, last);
    g_option_context_set_main_group(context, group);
    g_option_context_set_summary(context, program->summary);
    g_option_context_set_description(context, program->description);
    return context;
}

static enum status take_argument(const struct options_program *program, int argc, char **argv,
                                 struct options_common *common, struct error *error)
{
    const int most = program->argument != NULL ? 1 : 0;
    if (argc - 1 > most && most == 0)
        return error_set(error, STATUS_INVALID,
                         "unexpected '%s': expected options only (see --help)", argv[1]);
    if (argc - 1 > most)
        return error_set(error, STATUS_INVALID, "%s: one %s is expected, this is a second", argv[2],
                         program->argument);
    common->argument = argc > 1 ? g_strdup(argv[1]) : NULL;
    return STATUS_OK;
}

enum status options_read(const struct options_program *program, int argc, char **argv,
                         struct options_common *common, struct error *error)
{
    *common = (struct options_common){0};
    GOptionContext *context = context_of(program, common);
    g_autoptr(GError) reason = NULL;
    enum status status = STATUS_OK;
    if (!g_option_context_parse(context, &argc, &argv, &reason))
        status = error_set(error, STATUS_INVALID, "%s (see --help)", reason->message);
    else
        status = take_argument(program, argc, argv, common, error);
    g_option_context_free(context);
    return status;
}

enum log_level options_log_level(gboolean quiet, gboolean verbose)
{
    return quiet ? LOG_QUIET : verbose ? LOG_DEBUG : LOG_NORMAL;
}
