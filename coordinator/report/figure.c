#include "coordinator/report/figure.h"
#include "coordinator/report/number.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// The interval of values that an axis maps to 0..1 when normalised.
struct range {
    double least, greatest;
};

static const struct range EMPTY_RANGE = {INFINITY, -INFINITY};

static void range_take(struct range *range, double value)
{
    range->least = fmin(range->least, value);
    range->greatest = fmax(range->greatest, value);
}

static double range_share(const struct range *range, double value)
{
    double span = range->greatest - range->least;
    return span > 0 ? (value - range->least) / span : 0;
}

// ---- what belongs together ----

static uint32_t spring_find(const struct run_search *search, const char *name)
{
    uint32_t i = 0;
    while (i < search->scenario.spring_count && strcmp(search->scenario.springs[i].name, name) != 0)
        i++;
    return i;
}

static bool spring_shared(const struct run_search *other, const char *name)
{
    return other != NULL && spring_find(other, name) < other->scenario.spring_count;
}

uint32_t figure_shared_springs(const struct run_search *search, const struct run_search *other)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < search->scenario.spring_count; i++)
        count += spring_shared(other, search->scenario.springs[i].name);
    return count;
}

// All forces of one direction share their range, so that springs compare (thesis 8.5.3: force
// normalised to the highest of all groups).
static void range_take_forces(struct range *range, const struct run_search *search,
                              enum scenario_direction direction)
{
    for (uint32_t i = 0; search != NULL && i < search->scenario.design_space.count; i++)
        if (search->scenario.variables[i].direction == direction) {
            range_take(range, search->scenario.design_space.lower[i]);
            range_take(range, search->scenario.design_space.upper[i]);
        }
}

static struct range force_range(const struct figure *figure, enum scenario_direction direction)
{
    struct range range = EMPTY_RANGE;
    range_take_forces(&range, figure->search, direction);
    range_take_forces(&range, figure->other, direction);
    return range;
}

// Each spring has a range of deformation of its own (thesis 8.5.3: deformation per group).
static struct range deformation_range(const struct figure *figure, const char *spring_name)
{
    struct range range = EMPTY_RANGE;
    const struct run_search *both[] = {figure->search, figure->other};
    for (size_t r = 0; r < G_N_ELEMENTS(both); r++) {
        if (!spring_shared(both[r], spring_name))
            continue;
        const struct scenario_spring *spring =
            &both[r]->scenario.springs[spring_find(both[r], spring_name)];
        for (uint32_t k = 0; k < spring->point_count; k++)
            range_take(&range, spring->deformation[k]);
    }
    return range;
}

// ---- data ----

struct panel {
    uint32_t row; // index of the spring in the first run
    const char *spring_name;
    enum scenario_direction direction;
    struct range deformation, force;
};

static double force_value(const struct figure *figure, const struct panel *panel, double newton)
{
    return figure->normalise ? range_share(&panel->force, newton) : newton * 1e-3;
}

static double deformation_value(const struct figure *figure, const struct panel *panel,
                                double metre)
{
    return figure->normalise ? range_share(&panel->deformation, metre) : metre;
}

// "$corridor_1_x << END": deformation, lower and upper of a box of one panel.
static void put_block(GString *script, const char *name, const struct figure *figure,
                      const struct panel *panel, const struct run_search *search,
                      const struct box *box)
{
    uint32_t index = spring_find(search, panel->spring_name);
    const struct scenario_spring *spring = &search->scenario.springs[index];
    g_string_append_printf(script, "$%s_%" PRIu32 "_%s << END\n", name, panel->row + 1,
                           scenario_direction_name(panel->direction));
    for (uint32_t k = 0; k < spring->point_count; k++) {
        uint32_t variable = run_search_variable(search, index, panel->direction, k);
        char deformation[NUMBER_SIZE], lower[NUMBER_SIZE], upper[NUMBER_SIZE];
        number_exact(deformation_value(figure, panel, spring->deformation[k]), deformation);
        number_exact(force_value(figure, panel, box->lower[variable]), lower);
        number_exact(force_value(figure, panel, box->upper[variable]), upper);
        g_string_append_printf(script, "%s %s %s\n", deformation, lower, upper);
    }
    g_string_append(script, "END\n");
}

static bool panel_compared(const struct figure *figure, const struct panel *panel)
{
    return spring_shared(figure->other, panel->spring_name) && figure->other->box != NULL;
}

static void put_data(GString *script, const struct figure *figure, const struct panel *panel)
{
    const struct run_search *search = figure->search;
    put_block(script, "design", figure, panel, search, &search->scenario.design_space);
    if (search->box != NULL)
        put_block(script, "corridor", figure, panel, search, search->box);
    if (panel_compared(figure, panel))
        put_block(script, "compared", figure, panel, figure->other, figure->other->box);
}

// ---- words ----

// A gnuplot string that is only ever text: single quotes switch off escapes, backquotes and macros,
// and a quote inside is doubled. Names may come from anywhere.
static char *quoted(const char *text)
{
    char *plain = name_plain(text);
    GString *string = g_string_new("'");
    for (const char *c = plain; *c != '\0'; c++) {
        if (*c == '\'')
            g_string_append_c(string, '\'');
        g_string_append_c(string, *c);
    }
    g_string_append_c(string, '\'');
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

static void put_purity(GString *text, const struct run_search *search)
{
    if (run_search_found_nothing(search))
        g_string_append(text, "no good design found");
    else if (!search->record.finished)
        g_string_append_printf(text, "not finished (%s)", search->status);
    else if (search->record.purity_samples == 0)
        g_string_append(text, "purity not certified");
    else
        g_string_append_printf(text, "purity at least %.4f with 95 %% confidence",
                               floor(search->record.purity_lower95 * 1e4) * 1e-4);
}

static char *subtitle_text(const struct figure *figure)
{
    GString *text = g_string_new(NULL);
    if (figure->other == NULL) {
        char designs[NUMBER_SIZE];
        g_string_append_printf(text, "response: %s   ·   ",
                               scenario_response_name(figure->search->scenario.response));
        put_purity(text, figure->search);
        g_string_append_printf(text, "   ·   %s designs simulated",
                               number_count(figure->search->evaluations, designs));
    } else {
        g_string_append_printf(text, "%s: ", figure->search_label);
        put_purity(text, figure->search);
        g_string_append_printf(text, "   ·   %s: ", figure->other_label);
        put_purity(text, figure->other);
    }
    return g_string_free(text, FALSE);
}

// ---- the page ----

// All lengths in pixels of the SVG, from the edge of the page.
enum {
    PAGE_WIDTH = 960,
    PAGE_LEFT = 76,
    PAGE_RIGHT = 22,
    PAGE_TOP = 124, // title, subtitle, legend and the title of the first row
    PAGE_BOTTOM = 56,
    COLUMN_GAP = 90, // the right panels' axis labels
    ROW_GAP = 78,    // axis label and title of the next row
};

// Many springs make a long page; flatter panels keep it readable as a whole.
static int panel_height(uint32_t rows)
{
    return rows <= 1 ? 270 : rows <= 3 ? 220 : rows <= 8 ? 170 : 140;
}

static int page_height(uint32_t rows)
{
    return PAGE_TOP + PAGE_BOTTOM + (int)rows * panel_height(rows) + ((int)rows - 1) * ROW_GAP;
}

static void put_terminal(GString *script, const struct figure *figure, uint32_t rows)
{
    char *stem = quoted(figure->stem);
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
        "    set terminal pngcairo size 2 * width, 2 * height font 'sans-serif,12' \\\n"
        "        fontscale 2 linewidth 2 pointscale 2\n"
        "} else { if (format eq 'pdf') {\n"
        "    set terminal pdfcairo size width / 96, height / 96 font 'sans-serif,9' \\\n"
        "        fontscale 1 linewidth 1.5 pointscale 0.75\n"
        "} else {\n"
        "    set terminal svg size width, height font 'sans-serif,12' background '#ffffff'\n"
        "}}\n"
        "set output output\n\n",
        stem, PAGE_WIDTH, page_height(rows));
    g_free(stem);
}

// Okabe and Ito's colours stay apart for colour-blind readers: blue, and vermillion over it.
static void put_style(GString *script)
{
    g_string_append(script, "space = '#ececec'    # fill of the design space\n"
                            "outline = '#9a9a9a'\n"
                            "first = '#0072b2'\n"
                            "second = '#d55e00'\n"
                            "set border 3 lc rgb '#404040'\n"
                            "set tics nomirror out scale 0.6\n"
                            "set grid lc rgb '#dddddd' lw 0.6\n"
                            "set grid back\n"
                            "set xtics autofreq\n"
                            "set style fill solid 1 noborder\n\n");
}

static void put_layout(GString *script, uint32_t rows)
{
    double height = page_height(rows);
    g_string_append_printf(script,
                           "set multiplot layout %" PRIu32 ",2 \\\n"
                           "    margins screen %.5f, %.5f, %.5f, %.5f \\\n"
                           "    spacing screen %.5f, %.5f\n",
                           rows, (double)PAGE_LEFT / PAGE_WIDTH,
                           1 - (double)PAGE_RIGHT / PAGE_WIDTH, PAGE_BOTTOM / height,
                           1 - PAGE_TOP / height, (double)COLUMN_GAP / PAGE_WIDTH,
                           ROW_GAP / height);
}

// Title, subtitle and legend stand once on the page: they belong to the first panel.
static void put_heading(GString *script, const struct figure *figure, uint32_t rows)
{
    double height = page_height(rows), left = 24.0 / PAGE_WIDTH;
    char *text = title_text(figure), *title = quoted(text);
    g_string_append_printf(script,
                           "set label 1 %s at screen %.5f, screen %.5f left noenhanced "
                           "font ':Bold,15'\n",
                           title, left, 1 - 26 / height);
    g_free(title);
    g_free(text);
    text = subtitle_text(figure);
    title = quoted(text);
    g_string_append_printf(script,
                           "set label 2 %s at screen %.5f, screen %.5f left noenhanced "
                           "textcolor rgb '#404040'\n",
                           title, left, 1 - 51 / height);
    g_free(title);
    g_free(text);
    g_string_append_printf(script,
                           "set key at screen %.5f, screen %.5f left top horizontal Left reverse "
                           "samplen 2 width 1 noenhanced\n",
                           16.0 / PAGE_WIDTH, 1 - 62 / height);
}

static void put_axes(GString *script, const struct figure *figure, const struct panel *panel)
{
    const char *direction = scenario_direction_name(panel->direction);
    char *text = g_strdup_printf("%s, %s", panel->spring_name,
                                 panel->direction == SCENARIO_DIRECTION_X ? "axial" : "lateral");
    char *title = quoted(text);
    g_string_append_printf(script, "set title %s noenhanced font ':Bold,12' offset 0, -0.4\n",
                           title);
    if (figure->normalise)
        g_string_append_printf(script,
                               "set xlabel 'deformation, normalised'\n"
                               "set ylabel 'F_%s, normalised' enhanced\n",
                               direction);
    else
        g_string_append_printf(script,
                               "set xlabel 'deformation [m]'\n"
                               "set ylabel 'F_%s [kN]' enhanced\n",
                               direction);
    g_free(title);
    g_free(text);
}

// A band with its two bounds drawn as lines; points mark where the forces are free.
static void put_band(GString *script, const char *block, const char *colour, const char *label)
{
    char *title = quoted(label);
    g_string_append_printf(
        script,
        ", \\\n"
        "    %s using 1:2:3 with filledcurves fs transparent solid 0.3 "
        "lc rgb %s title %s, \\\n"
        "    %s using 1:2 with linespoints lc rgb %s lw 2 pt 7 ps 0.4 notitle, \\\n"
        "    %s using 1:3 with linespoints lc rgb %s lw 2 pt 7 ps 0.4 notitle",
        block, colour, title, block, colour, block, colour);
    g_free(title);
}

static void put_panel(GString *script, const struct figure *figure, const struct panel *panel)
{
    char suffix[32], block[64];
    g_snprintf(suffix, sizeof suffix, "_%" PRIu32 "_%s", panel->row + 1,
               scenario_direction_name(panel->direction));
    put_axes(script, figure, panel);
    g_string_append_printf(
        script,
        "plot [*:*] [*<0:0<*] $design%s using 1:2:3 with filledcurves lc rgb space"
        " title 'design space', \\\n"
        "    $design%s using 1:2 with lines lc rgb outline notitle, \\\n"
        "    $design%s using 1:3 with lines lc rgb outline notitle",
        suffix, suffix, suffix);
    if (figure->search->box != NULL) {
        g_snprintf(block, sizeof block, "$corridor%s", suffix);
        put_band(script, block, "first", figure->search_label);
    }
    if (panel_compared(figure, panel)) {
        g_snprintf(block, sizeof block, "$compared%s", suffix);
        put_band(script, block, "second", figure->other_label);
    }
    g_string_append(script, "\n");
}

char *figure_script(const struct figure *figure)
{
    uint32_t rows = 0, springs = figure->search->scenario.spring_count;
    struct panel *panels = g_new0(struct panel, SCENARIO_DIRECTION_COUNT * springs);
    for (uint32_t i = 0; i < springs; i++) {
        const char *name = figure->search->scenario.springs[i].name;
        if (figure->other != NULL && !spring_shared(figure->other, name))
            continue; // only what both have can be compared
        for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
            panels[SCENARIO_DIRECTION_COUNT * rows + (uint32_t)d] =
                (struct panel){.row = i,
                               .spring_name = name,
                               .direction = (enum scenario_direction)d,
                               .deformation = deformation_range(figure, name),
                               .force = force_range(figure, (enum scenario_direction)d)};
        rows++;
    }

    GString *script = g_string_new(NULL);
    put_terminal(script, figure, rows);
    g_string_append(script, "# deformation, lower, upper\n");
    for (uint32_t i = 0; i < SCENARIO_DIRECTION_COUNT * rows; i++)
        put_data(script, figure, &panels[i]);
    g_string_append_c(script, '\n');
    put_style(script);
    put_layout(script, rows);
    put_heading(script, figure, rows);
    for (uint32_t i = 0; i < SCENARIO_DIRECTION_COUNT * rows; i++) {
        put_panel(script, figure, &panels[i]);
        if (i == 0)
            g_string_append(script, "unset label\nunset key\n");
    }
    g_string_append(script, "unset multiplot\nset output\n");
    g_free(panels);
    return g_string_free(script, FALSE);
}
