#include "coordinator/report/page.h"

#include "coordinator/report/number.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// ---- words ----

// A gnuplot string that is only ever text. Names may come from anywhere, so every ASCII character
// that could mean something to gnuplot (quotes, backquotes, backslashes, '@', '$', ...) is written
// as its octal code. Doubling quotes in a single-quoted string would not do: gnuplot 5.4 takes a
// string that begins with a quote for an empty one.
char *page_quoted(const char *text)
{
    char *plain = report_name_plain(text);
    GString *string = g_string_new("\"");
    for (const char *c = plain; *c != '\0'; c++) {
        if ((*c & 0x80) != 0 || g_ascii_isalnum(*c) || strchr(" .,:;-_%()+=", *c) != NULL)
            g_string_append_c(string, *c);
        else
            g_string_append_printf(string, "\\%03o", (unsigned char)*c);
    }
    g_string_append_c(string, '"');
    g_free(plain);
    return g_string_free(string, FALSE);
}

static char *title_text(const struct figure *figure)
{
    const char *name = figure->search->name;
    if (figure->other == NULL || strcmp(name, figure->other->name) == 0)
        return g_strdup(name);
    return g_strdup_printf("%s and %s", name, figure->other->name);
}

static void put_purity(GString *text, const struct run_data_search *search)
{
    if (run_data_found_nothing(search))
        g_string_append(text, "no good design found");
    else if (!search->record.finished)
        g_string_append_printf(text, "not finished (%s)", search->status);
    else if (search->record.purity_samples == 0)
        g_string_append(text, "purity not certified");
    else
        g_string_append_printf(text, "purity at least %.4f with 95 %% confidence",
                               floor(search->record.purity_lower95 * 1e4) * 1e-4);
}

// What the legend says of one corridor.
static char *legend_text(const struct run_data_search *search, const char *label)
{
    char designs[NUMBER_SIZE];
    GString *text = g_string_new(label);
    g_string_append(text, "   ·   ");
    put_purity(text, search);
    g_string_append_printf(text, "   ·   %s designs simulated",
                           number_count(search->evaluations, designs));
    return g_string_free(text, FALSE);
}

// ---- the page ----

int page_top(const struct figure *figure)
{
    return PAGE_TOP + LEGEND_LINE * (figure->other != NULL ? 2 : 1);
}

void page_begin(GString *script, const struct figure *figure, int height)
{
    char *stem = page_quoted(figure->stem);
    g_string_append_printf(
        script,
        "# Force-deformation corridors, drawn by sobox-report. To change the picture, edit this\n"
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
        "    set terminal svg size width, height name 'corridors' \\\n"
        "        font 'sans-serif,12' background '#ffffff'\n"
        "}}\n"
        "heading = sprintf('sans-serif,%%.1f', 1.4 * points)\n"
        "if (output ne '') set output output\n\n",
        stem, PAGE_WIDTH, height);
    g_free(stem);
}

// Okabe and Ito's colours stay apart for colour-blind readers: blue, and vermillion over it.
void page_style(GString *script)
{
    g_string_append(script, "space = '#efefef'    # fill of the design space\n"
                            "outline = '#8c8c8c'\n"
                            "first = '#0072b2'\n"
                            "first_fill = '#a6cee6'\n"
                            "second = '#d55e00'\n"
                            "second_fill = '#aad55e00' # seen through\n"
                            "set border 3 lc rgb '#404040'\n"
                            "set tics nomirror out scale 0.6\n"
                            "set format '%h'\n"
                            "set grid front lt 1 lc rgb '#e6000000' lw 0.8\n"
                            "set autoscale fix\n"
                            "set offsets 0, 0, graph 0.05, 0\n"
                            "set style fill solid 1 noborder\n"
                            "unset key\n\n");
}

// A text at a place in pixels from the page's upper left corner.
static void put_text(GString *script, const char *text, double x, double y, double height,
                     const char *style)
{
    char *string = page_quoted(text);
    g_string_append_printf(script, "set label %s at screen %.5f, screen %.5f noenhanced %s\n",
                           string, x / PAGE_WIDTH, 1 - y / height, style);
    g_free(string);
}

// A sample of a band, its middle `y` pixels below the top.
static void put_swatch(GString *script, double x, double y, double height, const char *fill,
                       const char *line)
{
    g_string_append_printf(script,
                           "set object rectangle front from screen %.5f, screen %.5f "
                           "to screen %.5f, screen %.5f fs solid border lc rgb %s fc rgb %s\n",
                           x / PAGE_WIDTH, 1 - (y + SWATCH_HEIGHT / 2.0) / height,
                           (x + SWATCH_WIDTH) / PAGE_WIDTH, 1 - (y - SWATCH_HEIGHT / 2.0) / height,
                           line, fill);
}

static void put_legend_line(GString *script, const struct run_data_search *search,
                            const char *label, const char *colour, double y, double height)
{
    char fill[32], *text = legend_text(search, label);
    g_snprintf(fill, sizeof fill, "%s_fill", colour);
    put_swatch(script, PAGE_EDGE, y, height, fill, colour);
    put_text(script, text, PAGE_EDGE + SWATCH_WIDTH + 10, y, height, "tc rgb '#404040'");
    g_free(text);
}

// Title and legend stand once on the page: they belong to the first panel. gnuplot's own legend
// would break its lines and run into the panels when names are long.
void page_heading(GString *script, const struct figure *figure, int page_height)
{
    double height = page_height, right = PAGE_WIDTH - PAGE_RIGHT;
    char *title = title_text(figure);
    put_text(script, title, PAGE_EDGE, 28, height, "font heading");
    g_free(title);
    put_legend_line(script, figure->search, figure->search_label, "first", 58, height);
    if (figure->other != NULL)
        put_legend_line(script, figure->other, figure->other_label, "second", 58 + LEGEND_LINE,
                        height);
    put_text(script, "design space", right, 28, height, "right tc rgb '#404040'");
    put_swatch(script, right - 84 - SWATCH_WIDTH, 28, height, "space", "outline");
}
