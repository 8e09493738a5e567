#include "coordinator/report/page.h"

#include "common/plot/gnuplot.h"
#include "common/plot/picture.h"
#include "coordinator/report/number.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// ---- words ----

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

// Whether some corridor of the picture has a part that no design reaches.
static bool has_beyond(const struct figure *figure)
{
    const struct run_data_search *other = figure->other;
    return !reach_everything(&figure->search->reach, &figure->search->scenario) ||
           (other != NULL && !reach_everything(&other->reach, &other->scenario));
}

int page_top(const struct figure *figure)
{
    return PAGE_TOP + LEGEND_LINE * (1 + (figure->other != NULL) + has_beyond(figure));
}

void page_begin(GString *script, const struct figure *figure, int height)
{
    const struct picture_page page = {
        .what = "Force-deformation corridors, drawn by sobox-report",
        .name = "corridors",
        .stem = figure->stem,
        .width = PAGE_WIDTH,
        .height = height,
    };
    picture_begin(script, &page);
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
    char *string = gnuplot_quoted(text);
    g_string_append_printf(script, "set label %s at screen %.5f, screen %.5f noenhanced %s\n",
                           string, x / PAGE_WIDTH, 1 - y / height, style);
    g_free(string);
}

// A sample of a band, its middle `y` pixels below the top.
static void put_swatch(GString *script, double x, double y, double height, const char *style,
                       const char *fill, const char *line)
{
    g_string_append_printf(script,
                           "set object rectangle front from screen %.5f, screen %.5f "
                           "to screen %.5f, screen %.5f fs %s border lc rgb %s fc rgb %s\n",
                           x / PAGE_WIDTH, 1 - (y + SWATCH_HEIGHT / 2.0) / height,
                           (x + SWATCH_WIDTH) / PAGE_WIDTH, 1 - (y - SWATCH_HEIGHT / 2.0) / height,
                           style, line, fill);
}

static void put_legend_line(GString *script, const struct run_data_search *search,
                            const char *label, const char *colour, double y, double height)
{
    char fill[32], *text = legend_text(search, label);
    g_snprintf(fill, sizeof fill, "%s_fill", colour);
    put_swatch(script, PAGE_EDGE, y, height, "solid", fill, colour);
    put_text(script, text, PAGE_EDGE + SWATCH_WIDTH + 10, y, height, "tc rgb '#404040'");
    g_free(text);
}

// What the hatched parts are.
static void put_beyond_line(GString *script, double y, double height)
{
    char designs[NUMBER_SIZE];
    char *text = g_strdup_printf("hatched: reached by none of %s designs that were simulated",
                                 number_count(REACH_DESIGNS, designs));
    put_swatch(script, PAGE_EDGE, y, height, "transparent " PAGE_HATCH, "outline", "outline");
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
    if (has_beyond(figure))
        put_beyond_line(script, 58 + LEGEND_LINE * (figure->other != NULL ? 2 : 1), height);
    put_text(script, "design space", right, 28, height, "right tc rgb '#404040'");
    put_swatch(script, right - 84 - SWATCH_WIDTH, 28, height, "solid", "space", "outline");
}
