#include "coordinator/report/figure.h"
#include "common/table/decimal.h"
#include "coordinator/report/number.h"
#include "coordinator/report/page.h"

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

static uint32_t spring_find(const struct run_data_search *search, const char *name)
{
    uint32_t i = 0;
    while (i < search->scenario.spring_count && strcmp(search->scenario.springs[i].name, name) != 0)
        i++;
    return i;
}

static bool spring_shared(const struct run_data_search *other, const char *name)
{
    return other != NULL && spring_find(other, name) < other->scenario.spring_count;
}

uint32_t figure_shared_springs(const struct run_data_search *search,
                               const struct run_data_search *other)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < search->scenario.spring_count; i++)
        count += spring_shared(other, search->scenario.springs[i].name);
    return count;
}

// All forces of one direction share their range, so that springs compare (thesis 8.5.3: force
// normalised to the highest of all groups).
static void range_take_forces(struct range *range, const struct run_data_search *search,
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
    const struct run_data_search *both[] = {figure->search, figure->other};
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

// Points of a spring, from `first` on and before `end`.
struct points {
    uint32_t first, end;
};

static struct points points_all(const struct run_data_search *search, const char *spring_name)
{
    return (struct points){
        .end = search->scenario.springs[spring_find(search, spring_name)].point_count};
}

// "$corridor_1_x << END": deformation, lower and upper of points of a box of one panel.
static void put_block(GString *script, const char *name, const struct figure *figure,
                      const struct panel *panel, const struct run_data_search *search,
                      const struct box *box, struct points points)
{
    uint32_t index = spring_find(search, panel->spring_name);
    const struct scenario_spring *spring = &search->scenario.springs[index];
    g_string_append_printf(script, "$%s_%" PRIu32 "_%s << END\n", name, panel->row + 1,
                           scenario_direction_name(panel->direction));
    for (uint32_t k = points.first; k < points.end; k++) {
        uint32_t variable = run_data_variable(search, index, panel->direction, k);
        char deformation[NUMBER_SIZE], lower[NUMBER_SIZE], upper[NUMBER_SIZE];
        decimal_text(deformation_value(figure, panel, spring->deformation[k]), deformation);
        decimal_text(force_value(figure, panel, box->lower[variable]), lower);
        decimal_text(force_value(figure, panel, box->upper[variable]), upper);
        g_string_append_printf(script, "%s %s %s\n", deformation, lower, upper);
    }
    g_string_append(script, "END\n");
}

static bool panel_compared(const struct figure *figure, const struct panel *panel)
{
    return spring_shared(figure->other, panel->spring_name) && figure->other->box != NULL;
}

// The points of a corridor that designs reach.
static struct points points_reached(const struct run_data_search *search, const char *spring_name)
{
    return (struct points){
        .end = reach_points(&search->reach, &search->scenario, spring_find(search, spring_name))};
}

// The part behind them, which is hatched; empty where all are reached.
static struct points points_beyond(const struct run_data_search *search, const char *spring_name)
{
    struct points points = points_all(search, spring_name);
    points.first =
        reach_beyond(&search->reach, &search->scenario, spring_find(search, spring_name));
    return points;
}

// A corridor in its two parts, of which one may be missing.
static void put_corridor(GString *script, const char *name, const struct figure *figure,
                         const struct panel *panel, const struct run_data_search *search)
{
    char beyond[32];
    g_snprintf(beyond, sizeof beyond, "%s_beyond", name);
    const struct points reached = points_reached(search, panel->spring_name);
    const struct points behind = points_beyond(search, panel->spring_name);
    if (reached.end > 0)
        put_block(script, name, figure, panel, search, search->box, reached);
    if (behind.first < behind.end)
        put_block(script, beyond, figure, panel, search, search->box, behind);
}

// "$spread_1_x << END": deformation, a bound and its spread; both bounds, where they have one.
static void put_spread(GString *script, const struct figure *figure, const struct panel *panel)
{
    const struct run_data_search *search = figure->search;
    const uint32_t index = spring_find(search, panel->spring_name);
    const struct scenario_spring *spring = &search->scenario.springs[index];
    // gnuplot takes no block without a row.
    g_string_append_printf(script, "$spread_%" PRIu32 "_%s << END\n", panel->row + 1,
                           scenario_direction_name(panel->direction));
    for (uint32_t k = 0; k < 2 * spring->point_count; k++) {
        const uint32_t v = run_data_variable(search, index, panel->direction, k / 2);
        const double bound = k % 2 == 0 ? search->box->lower[v] : search->box->upper[v];
        const double spread = k % 2 == 0 ? figure->spread->lower[v] : figure->spread->upper[v];
        char deformation[NUMBER_SIZE], value[NUMBER_SIZE], height[NUMBER_SIZE];
        if (!(spread > 0))
            continue;
        decimal_text(deformation_value(figure, panel, spring->deformation[k / 2]), deformation);
        decimal_text(force_value(figure, panel, bound), value);
        decimal_text(force_value(figure, panel, bound + spread) - force_value(figure, panel, bound),
                     height);
        g_string_append_printf(script, "%s %s %s\n", deformation, value, height);
    }
    g_string_append(script, "NaN NaN NaN\nEND\n");
}

static void put_data(GString *script, const struct figure *figure, const struct panel *panel)
{
    const struct run_data_search *search = figure->search;
    put_block(script, "design", figure, panel, search, &search->scenario.design_space,
              points_all(search, panel->spring_name));
    if (search->box != NULL)
        put_corridor(script, "corridor", figure, panel, search);
    if (search->box != NULL && figure->spread != NULL)
        put_spread(script, figure, panel);
    if (panel_compared(figure, panel))
        put_corridor(script, "compared", figure, panel, figure->other);
}

// ---- words ----

// A spring's name, letters, digits, '-' and '_' (scenario_read.h), for text in which gnuplot takes
// '_' as the beginning of an index.
static char *escaped(const char *identifier)
{
    char **parts = g_strsplit(identifier, "_", -1);
    char *text = g_strjoinv("\\_", parts);
    g_strfreev(parts);
    return text;
}

// ---- the page ----

enum {
    COLUMN_GAP = 90, // [pixels] the right panels' axis labels
    ROW_GAP = 90,    // axis label and title of the next row
};

// Many springs make a long page; flatter panels keep it readable as a whole.
static int panel_height(uint32_t rows)
{
    return rows <= 1 ? 270 : rows <= 3 ? 220 : rows <= 8 ? 170 : 140;
}

static int figure_height(const struct figure *figure, uint32_t rows)
{
    return page_top(figure) + PAGE_BOTTOM + (int)rows * panel_height(rows) +
           ((int)rows - 1) * ROW_GAP;
}

static void put_layout(GString *script, const struct figure *figure, uint32_t rows)
{
    double height = figure_height(figure, rows);
    g_string_append_printf(script,
                           "set multiplot layout %" PRIu32 ",2 \\\n"
                           "    margins screen %.5f, %.5f, %.5f, %.5f \\\n"
                           "    spacing screen %.5f, %.5f\n",
                           rows, (double)PAGE_LEFT / PAGE_WIDTH,
                           1 - (double)PAGE_RIGHT / PAGE_WIDTH, PAGE_BOTTOM / height,
                           1 - page_top(figure) / height, (double)COLUMN_GAP / PAGE_WIDTH,
                           ROW_GAP / height);
}

static void put_axes(GString *script, const struct figure *figure, const struct panel *panel)
{
    const char *direction = scenario_direction_name(panel->direction);
    char *name = escaped(panel->spring_name);
    g_string_append_printf(script, "set title '{/:Bold %s, %s force}' enhanced offset 0, -0.4\n",
                           name, panel->direction == SCENARIO_DIRECTION_X ? "axial" : "lateral");
    if (figure->normalise)
        g_string_append_printf(script,
                               "set xlabel 'deformation, normalised' offset 0, 0.5\n"
                               "set ylabel 'F_%s, normalised' enhanced\n",
                               direction);
    else
        g_string_append_printf(script,
                               "set xlabel 'deformation [m]' offset 0, 0.5\n"
                               "set ylabel 'F_%s [kN]' enhanced\n",
                               direction);
    g_free(name);
}

// One more curve or band of the panel that is being plotted.
static void put_curve(GString *script, const char *block, const struct panel *panel,
                      const char *columns, const char *style)
{
    g_string_append_printf(script, ", \\\n    $%s_%" PRIu32 "_%s using %s with %s", block,
                           panel->row + 1, scenario_direction_name(panel->direction), columns,
                           style);
}

// How a corridor's parts are drawn, of the search itself or of the one it is compared with.
struct ink {
    const char *block, *colour, *hatch;
};

static const struct ink own_ink = {"corridor", "first", PAGE_HATCH};
static const struct ink other_ink = {"compared", "second", PAGE_HATCH_OTHER};

// The band between the bounds, hatched where no design comes.
static void put_band(GString *script, const struct ink *ink, const struct panel *panel,
                     const struct run_data_search *search)
{
    char style[96], beyond[32];
    const struct points behind = points_beyond(search, panel->spring_name);
    g_snprintf(style, sizeof style, "filledcurves lc rgb %s_fill", ink->colour);
    g_snprintf(beyond, sizeof beyond, "%s_beyond", ink->block);
    if (points_reached(search, panel->spring_name).end > 0)
        put_curve(script, ink->block, panel, "1:2:3", style);
    g_snprintf(style, sizeof style, "filledcurves fs transparent %s lc rgb %s_fill", ink->hatch,
               ink->colour);
    if (behind.first < behind.end)
        put_curve(script, beyond, panel, "1:2:3", style);
}

// The two bounds of a corridor; points mark the deformations at which the forces are free.
static void put_bounds(GString *script, const struct ink *ink, const struct panel *panel,
                       const struct run_data_search *search)
{
    static const char *const bounds[] = {"1:2", "1:3"};
    char style[96], beyond[32];
    const struct points behind = points_beyond(search, panel->spring_name);
    g_snprintf(beyond, sizeof beyond, "%s_beyond", ink->block);
    for (size_t b = 0; b < G_N_ELEMENTS(bounds); b++) {
        g_snprintf(style, sizeof style, "lines dt 2 lc rgb %s lw 1.5", ink->colour);
        if (behind.first < behind.end)
            put_curve(script, beyond, panel, bounds[b], style);
        g_snprintf(style, sizeof style, "linespoints lc rgb %s lw 2 pt 7 ps 0.4", ink->colour);
        if (points_reached(search, panel->spring_name).end > 0)
            put_curve(script, ink->block, panel, bounds[b], style);
    }
}

// Bands first, then lines, so that no band dims a line.
static void put_panel(GString *script, const struct figure *figure, const struct panel *panel)
{
    put_axes(script, figure, panel);
    g_string_append(script, "plot [*:*] [*<0:0<*] NaN");
    put_curve(script, "design", panel, "1:2:3", "filledcurves lc rgb space");
    if (figure->search->box != NULL)
        put_band(script, &own_ink, panel, figure->search);
    if (panel_compared(figure, panel))
        put_band(script, &other_ink, panel, figure->other);
    put_curve(script, "design", panel, "1:2", "lines lc rgb outline");
    put_curve(script, "design", panel, "1:3", "lines lc rgb outline");
    if (figure->search->box != NULL)
        put_bounds(script, &own_ink, panel, figure->search);
    if (figure->search->box != NULL && figure->spread != NULL)
        put_curve(script, "spread", panel, "1:($2-$3):(0):(2*$3)",
                  "vectors heads size screen 0.004,90 lc rgb first lw 1.5");
    if (panel_compared(figure, panel))
        put_bounds(script, &other_ink, panel, figure->other);
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
    page_begin(script, figure, figure_height(figure, rows));
    g_string_append(script, "# deformation, lower, upper\n");
    for (uint32_t i = 0; i < SCENARIO_DIRECTION_COUNT * rows; i++)
        put_data(script, figure, &panels[i]);
    g_string_append_c(script, '\n');
    page_style(script);
    put_layout(script, figure, rows);
    page_heading(script, figure, figure_height(figure, rows));
    for (uint32_t i = 0; i < SCENARIO_DIRECTION_COUNT * rows; i++) {
        put_panel(script, figure, &panels[i]);
        if (i == 0)
            g_string_append(script, "unset label\nunset object\n");
    }
    g_string_append(script, "unset multiplot\nset output\n");
    g_free(panels);
    return g_string_free(script, FALSE);
}
