#include "common/scenario/field.h"
#include "common/scenario/sweep_state.h"
#include "common/table/decimal.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// One entry of `axes`.
struct entry {
    const struct tree_node *path;
    const struct tree_node *values;
    const struct tree_node *range;
    const struct tree_node *linspace;
    const struct tree_node *zip;
    const struct tree_node *csv;
};

// ---- Lists of values ----

static bool read_values(struct sweep *sweep, struct sweep_axis *axis, const struct tree_node *node,
                        struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind != TREE_SEQUENCE || node->count == 0) {
        tree_error(node, error, "expected a list of at least one value, found %s",
                   tree_shown(node, shown));
        return false;
    }
    GHashTable *seen = g_hash_table_new(g_str_hash, g_str_equal);
    bool accepted = true;
    for (uint32_t i = 0; i < node->count && accepted; i++) {
        accepted = sweep_cell_add_node(sweep, axis, node->items[i], error);
        if (accepted &&
            !g_hash_table_add(seen,
                              (gpointer)g_array_index(axis->cells, struct sweep_cell, i).text)) {
            tree_error(node->items[i], error, "%s is given twice: expected different values",
                       tree_shown(node->items[i], shown));
            accepted = false;
        }
    }
    g_hash_table_destroy(seen);
    return accepted;
}

// Two or three numbers: [from, to, third].
static bool read_numbers(const struct tree_node *node, double numbers[3], bool third_needed,
                         const char *expected, struct error *error)
{
    static const struct field_range any = FIELD_ANY;
    const bool counts =
        node->kind == TREE_SEQUENCE && (node->count == 3 || (node->count == 2 && !third_needed));
    if (counts && field_read_numbers(node, &any, NULL, numbers, node->count, error))
        return true;
    char shown[TREE_SHOWN_SIZE];
    if (!counts)
        tree_error(node, error, "expected %s, found %s", expected, tree_shown(node, shown));
    return false;
}

static bool read_range(struct sweep *sweep, struct sweep_axis *axis, const struct tree_node *node,
                       struct error *error)
{
    static const char expected[] = "whole numbers [from, to] or [from, to, step], the step above "
                                   "0 and `to` not below `from`";
    double numbers[3] = {0, 0, 1};
    if (!read_numbers(node, numbers, false, expected, error))
        return false;
    for (int i = 0; i < 3; i++) {
        if (numbers[i] != floor(numbers[i]) || fabs(numbers[i]) > FIELD_COUNT_MAX) {
            tree_error(node, error, "expected %s", expected);
            return false;
        }
    }
    if (numbers[2] <= 0 || numbers[1] < numbers[0]) {
        tree_error(node, error, "expected %s", expected);
        return false;
    }
    const double count = floor((numbers[1] - numbers[0]) / numbers[2]) + 1;
    if (count > SWEEP_CASE_MAX) {
        tree_error(node, error, "expected at most %d values, found %.0f", SWEEP_CASE_MAX, count);
        return false;
    }
    for (uint32_t i = 0; i < (uint32_t)count; i++) {
        char text[32];
        snprintf(text, sizeof text, "%.0f", numbers[0] + i * numbers[2]);
        sweep_cell_add(sweep, axis, text, NULL, node);
    }
    return true;
}

static bool read_linspace(struct sweep *sweep, struct sweep_axis *axis,
                          const struct tree_node *node, struct error *error)
{
    static const char expected[] = "[from, to, how many], with at least 2 different values";
    double numbers[3];
    if (!read_numbers(node, numbers, true, expected, error))
        return false;
    if (numbers[2] != floor(numbers[2]) || numbers[2] < 2 || numbers[2] > SWEEP_CASE_MAX ||
        numbers[0] == numbers[1]) {
        tree_error(node, error, "expected %s and at most %d", expected, SWEEP_CASE_MAX);
        return false;
    }
    const uint32_t count = (uint32_t)numbers[2];
    for (uint32_t i = 0; i < count; i++) {
        char text[DECIMAL_SIZE];
        const double value =
            i + 1 == count ? numbers[1] : numbers[0] + (numbers[1] - numbers[0]) * i / (count - 1);
        sweep_cell_add(sweep, axis, decimal_text(value, text), NULL, node);
    }
    return true;
}

// ---- Columns ----

bool sweep_axes_add_column(struct sweep *sweep, struct sweep_axis *axis, const char *path,
                           const struct tree_node *place, struct error *error)
{
    if (path[0] == '\0' || path[0] == '.' || strchr(path, '=') != NULL ||
        strstr(path, "..") != NULL || g_str_has_suffix(path, ".")) {
        tree_error(place, error, "expected the path of a key, such as vehicle.mass, found '%s'",
                   path);
        return false;
    }
    if (sweep->columns->len == SWEEP_COLUMN_MAX) {
        tree_error(place, error, "expected at most %d keys that change", SWEEP_COLUMN_MAX);
        return false;
    }
    const struct sweep_column column = {
        .path = {.kind = TREE_SCALAR,
                 .source = place->source,
                 .line = place->line,
                 .column = place->column,
                 .text = g_string_chunk_insert_const(sweep->strings, path)},
        .resolved = tree_resolve(sweep->base, path)};
    bool first = true;
    for (guint i = 0; i < sweep->columns->len && first; i++)
        first = strcmp(g_array_index(sweep->columns, struct sweep_column, i).resolved,
                       column.resolved) != 0;
    if (!first)
        tree_error(place, error, "%s is changed twice: expected one axis for each key", path);
    g_array_append_val(sweep->columns, column);
    g_ptr_array_add(sweep->paths, (gpointer)column.path.text);
    axis->column_count++;
    return first;
}

static bool read_entry(const struct tree_node *node, struct entry *entry, struct error *error)
{
    static const struct field fields[] = {
        {"path", FIELD_NODE, true, offsetof(struct entry, path), FIELD_ANY, NULL, NULL, NULL},
        {"values", FIELD_NODE, true, offsetof(struct entry, values), FIELD_ANY, NULL, NULL, NULL},
        {"range", FIELD_NODE, true, offsetof(struct entry, range), FIELD_ANY, NULL, NULL, NULL},
        {"linspace", FIELD_NODE, true, offsetof(struct entry, linspace), FIELD_ANY, NULL, NULL,
         NULL},
        {"zip", FIELD_NODE, true, offsetof(struct entry, zip), FIELD_ANY, NULL, NULL, NULL},
        {"csv", FIELD_NODE, true, offsetof(struct entry, csv), FIELD_ANY, NULL, NULL, NULL},
    };
    *entry = (struct entry){0};
    if (!field_read(node, fields, G_N_ELEMENTS(fields), entry, error))
        return false;
    const int sources = (entry->values != NULL) + (entry->range != NULL) +
                        (entry->linspace != NULL) + (entry->zip != NULL) + (entry->csv != NULL);
    const bool has_path = entry->values != NULL || entry->range != NULL || entry->linspace != NULL;
    if (sources == 1 && has_path == (entry->path != NULL))
        return true;
    tree_error(node, error,
               "expected `path` with one of `values`, `range` and `linspace`, or `zip`, or `csv`");
    return false;
}

// One key and its values.
static bool read_key(struct sweep *sweep, struct sweep_axis *axis, const struct entry *entry,
                     struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (entry->path->kind != TREE_SCALAR) {
        tree_error(entry->path, error, "expected the path of a key, found %s",
                   tree_shown(entry->path, shown));
        return false;
    }
    if (!sweep_axes_add_column(sweep, axis, entry->path->text, entry->path, error))
        return false;
    if (entry->values != NULL)
        return read_values(sweep, axis, entry->values, error);
    if (entry->range != NULL)
        return read_range(sweep, axis, entry->range, error);
    assert(entry->linspace != NULL);
    return read_linspace(sweep, axis, entry->linspace, error);
}

// Puts columns that were read one after the other beside each other.
static void interleave(struct sweep_axis *axis)
{
    GArray *rows = g_array_new(FALSE, FALSE, sizeof(struct sweep_cell));
    for (uint32_t row = 0; row < axis->row_count; row++) {
        for (uint32_t column = 0; column < axis->column_count; column++)
            g_array_append_val(rows, g_array_index(axis->cells, struct sweep_cell,
                                                   column * axis->row_count + row));
    }
    g_array_unref(axis->cells);
    axis->cells = rows;
}

static bool read_zip(struct sweep *sweep, struct sweep_axis *axis, const struct tree_node *node,
                     struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind != TREE_SEQUENCE || node->count == 0) {
        tree_error(node, error, "expected a list of axes that go together, found %s",
                   tree_shown(node, shown));
        return false;
    }
    for (uint32_t i = 0; i < node->count; i++) {
        const struct tree_node *item = node->items[i];
        struct entry entry;
        if (!read_entry(item, &entry, error))
            return false;
        if (entry.path == NULL) {
            tree_error(item, error, "expected `path` with one of `values`, `range`, `linspace`");
            return false;
        }
        struct sweep_axis one = {.cells = g_array_new(FALSE, FALSE, sizeof(struct sweep_cell))};
        bool read = read_key(sweep, &one, &entry, error);
        if (read && i > 0 && one.cells->len != axis->row_count) {
            tree_error(item, error, "expected %u values as in the first axis of the zip, found %u",
                       axis->row_count, one.cells->len);
            read = false;
        }
        axis->row_count = one.cells->len;
        axis->column_count++;
        g_array_append_vals(axis->cells, one.cells->data, one.cells->len);
        g_array_unref(one.cells);
        if (!read)
            return false;
    }
    interleave(axis);
    return true;
}

// ---- Axes ----

static bool count_cases(struct sweep *sweep, const struct tree_node *place, uint32_t rows,
                        struct error *error)
{
    const uint64_t count = (uint64_t)sweep->case_count * rows;
    if (count > SWEEP_CASE_MAX) {
        tree_error(place, error, "expected at most %d cases in a sweep, found %llu with this axis",
                   SWEEP_CASE_MAX, (unsigned long long)count);
        return false;
    }
    sweep->case_count = (uint32_t)count;
    return true;
}

static bool read_axis(struct sweep *sweep, const struct tree_node *node, struct error *error)
{
    struct entry entry;
    if (!read_entry(node, &entry, error))
        return false;
    struct sweep_axis axis = {.first_column = sweep->columns->len,
                              .cells = g_array_new(FALSE, FALSE, sizeof(struct sweep_cell))};
    bool read;
    if (entry.zip != NULL) {
        read = read_zip(sweep, &axis, entry.zip, error);
    } else if (entry.csv != NULL) {
        read = sweep_table_read(sweep, &axis, entry.csv, error);
    } else {
        read = read_key(sweep, &axis, &entry, error);
        axis.row_count = axis.cells->len;
    }
    g_array_append_val(sweep->axes, axis); // also a broken one, to be released
    return read && count_cases(sweep, node, axis.row_count, error);
}

bool sweep_axes_read(struct sweep *sweep, const struct tree_node *node, struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind != TREE_SEQUENCE || node->count == 0) {
        tree_error(node, error, "expected a list of at least one axis, found %s",
                   tree_shown(node, shown));
        return false;
    }
    for (uint32_t i = 0; i < node->count; i++) {
        if (!read_axis(sweep, node->items[i], error))
            return false;
    }
    return true;
}

bool sweep_axes_add_seeds(struct sweep *sweep, const struct tree_node *place, uint64_t seed,
                          uint32_t count, struct error *error)
{
    struct sweep_axis axis = {.first_column = sweep->columns->len,
                              .row_count = count,
                              .cells = g_array_new(FALSE, FALSE, sizeof(struct sweep_cell))};
    const bool added = sweep_axes_add_column(sweep, &axis, "search.seed", place, error) &&
                       count_cases(sweep, place, count, error);
    for (uint32_t i = 0; added && i < count; i++) {
        char text[32];
        snprintf(text, sizeof text, "%llu", (unsigned long long)(seed + i));
        sweep_cell_add(sweep, &axis, text, NULL, place);
    }
    g_array_append_val(sweep->axes, axis);
    return added;
}
