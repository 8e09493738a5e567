#include "coordinator/report/overlay.h"

#include "common/plot/gnuplot.h"
#include "common/table/decimal.h"
#include "coordinator/report/number.h"
#include "coordinator/report/page.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { PANEL_HEIGHT = 220, COLUMN_GAP = 90, ROW_GAP = 90, LINE_HEIGHT = 20 };

// What values are divided by: the greatest of any case, or 1e3 for kN and 1 for m.
struct scale {
    double force, deformation;
};

static uint32_t find_spring(const struct scenario *scenario, const char *name)
{
    uint32_t i = 0;
    while (i < scenario->spring_count && strcmp(scenario->springs[i].name, name) != 0)
        i++;
    return i;
}

static struct scale scale_of(const struct overlay *overlay, const char *spring_name,
                             enum scenario_direction direction)
{
    struct scale scale = {.force = 1e3, .deformation = 1};
    if (!overlay->normalise)
        return scale;
    scale = (struct scale){0};
    for (uint32_t c = 0; c < overlay->count; c++) {
        const struct scenario *scenario = &overlay->searches[c].scenario;
        for (uint32_t v = 0; v < scenario->design_space.count; v++)
            if (scenario->variables[v].direction == direction)
                scale.force = fmax(scale.force, fabs(scenario->design_space.upper[v]));
        const uint32_t index = find_spring(scenario, spring_name);
        if (index == scenario->spring_count)
            continue;
        const struct scenario_spring *spring = &scenario->springs[index];
        for (uint32_t k = 0; k < spring->point_count; k++)
            scale.deformation = fmax(scale.deformation, fabs(spring->deformation[k]));
    }
    scale.force = scale.force > 0 ? scale.force : 1;
    scale.deformation = scale.deformation > 0 ? scale.deformation : 1;
    return scale;
}

static bool has_spring(const struct run_data_search *search, const char *name)
{
    return find_spring(&search->scenario, name) < search->scenario.spring_count;
}

// Points of a spring in one panel, from `first` on and before `end`.
struct part {
    const char *spring_name;
    enum scenario_direction direction;
    uint32_t first, end;
};

// "$NAME << END": deformation, lower and upper of a box.
static void put_block(GString *script, const char *name, const struct run_data_search *search,
                      const struct box *box, const struct part *part, const struct scale *scale)
{
    const uint32_t index = find_spring(&search->scenario, part->spring_name);
    const struct scenario_spring *spring = &search->scenario.springs[index];
    g_string_append_printf(script, "%s << END\n", name);
    for (uint32_t k = part->first; k < part->end; k++) {
        const uint32_t variable = run_data_variable(search, index, part->direction, k);
        char deformation[NUMBER_SIZE], lower[NUMBER_SIZE], upper[NUMBER_SIZE];
        decimal_text(spring->deformation[k] / scale->deformation, deformation);
        decimal_text(box->lower[variable] / scale->force, lower);
        decimal_text(box->upper[variable] / scale->force, upper);
        g_string_append_printf(script, "%s %s %s\n", deformation, lower, upper);
    }
    g_string_append(script, "END\n");
}

// A block of its own with the two bounds of a part of a case's corridor, and their lines in `plot`.
static void put_part(GString *script, GString *plot, const char *name,
                     const struct overlay *overlay, uint32_t index, const struct part *part,
                     const struct scale *scale, const char *style)
{
    const struct run_data_search *search = &overlay->searches[index];
    if (part->first >= part->end)
        return;
    put_block(script, name, search, search->box, part, scale);
    for (int bound = 2; bound <= 3; bound++)
        g_string_append_printf(plot,
                               ", \\\n    %s using 1:%d with %s lc rgb word(colours, %" PRIu32 ")",
                               name, bound, style, index + 1);
}

// A case's corridor: full lines, and dashed ones where no design comes.
static void put_case(GString *script, GString *plot, const struct overlay *overlay, uint32_t index,
                     uint32_t row, struct part part, const struct scale *scale)
{
    const struct run_data_search *search = &overlay->searches[index];
    const uint32_t spring = find_spring(&search->scenario, part.spring_name);
    const char *letter = scenario_direction_name(part.direction);
    char name[64];
    part.first = 0;
    part.end = reach_points(&search->reach, &search->scenario, spring);
    g_snprintf(name, sizeof name, "$case_%" PRIu32 "_%" PRIu32 "_%s", index + 1, row + 1, letter);
    put_part(script, plot, name, overlay, index, &part, scale, "linespoints lw 2 pt 7 ps 0.4");
    part.first = reach_beyond(&search->reach, &search->scenario, spring);
    part.end = search->scenario.springs[spring].point_count;
    g_snprintf(name, sizeof name, "$beyond_%" PRIu32 "_%" PRIu32 "_%s", index + 1, row + 1, letter);
    put_part(script, plot, name, overlay, index, &part, scale, "lines lw 1 dt 2");
}

static void put_panel(GString *script, const struct overlay *overlay, uint32_t row,
                      enum scenario_direction direction)
{
    const struct run_data_search *first = &overlay->searches[0];
    const char *spring = first->scenario.springs[row].name,
               *letter = scenario_direction_name(direction);
    const struct scale scale = scale_of(overlay, spring, direction);
    char name[64];
    g_snprintf(name, sizeof name, "$design_%" PRIu32 "_%s", row + 1, letter);
    const struct part all = {
        .spring_name = spring,
        .direction = direction,
        .end = first->scenario.springs[row].point_count,
    };
    put_block(script, name, first, &first->scenario.design_space, &all, &scale);
    GString *plot = g_string_new(NULL);
    g_string_append_printf(plot,
                           "plot [*:*] [*<0:0<*] %s using 1:2:3 with filledcurves lc rgb space, "
                           "%s using 1:2 with lines lc rgb outline, %s using 1:3 with lines lc "
                           "rgb outline",
                           name, name, name);
    for (uint32_t c = 0; c < overlay->count; c++)
        if (has_spring(&overlay->searches[c], spring))
            put_case(script, plot, overlay, c, row, all, &scale);
    char *title = g_strdup_printf("%s, %s force", spring,
                                  direction == SCENARIO_DIRECTION_X ? "axial" : "lateral");
    char *quoted = gnuplot_quoted(title);
    g_string_append_printf(script,
                           "set title %s noenhanced offset 0, -0.4\n"
                           "set xlabel 'deformation%s' offset 0, 0.5\nset ylabel 'F_%s%s'\n%s\n",
                           quoted, overlay->normalise ? ", normalised" : " [m]", letter,
                           overlay->normalise ? ", normalised" : " [kN]", plot->str);
    g_free(quoted);
    g_free(title);
    g_string_free(plot, TRUE);
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

// Whether some case's corridors have a part that no design comes to.
static bool has_beyond(const struct overlay *overlay)
{
    for (uint32_t c = 0; c < overlay->count; c++)
        if (!reach_everything(&overlay->searches[c].reach, &overlay->searches[c].scenario))
            return true;
    return false;
}

// What the dashed parts are.
static void put_beyond_line(GString *script, double y, double height)
{
    char designs[NUMBER_SIZE];
    char *text = g_strdup_printf("dashed: reached by none of %s designs that were simulated",
                                 number_count(REACH_DESIGNS, designs));
    g_string_append_printf(script,
                           "set arrow from screen %.5f, screen %.5f to screen %.5f, screen %.5f "
                           "nohead front lw 1 dt 2 lc rgb outline\n",
                           (double)PAGE_EDGE / PAGE_WIDTH, 1 - y / height,
                           (double)(PAGE_EDGE + SWATCH_WIDTH) / PAGE_WIDTH, 1 - y / height);
    put_text(script, text, PAGE_EDGE + SWATCH_WIDTH + 10, y, height, "tc rgb '#404040'");
    g_free(text);
}

static void put_heading(GString *script, const struct overlay *overlay, double height)
{
    put_text(script, overlay->title, PAGE_EDGE, 28, height, "font heading");
    for (uint32_t c = 0; c < overlay->count; c++) {
        const struct run_data_search *search = &overlay->searches[c];
        char *text = g_strdup_printf("%s   ·   ln(volume) %.2f", search->name, search->log_volume);
        const double y = 54 + LINE_HEIGHT * (double)c;
        g_string_append_printf(script,
                               "set arrow from screen %.5f, screen %.5f to screen %.5f, screen "
                               "%.5f nohead front lw 3 lc rgb word(colours, %" PRIu32 ")\n",
                               (double)PAGE_EDGE / PAGE_WIDTH, 1 - y / height,
                               (double)(PAGE_EDGE + SWATCH_WIDTH) / PAGE_WIDTH, 1 - y / height,
                               c + 1);
        put_text(script, text, PAGE_EDGE + SWATCH_WIDTH + 10, y, height, "tc rgb '#404040'");
        g_free(text);
    }
    if (has_beyond(overlay))
        put_beyond_line(script, 54 + LINE_HEIGHT * (double)overlay->count, height);
}

char *overlay_script(const struct overlay *overlay)
{
    const uint32_t rows = overlay->searches[0].scenario.spring_count;
    const int top = PAGE_TOP + LINE_HEIGHT * ((int)overlay->count + has_beyond(overlay));
    const int height = top + PAGE_BOTTOM + (int)rows * PANEL_HEIGHT + ((int)rows - 1) * ROW_GAP;
    GString *script = g_string_new(NULL);
    page_begin(script, &(struct figure){.stem = overlay->stem}, height);
    page_style(script);
    g_string_append(script, PAGE_COLOURS);
    g_string_append_printf(script,
                           "set multiplot layout %" PRIu32 ",2 \\\n"
                           "    margins screen %.5f, %.5f, %.5f, %.5f \\\n"
                           "    spacing screen %.5f, %.5f\n",
                           rows, (double)PAGE_LEFT / PAGE_WIDTH,
                           1 - (double)PAGE_RIGHT / PAGE_WIDTH, (double)PAGE_BOTTOM / height,
                           1 - (double)top / height, (double)COLUMN_GAP / PAGE_WIDTH,
                           (double)ROW_GAP / height);
    put_heading(script, overlay, height);
    for (uint32_t row = 0; row < rows; row++)
        for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++) {
            put_panel(script, overlay, row, (enum scenario_direction)d);
            if (row == 0 && d == 0)
                g_string_append(script, "unset label\nunset arrow\n");
        }
    g_string_append(script, "unset multiplot\nset output\n");
    return g_string_free(script, FALSE);
}
