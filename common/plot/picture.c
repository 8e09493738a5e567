#include "common/plot/picture.h"

#include "common/base/whole_file.h"
#include "common/plot/gnuplot.h"

#include <assert.h>
#include <glib/gstdio.h>
#include <string.h>
#include <unistd.h>

const char *picture_format_name(enum picture_format format)
{
    static const char *const NAMES[] = {
        [PICTURE_SVG] = "svg", [PICTURE_PNG] = "png", [PICTURE_PDF] = "pdf"};
    assert(format < G_N_ELEMENTS(NAMES));
    return NAMES[format];
}

bool picture_format_of(const char *path, enum picture_format *format)
{
    for (int i = PICTURE_SVG; i <= PICTURE_PDF; i++) {
        char ending[8];
        g_snprintf(ending, sizeof ending, ".%s", picture_format_name((enum picture_format)i));
        if (g_str_has_suffix(path, ending)) {
            *format = (enum picture_format)i;
            return true;
        }
    }
    return false;
}

void picture_begin(GString *script, const struct picture_page *page)
{
    char *stem = gnuplot_quoted(page->stem);
    g_string_append_printf(
        script,
        "# %s. To change the picture, edit this\n"
        "# script and run, in its folder,\n"
        "#     gnuplot SCRIPT                      for SVG\n"
        "#     gnuplot -e \"format='png'\" SCRIPT    for PNG or, with 'pdf', PDF\n"
        "reset\n"
        "set encoding utf8\n"
        "if (!exists('format')) format = 'svg'\n"
        "if (!exists('output')) output = %s . '.' . format\n"
        "width = %d.0 # [pixels]\n"
        "height = %d.0\n"
        "if (format eq 'png') {\n"
        "    points = 9.0\n"
        "    set terminal pngcairo size 2 * width, 2 * height font 'sans-serif,9' \\\n"
        "        fontscale 2 linewidth 2 pointscale 2\n"
        "} else { if (format eq 'pdf') {\n"
        "    points = 9.0\n"
        "    set terminal pdfcairo size width / 96, height / 96 font 'sans-serif,9' \\\n"
        "        fontscale 1 linewidth 1.5 pointscale 0.75\n"
        "} else {\n"
        "    points = 12.0 # SVG's are pixels\n"
        "    set terminal svg size width, height name '%s' \\\n"
        "        font 'sans-serif,12' background '#ffffff'\n"
        "}}\n"
        "heading = sprintf('sans-serif,%%.1f', 1.4 * points)\n"
        "if (output ne '') set output output\n\n",
        page->what, stem, page->width, page->height, page->name);
    g_free(stem);
}

// The path without its ending: "run/corridors" of "run/corridors.svg".
static char *path_stem(const char *path)
{
    char *stem = g_strdup(path);
    char *dot = strrchr(stem, '.'), *slash = strrchr(stem, G_DIR_SEPARATOR);
    if (dot != NULL && dot > (slash != NULL ? slash + 1 : stem))
        *dot = '\0';
    return stem;
}

char *picture_stem(const char *output)
{
    char *path = path_stem(output), *stem = g_path_get_basename(path);
    g_free(path);
    return stem;
}

enum status picture_write(const char *script, const char *output, enum picture_format format,
                          struct error *error)
{
    char *path = path_stem(output), *script_path = g_strconcat(path, ".gp", NULL);
    GBytes *picture = NULL;
    enum status status = whole_file_write(script_path, script, strlen(script), error);
    if (status == STATUS_OK)
        status = gnuplot_run(script_path, picture_format_name(format), &picture, error);
    if (status == STATUS_OK)
        status = whole_file_write(output, g_bytes_get_data(picture, NULL),
                                  g_bytes_get_size(picture), error);
    g_clear_pointer(&picture, g_bytes_unref);
    g_free(script_path);
    g_free(path);
    return status;
}

// gnuplot takes a script from a file only where it may also be run by hand; this one goes again.
enum status picture_inline(const char *script, char **svg, struct error *error)
{
    GError *failure = NULL;
    char *path = NULL;
    *svg = NULL;
    const int file = g_file_open_tmp("sobox-picture-XXXXXX.gp", &path, &failure);
    if (file < 0) {
        error_set(error, STATUS_IO, "%s", failure->message);
        g_error_free(failure);
        return STATUS_IO;
    }
    close(file);
    GBytes *picture = NULL;
    enum status status = whole_file_write(path, script, strlen(script), error);
    if (status == STATUS_OK)
        status = gnuplot_run(path, "svg", &picture, error);
    if (status == STATUS_OK) {
        char *text = g_strndup(g_bytes_get_data(picture, NULL), g_bytes_get_size(picture));
        const char *element = strstr(text, "<svg");
        *svg = g_strdup(element != NULL ? element : text);
        g_free(text);
    }
    g_clear_pointer(&picture, g_bytes_unref);
    g_unlink(path);
    g_free(path);
    return status;
}
