#include "common/base/plain.h"
#include "common/scenario/scenario_read.h"
#include "common/scenario/sweep_state.h"

#include <assert.h>
#include <glib.h>
#include <stdio.h>
#include <string.h>

// ---- Cells ----

// Which row of an axis a case has.
static uint32_t case_row(const struct sweep *sweep, uint32_t index, guint axis)
{
    assert(index < sweep->case_count);
    for (guint i = sweep->axes->len; i-- > axis + 1;)
        index /= g_array_index(sweep->axes, struct sweep_axis, i).row_count;
    return index % g_array_index(sweep->axes, struct sweep_axis, axis).row_count;
}

static const struct sweep_cell *axis_cell(const struct sweep_axis *axis, uint32_t row,
                                          uint32_t column)
{
    return &g_array_index(axis->cells, struct sweep_cell, row * axis->column_count + column);
}

const struct sweep_cell *sweep_case_cell(const struct sweep *sweep, uint32_t index, uint32_t column)
{
    assert(column < sweep->columns->len);
    guint a = 0;
    const struct sweep_axis *axis = &g_array_index(sweep->axes, struct sweep_axis, 0);
    while (column >= axis->first_column + axis->column_count)
        axis = &g_array_index(sweep->axes, struct sweep_axis, ++a);
    return axis_cell(axis, case_row(sweep, index, a), column - axis->first_column);
}

// ---- Names ----

static const char *last_key(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL ? dot + 1 : path;
}

// The last key of a path where no other path has the same one, else the whole path.
static void label_columns(struct sweep *sweep)
{
    struct sweep_column *columns = (struct sweep_column *)(void *)sweep->columns->data;
    for (guint i = 0; i < sweep->columns->len; i++) {
        const char *path = columns[i].path.text;
        columns[i].label = last_key(path);
        for (guint k = 0; k < sweep->columns->len; k++)
            if (k != i && strcmp(last_key(path), last_key(columns[k].path.text)) == 0)
                columns[i].label = path;
    }
}

static char *label_of(const struct sweep *sweep, const struct sweep_axis *axis, uint32_t row)
{
    GString *label = g_string_new(NULL);
    if (axis->labels != NULL)
        g_string_append(label, axis->labels->pdata[row]);
    for (uint32_t c = 0; axis->labels == NULL && c < axis->column_count; c++) {
        const struct sweep_cell *cell = axis_cell(axis, row, c);
        g_string_append_printf(
            label, "%s%s=", c > 0 ? "," : "",
            g_array_index(sweep->columns, struct sweep_column, axis->first_column + c).label);
        if (cell->plain)
            g_string_append(label, cell->text);
        else
            g_string_append_printf(label, "#%u", row + 1);
    }
    return g_string_free(label, FALSE);
}

// Names stand on terminals and in file names of pictures, so what tables and values hold of control
// characters stays out of them.
static void put_label(const struct sweep *sweep, GString *name, const struct sweep_axis *axis,
                      uint32_t row)
{
    char *label = label_of(sweep, axis, row), *plain = plain_text(label);
    g_string_append_printf(name, "%s%s", name->len > 0 ? "," : "", plain);
    g_free(plain);
    g_free(label);
}

const char *sweep_case_name(const struct sweep *sweep, uint32_t index,
                            char name[SWEEP_CASE_NAME_SIZE])
{
    GString *text = g_string_new(NULL);
    for (guint i = 0; i < sweep->axes->len; i++)
        put_label(sweep, text, &g_array_index(sweep->axes, struct sweep_axis, i),
                  case_row(sweep, index, i));
    if (text->len < SWEEP_CASE_NAME_SIZE)
        memcpy(name, text->str, text->len + 1);
    else
        snprintf(name, SWEEP_CASE_NAME_SIZE, "case %u", index + 1);
    g_string_free(text, TRUE);
    return name;
}

// Rows of a table may repeat each other, and labels may be anything.
static bool check_names(const struct sweep *sweep, struct error *error)
{
    GHashTable *seen = g_hash_table_new_full(g_str_hash, g_str_equal, g_free, NULL);
    bool unique = true;
    for (guint a = 0; a < sweep->axes->len && unique; a++) {
        const struct sweep_axis *axis = &g_array_index(sweep->axes, struct sweep_axis, a);
        g_hash_table_remove_all(seen);
        for (uint32_t row = 0; row < axis->row_count && unique; row++) {
            GString *name = g_string_new(NULL);
            put_label(sweep, name, axis, row);
            const struct sweep_cell *cell = axis_cell(axis, row, 0);
            const struct tree_node place = {
                .source = cell->source, .line = cell->line, .column = cell->column};
            char *key = g_string_free(name, FALSE);
            if (g_hash_table_contains(seen, key)) {
                tree_error(&place, error, "two cases would have the name '%s': expected %s", key,
                           axis->labels != NULL ? "a name of its own in each row"
                                                : "different values in each row");
                unique = false;
            }
            g_hash_table_add(seen, key);
        }
    }
    g_hash_table_destroy(seen);
    return unique;
}

bool sweep_case_label(struct sweep *sweep, struct error *error)
{
    label_columns(sweep);
    return check_names(sweep, error);
}
