#include "common/plot/gnuplot.h"

#include "common/base/plain.h"

#include <gio/gio.h>
#include <stdbool.h>
#include <string.h>

// What gnuplot said, on one line.
static char *complaint(GBytes *said)
{
    gsize size;
    const char *bytes = g_bytes_get_data(said, &size);
    char *text = g_utf8_make_valid(bytes != NULL ? bytes : "", (gssize)size);
    g_strstrip(g_strdelimit(text, "\r\n\t", ' '));
    return text;
}

static enum status start_failure(GError *failure, struct error *error)
{
    enum status status;
    if (g_error_matches(failure, G_SPAWN_ERROR, G_SPAWN_ERROR_NOENT))
        status = error_set(error, STATUS_FAILED,
                           "gnuplot is not installed, so no picture was drawn; install it with: "
                           "apt-get install gnuplot-nox");
    else
        status = error_set(error, STATUS_FAILED, "gnuplot: %s", failure->message);
    g_error_free(failure);
    return status;
}

// The picture comes through a pipe: nobody finds half of one under its name, and gnuplot needs no
// permission to write anywhere.
enum status gnuplot_run(const char *script_path, const char *format, GBytes **picture,
                        struct error *error)
{
    *picture = NULL;
    char *path = g_canonicalize_filename(script_path, NULL); // never taken for an option
    char *settings = g_strdup_printf("format = '%s'; output = ''", format);
    GError *failure = NULL;
    // -d: the user's own gnuplot settings are for the user's own plots.
    GSubprocess *gnuplot =
        g_subprocess_new(G_SUBPROCESS_FLAGS_STDOUT_PIPE | G_SUBPROCESS_FLAGS_STDERR_PIPE, &failure,
                         "gnuplot", "-d", "-e", settings, path, NULL);
    g_free(settings);
    g_free(path);
    if (gnuplot == NULL)
        return start_failure(failure, error);

    GBytes *said = NULL;
    enum status status = STATUS_OK;
    if (!g_subprocess_communicate(gnuplot, NULL, NULL, picture, &said, &failure)) {
        status = start_failure(failure, error);
    } else if (!g_subprocess_get_successful(gnuplot) || g_bytes_get_size(*picture) == 0) {
        char *text = complaint(said);
        status = error_set(error, STATUS_FAILED, "gnuplot failed: %s",
                           text[0] != '\0' ? text : "it drew nothing");
        g_free(text);
        g_clear_pointer(picture, g_bytes_unref);
    }
    g_clear_pointer(&said, g_bytes_unref);
    g_object_unref(gnuplot);
    return status;
}

// A gnuplot string that is only ever text. Names may come from anywhere, so every ASCII character
// that could mean something to gnuplot (quotes, backquotes, backslashes, '@', '$', ...) is written
// as its octal code, and a digit behind one too: gnuplot reads up to four digits, "\0432" for "#2"
// as one character that no SVG may hold. Doubling quotes in a single-quoted string would not do:
// gnuplot 5.4 takes a string that begins with a quote for an empty one.
char *gnuplot_quoted(const char *text)
{
    char *plain = plain_text(text);
    GString *string = g_string_new("\"");
    bool coded = false; // the character before
    for (const char *c = plain; *c != '\0'; c++) {
        coded = (*c & 0x80) == 0 && !g_ascii_isalpha(*c) && strchr(" .,:;-_%()+=", *c) == NULL &&
                (coded || !g_ascii_isdigit(*c));
        if (!coded)
            g_string_append_c(string, *c);
        else
            g_string_append_printf(string, "\\%03o", (unsigned char)*c);
    }
    g_string_append_c(string, '"');
    g_free(plain);
    return g_string_free(string, FALSE);
}

char *gnuplot_tick(const char *text)
{
    char **parts = g_strsplit(text, "%", -1);
    char *doubled = g_strjoinv("%%", parts), *string = gnuplot_quoted(doubled);
    g_free(doubled);
    g_strfreev(parts);
    return string;
}
