#include "coordinator/report/bars.h"

#include "common/plot/gnuplot.h"
#include "coordinator/report/page.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum {
    LABELLED_MAX = 64,  // variables; with more, names and bounds would run into each other
    ROW_HEIGHT = 30,    // [pixels] of a bar with its gap, where it is labelled
    AREA_HEIGHT = 1920, // [pixels] of all bars where they are not
    NAME_WIDTH = 8,     // [pixels] of a character of a variable's name, about
    NAME_LENGTH_MAX = 24,
};

// ---- which bars ----

static uint32_t find_variable(const struct run_data_search *search, const char *name)
{
    uint32_t i = 0;
    while (i < search->scenario.design_space.count &&
           strcmp(search->scenario.variables[i].name, name) != 0)
        i++;
    return i;
}

static bool variable_shared(const struct run_data_search *other, const char *name)
{
    return find_variable(other, name) < other->scenario.design_space.count;
}

uint32_t bars_shared_variables(const struct run_data_search *search,
                               const struct run_data_search *other)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < search->scenario.design_space.count; i++)
        count += variable_shared(other, search->scenario.variables[i].name);
    return count;
}

// The variables that are drawn, from top to bottom, as indexes of the first run. The caller frees
// the array.
static GArray *choose_rows(const struct figure *figure)
{
    GArray *rows = g_array_new(FALSE, FALSE, sizeof(uint32_t));
    const struct run_data_search *search = figure->search;
    for (uint32_t i = 0; i < search->scenario.design_space.count; i++) {
        if (figure->other == NULL ||
            variable_shared(figure->other, search->scenario.variables[i].name))
            g_array_append_val(rows, i);
    }
    return rows;
}

static const char *row_name(const struct figure *figure, const GArray *rows, uint32_t row)
{
    return figure->search->scenario.variables[g_array_index(rows, uint32_t, row)].name;
}

// ---- data ----

// The place of a value between the first run's bounds of the variable [%].
static double share(const struct box *space, uint32_t variable, double value)
{
    const double width = space->upper[variable] - space->lower[variable];
    return width > 0 ? 100 * (value - space->lower[variable]) / width : 50;
}

// The shares that the bars reach to; another run's may lie outside of this one's design space.
static void share_range(const struct figure *figure, const GArray *rows, double *least,
                        double *greatest)
{
    *least = 0;
    *greatest = 100;
    const struct box *box = figure->other != NULL ? figure->other->box : NULL;
    for (uint32_t row = 0; box != NULL && row < rows->len; row++) {
        const uint32_t variable = g_array_index(rows, uint32_t, row);
        const uint32_t index = find_variable(figure->other, row_name(figure, rows, row));
        const struct box *space = &figure->search->scenario.design_space;
        *least = fmin(*least, share(space, variable, box->lower[index]));
        *greatest = fmax(*greatest, share(space, variable, box->upper[index]));
    }
}

// "$corridor << END": place from the top, share and number of lower and upper.
static void put_block(GString *script, const char *name, const struct figure *figure,
                      const GArray *rows, const struct run_data_search *search,
                      const struct box *box)
{
    const struct box *space = &figure->search->scenario.design_space;
    g_string_append_printf(script, "$%s << END\n", name);
    for (uint32_t row = 0; row < rows->len; row++) {
        const uint32_t variable = g_array_index(rows, uint32_t, row);
        const uint32_t index = find_variable(search, row_name(figure, rows, row));
        char text[4][G_ASCII_DTOSTR_BUF_SIZE];
        g_ascii_formatd(text[0], sizeof text[0], "%.4f", share(space, variable, box->lower[index]));
        g_ascii_formatd(text[1], sizeof text[1], "%.4f", share(space, variable, box->upper[index]));
        g_ascii_formatd(text[2], sizeof text[2], "%.6g", box->lower[index]);
        g_ascii_formatd(text[3], sizeof text[3], "%.6g", box->upper[index]);
        g_string_append_printf(script, "%" PRIu32 " %s %s", row + 1, text[0], text[1]);
        if (!figure->normalise)
            g_string_append_printf(script, " \"%s\" \"%s\"", text[2], text[3]);
        g_string_append_c(script, '\n');
    }
    g_string_append(script, "END\n");
}

static bool compared(const struct figure *figure)
{
    return figure->other != NULL && figure->other->box != NULL;
}

static void put_data(GString *script, const struct figure *figure, const GArray *rows)
{
    const struct run_data_search *search = figure->search;
    g_string_append(script, "# row, lower and upper as share of the design space [%]");
    g_string_append(script, figure->normalise ? "\n" : ", as numbers\n");
    put_block(script, "design", figure, rows, search, &search->scenario.design_space);
    if (search->box != NULL)
        put_block(script, "corridor", figure, rows, search, search->box);
    if (compared(figure))
        put_block(script, "compared", figure, rows, figure->other, figure->other->box);
    g_string_append_c(script, '\n');
}

// ---- the page ----

static bool labelled(const GArray *rows)
{
    return rows->len <= LABELLED_MAX;
}

static int bars_height(const struct figure *figure, const GArray *rows)
{
    const int area = labelled(rows) ? ROW_HEIGHT * (int)(rows->len + 1) : AREA_HEIGHT;
    return page_top(figure) + area + PAGE_BOTTOM;
}

// Names of variables, shortened where they are long, take their room on the left.
static int left_margin(const struct figure *figure, const GArray *rows)
{
    size_t length = 0;
    for (uint32_t row = 0; labelled(rows) && row < rows->len; row++)
        length = MAX(length, strlen(row_name(figure, rows, row)));
    return 40 + NAME_WIDTH * (int)MIN(length, NAME_LENGTH_MAX);
}

static void put_names(GString *script, const struct figure *figure, const GArray *rows)
{
    if (!labelled(rows)) {
        g_string_append(script, "set ylabel 'variable'\n");
        return;
    }
    g_string_append(script, "set ytics noenhanced (");
    for (uint32_t row = 0; row < rows->len; row++) {
        const char *whole = row_name(figure, rows, row);
        char *shortened =
            g_utf8_substring(whole, 0, MIN(NAME_LENGTH_MAX, g_utf8_strlen(whole, -1)));
        char *name = gnuplot_tick(shortened);
        g_string_append_printf(script, "%s%s %" PRIu32, row > 0 ? ", " : "", name, row + 1);
        g_free(name);
        g_free(shortened);
    }
    g_string_append(script, ")\n");
}

static void put_axes(GString *script, const struct figure *figure, const GArray *rows)
{
    const double height = bars_height(figure, rows);
    g_string_append_printf(script,
                           "set lmargin at screen %.5f\nset rmargin at screen %.5f\n"
                           "set tmargin at screen %.5f\nset bmargin at screen %.5f\n",
                           (double)left_margin(figure, rows) / PAGE_WIDTH,
                           1 - (double)PAGE_RIGHT / PAGE_WIDTH, 1 - page_top(figure) / height,
                           PAGE_BOTTOM / height);
    double least, greatest;
    share_range(figure, rows, &least, &greatest);
    const double edge = 0.14 * (greatest - least); // for the numbers beside the bars
    g_string_append_printf(script, "set xrange [%.1f:%.1f]\n", least - edge, greatest + edge);
    if (greatest - least == 100)
        g_string_append(script, "set xtics 0, 20, 100\n");
    g_string_append_printf(script,
                           "set xlabel 'share of the design space [%%]' offset 0, 0.5\n"
                           "set yrange [%" PRIu32 ".7:0.3]\n"
                           "set grid noytics\n",
                           rows->len);
    put_names(script, figure, rows);
}

// A bar a row, between two fractions of the row's height.
static void put_bars(GString *script, const char *block, double from, double to, const char *fill,
                     const char *border)
{
    g_string_append_printf(script,
                           ", \\\n    $%s using 2:1:2:3:($1 + %.2f):($1 + %.2f) with boxxyerror "
                           "fs solid border lc rgb %s fc rgb %s",
                           block, from, to, border, fill);
}

static void put_numbers(GString *script, const char *block, double at, const char *colour)
{
    g_string_append_printf(script,
                           ", \\\n    $%s using 2:($1 + %.2f):4 with labels right noenhanced "
                           "offset char -0.5, 0 tc rgb %s",
                           block, at, colour);
    g_string_append_printf(script,
                           ", \\\n    $%s using 3:($1 + %.2f):5 with labels left noenhanced "
                           "offset char 0.5, 0 tc rgb %s",
                           block, at, colour);
}

// The second run's bars lie in the lower half of their rows.
static void put_plot(GString *script, const struct figure *figure, const GArray *rows)
{
    const double half = compared(figure) ? 0.0 : 0.3;
    const bool numbers = labelled(rows) && !figure->normalise;
    g_string_append(script, "plot NaN");
    put_bars(script, "design", -0.38, 0.38, "space", "outline");
    if (figure->search->box != NULL)
        put_bars(script, "corridor", -0.3, half, "first_fill", "first");
    if (compared(figure))
        put_bars(script, "compared", 0.0, 0.3, "second_fill", "second");
    if (figure->search->box != NULL && numbers)
        put_numbers(script, "corridor", compared(figure) ? -0.17 : 0.0, "first");
    if (compared(figure) && numbers)
        put_numbers(script, "compared", 0.17, "second");
    g_string_append_c(script, '\n');
}

char *bars_script(const struct figure *figure)
{
    GArray *rows = choose_rows(figure);
    GString *script = g_string_new(NULL);
    page_begin(script, figure, bars_height(figure, rows));
    put_data(script, figure, rows);
    page_style(script);
    page_heading(script, figure, bars_height(figure, rows));
    put_axes(script, figure, rows);
    put_plot(script, figure, rows);
    g_string_append(script, "set output\n");
    g_array_unref(rows);
    return g_string_free(script, FALSE);
}
