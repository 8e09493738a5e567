#include "coordinator/report/volume.h"

#include "common/plot/gnuplot.h"
#include "common/table/decimal.h"
#include "coordinator/report/number.h"
#include "coordinator/report/page.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum {
    LINES_MAX = 8, // colours that can be told apart
    LINES_HEIGHT = 430,
    MAP_CELL_HEIGHT = 44,
    LABEL_LENGTH = 24, // of a value under an axis, in characters
};

// ---- places on an axis ----

// Where the values of an axis stand: numbers at their place, words and lists one after the other.
struct scale {
    const char **values;
    uint32_t count;
    bool numeric;
};

static bool number_of(const char *text, double *number)
{
    char *end;
    *number = g_ascii_strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*number);
}

static struct scale scale_of(const struct rows *rows, uint32_t axis, bool may_be_numeric)
{
    struct scale scale = {.numeric = may_be_numeric};
    double number;
    scale.values = rows_values(rows, axis, &scale.count);
    for (uint32_t i = 0; i < scale.count && scale.numeric; i++)
        scale.numeric = number_of(scale.values[i], &number);
    return scale;
}

static uint32_t scale_index(const struct scale *scale, const char *value)
{
    uint32_t index = 0;
    while (strcmp(scale->values[index], value) != 0)
        index++;
    return index;
}

static double scale_place(const struct scale *scale, const char *value)
{
    double number;
    if (scale->numeric && number_of(value, &number))
        return number;
    return scale_index(scale, value);
}

// "set xtics (...)" with the values as they were given.
static void put_tics(GString *script, char direction, const struct scale *scale)
{
    if (scale->numeric)
        return;
    g_string_append_printf(script, "set %ctics (", direction);
    for (uint32_t i = 0; i < scale->count; i++) {
        char *cut =
            g_utf8_strlen(scale->values[i], -1) > LABEL_LENGTH
                ? g_strdup_printf("%.*s...",
                                  (int)(g_utf8_offset_to_pointer(scale->values[i], LABEL_LENGTH) -
                                        scale->values[i]),
                                  scale->values[i])
                : g_strdup(scale->values[i]);
        char *label = gnuplot_tick(cut);
        g_string_append_printf(script, "%s%s %" PRIu32, i > 0 ? ", " : "", label, i);
        g_free(label);
        g_free(cut);
    }
    g_string_append(script, ") noenhanced\n");
}

static void put_label(GString *script, const char *what, const char *text, const char *more)
{
    char *label = gnuplot_quoted(text);
    g_string_append_printf(script, "set %s %s noenhanced %s\n", what, label, more);
    g_free(label);
}

// ---- lines ----

// What tells a line from the others: "response=any, samples=200".
static char *line_label(const struct rows *rows, const struct rows_row *row, uint32_t axis)
{
    GString *label = g_string_new(NULL);
    for (uint32_t a = 0; a < rows->axis_count; a++) {
        if (a == axis || rows_is_seed(rows, a) || rows_follows(rows, a, axis))
            continue;
        const char *dot = strrchr(rows->axes[a], '.');
        g_string_append_printf(label, "%s%s=%s", label->len > 0 ? ", " : "",
                               dot != NULL ? dot + 1 : rows->axes[a], row->values[a]);
    }
    return g_string_free(label, FALSE);
}

// The line of each row, as a number from 0 on; `labels` receives what they are called.
static uint32_t *assign_lines(const struct rows *rows, uint32_t axis, GPtrArray *labels)
{
    uint32_t *lines = g_new0(uint32_t, rows->count);
    GHashTable *seen = g_hash_table_new(g_str_hash, g_str_equal);
    for (uint32_t i = 0; i < rows->count; i++) {
        char *label = line_label(rows, &rows->items[i], axis);
        gpointer number;
        if (g_hash_table_lookup_extended(seen, label, NULL, &number)) {
            lines[i] = GPOINTER_TO_UINT(number);
            g_free(label);
        } else {
            lines[i] = labels->len;
            g_hash_table_insert(seen, label, GUINT_TO_POINTER(labels->len));
            g_ptr_array_add(labels, label);
        }
    }
    g_hash_table_destroy(seen);
    if (labels->len > LINES_MAX) {
        memset(lines, 0, rows->count * sizeof *lines);
        g_ptr_array_set_size(labels, 0);
        g_ptr_array_add(labels, g_strdup("median of all cases"));
    }
    return lines;
}

// "$dots_1 << END" with all cases of a line, "$line_1" with the median at each place.
static void put_line(GString *script, const struct rows *rows, const uint32_t *lines, uint32_t line,
                     uint32_t axis, const struct scale *scale)
{
    GString *medians = g_string_new(NULL);
    double *found = g_new(double, rows->count);
    char place[NUMBER_SIZE], volume[NUMBER_SIZE];
    g_string_append_printf(script, "$dots_%" PRIu32 " << END\n", line + 1);
    for (uint32_t v = 0; v < scale->count; v++) {
        uint32_t count = 0;
        decimal_text(scale_place(scale, scale->values[v]), place);
        for (uint32_t i = 0; i < rows->count; i++) {
            const struct rows_row *row = &rows->items[i];
            if (lines[i] != line || isnan(row->log_volume) ||
                strcmp(row->values[axis], scale->values[v]) != 0)
                continue;
            found[count++] = row->log_volume;
            g_string_append_printf(script, "%s %s\n", place, decimal_text(row->log_volume, volume));
        }
        if (count > 0)
            g_string_append_printf(medians, "%s %s\n", place,
                                   decimal_text(rows_median(found, count), volume));
    }
    // gnuplot refuses a block without any point.
    g_string_append_printf(script, "NaN NaN\nEND\n$line_%" PRIu32 " << END\n%sNaN NaN\nEND\n",
                           line + 1, medians->str);
    g_string_free(medians, TRUE);
    g_free(found);
}

static void put_plot(GString *script, const GPtrArray *labels, const struct scale *scale)
{
    // Words get room at both ends; numbers keep their own scale.
    if (scale->numeric)
        g_string_append(script,
                        "set offsets graph 0.04, graph 0.04, graph 0.08, graph 0.05\nplot ");
    else
        g_string_append(script, "set offsets 0.4, 0.4, graph 0.08, graph 0.05\nplot ");
    for (guint i = 0; i < labels->len; i++) {
        char *label = gnuplot_quoted(labels->pdata[i]);
        g_string_append_printf(script,
                               "%s$dots_%u using 1:2 with points lc rgb word(colours, %u) pt 7 "
                               "ps 0.5 notitle, \\\n    $line_%u using 1:2 with linespoints lc rgb "
                               "word(colours, %u) lw 2 pt 7 ps 0.9 title %s noenhanced",
                               i > 0 ? ", \\\n    " : "", i + 1, i + 1, i + 1, i + 1, label);
        g_free(label);
    }
    g_string_append(script, "\nset output\n");
}

char *volume_lines(const struct rows *rows, uint32_t axis, const char *stem)
{
    struct scale scale = scale_of(rows, axis, true);
    GPtrArray *labels = g_ptr_array_new_with_free_func(g_free);
    uint32_t *lines = assign_lines(rows, axis, labels);
    const int height = LINES_HEIGHT + 20 * (int)labels->len;
    GString *script = g_string_new(NULL);
    page_begin(script, &(struct figure){.stem = stem}, height);
    for (guint i = 0; i < labels->len; i++)
        put_line(script, rows, lines, i, axis, &scale);
    page_style(script);
    g_string_append(script, PAGE_COLOURS);
    put_label(script, "title", rows->name, "font heading");
    put_label(script, "xlabel", rows->axes[axis], "");
    g_string_append(script, "set ylabel 'ln(volume / design space)'\n");
    if (labels->len == 1 && ((const char *)labels->pdata[0])[0] == '\0')
        g_string_append(script, "unset key\n");
    else
        g_string_append(script, "set key outside bottom center horizontal maxcols 2\n");
    put_tics(script, 'x', &scale);
    put_plot(script, labels, &scale);
    g_ptr_array_unref(labels);
    g_free(lines);
    g_free(scale.values);
    return g_string_free(script, FALSE);
}

// ---- map ----

// Returns the value halfway between the least and the greatest.
static double put_cells(GString *script, const struct rows *rows, uint32_t across, uint32_t up,
                        const struct scale *x, const struct scale *y)
{
    double *found = g_new(double, rows->count);
    double least = INFINITY, greatest = -INFINITY;
    char volume[NUMBER_SIZE];
    g_string_append(script, "$cells << END\nNaN NaN NaN\n");
    for (uint32_t c = 0; c < x->count; c++) {
        for (uint32_t r = 0; r < y->count; r++) {
            uint32_t count = 0;
            for (uint32_t i = 0; i < rows->count; i++) {
                const struct rows_row *row = &rows->items[i];
                if (!isnan(row->log_volume) && strcmp(row->values[across], x->values[c]) == 0 &&
                    strcmp(row->values[up], y->values[r]) == 0)
                    found[count++] = row->log_volume;
            }
            if (count == 0)
                continue;
            const double median = rows_median(found, count);
            least = fmin(least, median);
            greatest = fmax(greatest, median);
            g_string_append_printf(script, "%" PRIu32 " %" PRIu32 " %s\n", c, r,
                                   decimal_text(median, volume));
        }
    }
    g_string_append(script, "END\n");
    g_free(found);
    return (least + greatest) / 2;
}

char *volume_map(const struct rows *rows, uint32_t across, uint32_t up, const char *stem)
{
    struct scale x = scale_of(rows, across, false), y = scale_of(rows, up, false);
    const int height = PAGE_TOP + 2 * PAGE_BOTTOM + MAP_CELL_HEIGHT * (int)MIN(y.count, 40);
    const bool numbers = x.count <= 12 && y.count <= 40;
    GString *script = g_string_new(NULL);
    page_begin(script, &(struct figure){.stem = stem}, height);
    char number[NUMBER_SIZE];
    const double middle = put_cells(script, rows, across, up, &x, &y);
    page_style(script);
    put_label(script, "title", rows->name, "font heading");
    put_label(script, "xlabel", rows->axes[across], "");
    put_label(script, "ylabel", rows->axes[up], "");
    g_string_append_printf(script,
                           "set cblabel 'ln(volume / design space), median' offset 1.5\n"
                           "set palette defined (0 '#f7fbff', 0.5 '#6baed6', 1 '#08519c')\n"
                           "unset grid\nset offsets 0, 0, 0, 0\n"
                           "set xrange [-0.5:%" PRIu32 " - 0.5]\nset yrange [-0.5:%" PRIu32
                           " - 0.5]\n",
                           x.count, y.count);
    put_tics(script, 'x', &x);
    put_tics(script, 'y', &y);
    // Numbers are dark on light cells and light on dark ones.
    g_string_append_printf(script, "middle = %s\n", decimal_text(middle, number));
    g_string_append(script, "plot $cells using 1:2:(0.49):(0.47):3 with boxxyerror fs solid "
                            "noborder fc palette notitle");
    if (numbers)
        g_string_append(script, ", \\\n    $cells using 1:2:(sprintf('%.2f', $3)):($3 > middle "
                                "? 0xffffff : 0x202020) with labels tc rgb variable notitle");
    g_string_append(script, "\nset output\n");
    g_free(x.values);
    g_free(y.values);
    return g_string_free(script, FALSE);
}
