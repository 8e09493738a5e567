#include "common/scenario/sweep.h"

#include "common/scenario/field.h"
#include "common/scenario/scenario_read.h"
#include "common/scenario/sheet.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// A value of a column and where it was given.
struct value {
    const char *text; // YAML
    const char *source;
    uint32_t line, column;
    bool plain; // short enough and simple enough to stand in a name
};

// One digit of a case's number: columns that change together.
struct axis {
    uint32_t first_column;
    uint32_t column_count;
    uint32_t row_count;
    GArray *values;    // of struct value (row_count x column_count)
    GPtrArray *labels; // (row_count) names given in a table's column `case`; NULL without one
};

struct sweep {
    char name[SCENARIO_NAME_SIZE];
    struct tree *tree;     // of the sweep file
    GStringChunk *strings; // texts that live as long as the sweep
    const char *base_path;
    GString *base; // text of the base scenario
    const char *const *overrides;
    size_t override_count;
    GArray *axes;      // of struct axis
    GPtrArray *paths;  // of the columns, ends with NULL
    GPtrArray *labels; // how names call the columns
    uint32_t case_count;
};

// What the top of the file holds.
struct document {
    char name[SCENARIO_NAME_SIZE];
    const struct tree_node *base;
    const struct tree_node *axes;
    uint32_t replicates;
};

// One entry of `axes`.
struct entry {
    const struct tree_node *path;
    const struct tree_node *values;
    const struct tree_node *range;
    const struct tree_node *linspace;
    const struct tree_node *zip;
    const struct tree_node *csv;
};

enum { LABEL_MAX = 32 }; // [bytes] of a value in a name

// ------------------------------------------------------------------------------------------------
// Values as text

// What YAML reads as the same plain scalar wherever it stands.
static bool plain_scalar(const char *text)
{
    return text[0] != '\0' && strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                           "0123456789_.+-") == strlen(text);
}

// A scalar in double quotes. One that is not plain_scalar() is no number, so quotes change nothing.
static void put_quoted(GString *text, const char *scalar)
{
    g_string_append_c(text, '"');
    for (const char *c = scalar; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\')
            g_string_append_printf(text, "\\%c", *c);
        else if ((unsigned char)*c < 0x20 || *c == 0x7f)
            g_string_append_printf(text, "\\x%02x", (unsigned char)*c);
        else
            g_string_append_c(text, *c);
    }
    g_string_append_c(text, '"');
}

// A node on one line: "[1, 2]", "{lower: 0}". Depth is bounded by the tree's.
static void put_node(GString *text, const struct tree_node *node)
{
    if (node->kind == TREE_SCALAR) {
        if (!node->quoted && plain_scalar(node->text))
            g_string_append(text, node->text);
        else
            put_quoted(text, node->text);
        return;
    }
    const bool mapping = node->kind == TREE_MAPPING;
    g_string_append_c(text, mapping ? '{' : '[');
    for (uint32_t i = 0; i < node->count; i++) {
        g_string_append(text, i > 0 ? ", " : "");
        if (mapping) {
            put_node(text, node->keys[i]);
            g_string_append(text, ": ");
        }
        put_node(text, node->items[i]);
    }
    g_string_append_c(text, mapping ? '}' : ']');
}

// The shortest decimal that reads back as the same number.
static const char *number_text(double number, char text[40])
{
    for (int digits = 15; digits <= 17; digits++) {
        char format[8];
        snprintf(format, sizeof format, "%%.%dg", digits);
        g_ascii_formatd(text, 40, format, number);
        if (g_ascii_strtod(text, NULL) == number)
            break;
    }
    return text;
}

static void add_value(struct sweep *sweep, struct axis *axis, const char *text,
                      const struct tree_node *place)
{
    const struct value value = {
        .text = g_string_chunk_insert_const(sweep->strings, text),
        .source = place->source,
        .line = place->line,
        .column = place->column,
        .plain = strlen(text) <= LABEL_MAX && strpbrk(text, "[]{},/\"") == NULL,
    };
    g_array_append_val(axis->values, value);
}

// ------------------------------------------------------------------------------------------------
// Axes

static bool read_values(struct sweep *sweep, struct axis *axis, const struct tree_node *node,
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
        GString *text = g_string_new(NULL);
        put_node(text, node->items[i]);
        add_value(sweep, axis, text->str, node->items[i]);
        const struct value *value = &g_array_index(axis->values, struct value, i);
        accepted = g_hash_table_add(seen, (gpointer)value->text);
        if (!accepted)
            tree_error(node->items[i], error, "%s is given twice: expected different values",
                       tree_shown(node->items[i], shown));
        g_string_free(text, TRUE);
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

static bool read_range(struct sweep *sweep, struct axis *axis, const struct tree_node *node,
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
        add_value(sweep, axis, text, node);
    }
    return true;
}

static bool read_linspace(struct sweep *sweep, struct axis *axis, const struct tree_node *node,
                          struct error *error)
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
        char text[40];
        const double value =
            i + 1 == count ? numbers[1] : numbers[0] + (numbers[1] - numbers[0]) * i / (count - 1);
        add_value(sweep, axis, number_text(value, text), node);
    }
    return true;
}

// Takes a path for a new column of the axis.
static bool add_column(struct sweep *sweep, struct axis *axis, const char *path,
                       const struct tree_node *place, struct error *error)
{
    if (path[0] == '\0' || path[0] == '.' || strchr(path, '=') != NULL ||
        strstr(path, "..") != NULL || g_str_has_suffix(path, ".")) {
        tree_error(place, error, "expected the path of a key, such as vehicle.mass, found '%s'",
                   path);
        return false;
    }
    for (guint i = 0; i < sweep->paths->len; i++) {
        if (strcmp(sweep->paths->pdata[i], path) == 0) {
            tree_error(place, error, "%s is changed twice: expected one axis for each key", path);
            return false;
        }
    }
    if (sweep->paths->len == SWEEP_COLUMN_MAX) {
        tree_error(place, error, "expected at most %d keys that change", SWEEP_COLUMN_MAX);
        return false;
    }
    g_ptr_array_add(sweep->paths, g_string_chunk_insert_const(sweep->strings, path));
    axis->column_count++;
    return true;
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
static bool read_key(struct sweep *sweep, struct axis *axis, const struct entry *entry,
                     struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (entry->path->kind != TREE_SCALAR) {
        tree_error(entry->path, error, "expected the path of a key, found %s",
                   tree_shown(entry->path, shown));
        return false;
    }
    if (!add_column(sweep, axis, entry->path->text, entry->path, error))
        return false;
    if (entry->values != NULL)
        return read_values(sweep, axis, entry->values, error);
    if (entry->range != NULL)
        return read_range(sweep, axis, entry->range, error);
    assert(entry->linspace != NULL);
    return read_linspace(sweep, axis, entry->linspace, error);
}

// Puts columns that were read one after the other beside each other.
static void interleave(struct axis *axis)
{
    GArray *rows = g_array_new(FALSE, FALSE, sizeof(struct value));
    for (uint32_t row = 0; row < axis->row_count; row++) {
        for (uint32_t column = 0; column < axis->column_count; column++)
            g_array_append_val(
                rows, g_array_index(axis->values, struct value, column * axis->row_count + row));
    }
    g_array_unref(axis->values);
    axis->values = rows;
}

static bool read_zip(struct sweep *sweep, struct axis *axis, const struct tree_node *node,
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
        struct axis one = {.values = g_array_new(FALSE, FALSE, sizeof(struct value))};
        bool read = read_key(sweep, &one, &entry, error);
        if (read && i > 0 && one.values->len != axis->row_count) {
            tree_error(item, error, "expected %u values as in the first axis of the zip, found %u",
                       axis->row_count, one.values->len);
            read = false;
        }
        axis->row_count = one.values->len;
        axis->column_count++;
        g_array_append_vals(axis->values, one.values->data, one.values->len);
        g_array_unref(one.values);
        if (!read)
            return false;
    }
    interleave(axis);
    return true;
}

// A path in the sweep file, seen from that file's folder.
static char *beside(const struct tree_node *node)
{
    if (g_path_is_absolute(node->text))
        return g_strdup(node->text);
    char *folder = g_path_get_dirname(node->source);
    char *path = strcmp(folder, ".") == 0 ? g_strdup(node->text)
                                          : g_build_filename(folder, node->text, NULL);
    g_free(folder);
    return path;
}

static bool take_sheet(struct sweep *sweep, struct axis *axis, const struct sheet *sheet,
                       struct error *error)
{
    const char *source = g_string_chunk_insert_const(sweep->strings, sheet->source);
    uint32_t label_column = UINT32_MAX;
    for (uint32_t c = 0; c < sheet->column_count; c++) {
        const struct sheet_cell *head = sheet_cell(sheet, 0, c);
        const struct tree_node place = {
            .source = source, .line = head->line, .column = head->column};
        if (strcmp(head->text, "case") == 0 && label_column == UINT32_MAX)
            label_column = c;
        else if (!add_column(sweep, axis, head->text, &place, error))
            return false;
    }
    if (label_column != UINT32_MAX)
        axis->labels = g_ptr_array_new();
    for (uint32_t r = 1; r <= sheet->row_count; r++) {
        for (uint32_t c = 0; c < sheet->column_count; c++) {
            const struct sheet_cell *cell = sheet_cell(sheet, r, c);
            const struct tree_node place = {
                .source = source, .line = cell->line, .column = cell->column};
            if (cell->text[0] == '\0') {
                tree_error(&place, error, "expected a value for %s, found an empty cell",
                           sheet_cell(sheet, 0, c)->text);
                return false;
            }
            if (c == label_column && strchr(cell->text, ',') != NULL) {
                tree_error(&place, error, "expected a name without commas, found '%s'", cell->text);
                return false;
            }
            if (c == label_column)
                g_ptr_array_add(axis->labels,
                                g_string_chunk_insert_const(sweep->strings, cell->text));
            else
                add_value(sweep, axis, cell->text, &place);
        }
    }
    axis->row_count = sheet->row_count;
    return true;
}

static bool read_csv(struct sweep *sweep, struct axis *axis, const struct tree_node *node,
                     struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind != TREE_SCALAR) {
        tree_error(node, error, "expected the name of a CSV file, found %s",
                   tree_shown(node, shown));
        return false;
    }
    char *path = beside(node);
    struct sheet sheet;
    bool read = sheet_read_file(&sheet, path, SWEEP_CASE_MAX, error) == STATUS_OK &&
                take_sheet(sweep, axis, &sheet, error);
    if (read && axis->column_count == 0) {
        tree_error(node, error, "expected a column headed by the path of a key in %s", path);
        read = false;
    }
    sheet_fini(&sheet);
    g_free(path);
    return read;
}

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
    struct axis axis = {.first_column = sweep->paths->len,
                        .values = g_array_new(FALSE, FALSE, sizeof(struct value))};
    bool read;
    if (entry.zip != NULL) {
        read = read_zip(sweep, &axis, entry.zip, error);
    } else if (entry.csv != NULL) {
        read = read_csv(sweep, &axis, entry.csv, error);
    } else {
        read = read_key(sweep, &axis, &entry, error);
        axis.row_count = axis.values->len;
    }
    g_array_append_val(sweep->axes, axis); // also a broken one, to be released
    return read && count_cases(sweep, node, axis.row_count, error);
}

static bool read_axes(struct sweep *sweep, const struct tree_node *node, struct error *error)
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

// ------------------------------------------------------------------------------------------------
// Base and replicates

static bool read_base(struct sweep *sweep, const struct tree_node *node, struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind != TREE_SCALAR || node->text[0] == '\0') {
        tree_error(node, error, "expected the name of a scenario file, found %s",
                   tree_shown(node, shown));
        return false;
    }
    char *path = beside(node);
    sweep->base_path = g_string_chunk_insert_const(sweep->strings, path);
    // The tree is built to be refused early and with its place if it is not YAML; the cases are
    // read from the text.
    struct tree *tree = tree_load(path, error);
    char *text = NULL;
    gsize size = 0;
    bool read = tree != NULL;
    if (read && tree_child(tree_root(tree), "sweep") != NULL) {
        tree_error(node, error, "expected a scenario, found a sweep in %s", path);
        read = false;
    }
    if (read && !g_file_get_contents(path, &text, &size, NULL)) {
        tree_error(node, error, "expected a file that can be read: %s", path);
        read = false;
    }
    if (read)
        sweep->base = g_string_new_len(text, (gssize)size);
    g_free(text);
    tree_free(tree);
    g_free(path);
    return read;
}

static bool check_overrides(const struct sweep *sweep, struct error *error)
{
    for (size_t i = 0; i < sweep->override_count; i++) {
        for (guint c = 0; c < sweep->paths->len; c++) {
            const char *path = sweep->paths->pdata[c];
            const size_t length = strlen(path);
            if (strncmp(sweep->overrides[i], path, length) != 0 ||
                sweep->overrides[i][length] != '=')
                continue;
            error_set(error, STATUS_INVALID,
                      "--set %s: %s is changed by the sweep: expected a key that is not",
                      sweep->overrides[i], path);
            return false;
        }
    }
    return true;
}

// The base as it is without any axis, for what the sweep needs to know of it.
static bool base_seed(const struct sweep *sweep, uint64_t *seed, struct error *error)
{
    struct scenario scenario;
    if (scenario_read_text(&scenario, sweep->base_path, sweep->base->str, sweep->base->len,
                           sweep->overrides, sweep->override_count, error) != STATUS_OK)
        return false;
    *seed = scenario.search.seed;
    scenario_fini(&scenario);
    return true;
}

static bool add_replicates(struct sweep *sweep, const struct tree_node *place, uint32_t count,
                           struct error *error)
{
    uint64_t seed;
    struct axis axis = {.first_column = sweep->paths->len,
                        .row_count = count,
                        .values = g_array_new(FALSE, FALSE, sizeof(struct value))};
    bool added = add_column(sweep, &axis, "search.seed", place, error) &&
                 base_seed(sweep, &seed, error) && count_cases(sweep, place, count, error);
    for (uint32_t i = 0; added && i < count; i++) {
        char text[32];
        snprintf(text, sizeof text, "%llu", (unsigned long long)(seed + i));
        add_value(sweep, &axis, text, place);
    }
    g_array_append_val(sweep->axes, axis);
    return added;
}

// ------------------------------------------------------------------------------------------------
// Names

static const char *last_key(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL ? dot + 1 : path;
}

// The last key of a path where no other path has the same one, else the whole path.
static void label_columns(struct sweep *sweep)
{
    for (guint i = 0; i < sweep->paths->len; i++) {
        const char *path = sweep->paths->pdata[i], *label = last_key(path);
        for (guint k = 0; k < sweep->paths->len; k++)
            if (k != i && strcmp(label, last_key(sweep->paths->pdata[k])) == 0)
                label = path;
        g_ptr_array_add(sweep->labels, (gpointer)label);
    }
}

// Which row of an axis a case has.
static uint32_t case_row(const struct sweep *sweep, uint32_t index, guint axis)
{
    assert(index < sweep->case_count);
    for (guint i = sweep->axes->len; i-- > axis + 1;)
        index /= g_array_index(sweep->axes, struct axis, i).row_count;
    return index % g_array_index(sweep->axes, struct axis, axis).row_count;
}

static const struct value *axis_value(const struct axis *axis, uint32_t row, uint32_t column)
{
    return &g_array_index(axis->values, struct value, row * axis->column_count + column);
}

static void put_label(const struct sweep *sweep, GString *name, const struct axis *axis,
                      uint32_t row)
{
    if (axis->labels != NULL) {
        g_string_append_printf(name, "%s%s", name->len > 0 ? "," : "",
                               (const char *)axis->labels->pdata[row]);
        return;
    }
    for (uint32_t c = 0; c < axis->column_count; c++) {
        const struct value *value = axis_value(axis, row, c);
        g_string_append_printf(name, "%s%s=", name->len > 0 ? "," : "",
                               (const char *)sweep->labels->pdata[axis->first_column + c]);
        if (value->plain)
            g_string_append(name, value->text);
        else
            g_string_append_printf(name, "#%u", row + 1);
    }
}

const char *sweep_case_name(const struct sweep *sweep, uint32_t index,
                            char name[SWEEP_CASE_NAME_SIZE])
{
    GString *text = g_string_new(NULL);
    for (guint i = 0; i < sweep->axes->len; i++)
        put_label(sweep, text, &g_array_index(sweep->axes, struct axis, i),
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
        const struct axis *axis = &g_array_index(sweep->axes, struct axis, a);
        g_hash_table_remove_all(seen);
        for (uint32_t row = 0; row < axis->row_count && unique; row++) {
            GString *name = g_string_new(NULL);
            put_label(sweep, name, axis, row);
            const struct value *value = axis_value(axis, row, 0);
            const struct tree_node place = {
                .source = value->source, .line = value->line, .column = value->column};
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

// ------------------------------------------------------------------------------------------------
// Reading

bool sweep_detect(const char *path)
{
    struct error unread;
    struct tree *tree = tree_load(path, &unread);
    const bool found = tree != NULL && tree_child(tree_root(tree), "sweep") != NULL;
    tree_free(tree);
    return found;
}

static bool read_document(struct sweep *sweep, struct error *error)
{
    static const struct field fields[] = {
        {"sweep", FIELD_NAME, false, offsetof(struct document, name), FIELD_ANY, NULL, NULL,
         "the sweep's name"},
        {"base", FIELD_NODE, false, offsetof(struct document, base), FIELD_ANY, NULL, NULL,
         "the name of a scenario file"},
        {"axes", FIELD_NODE, true, offsetof(struct document, axes), FIELD_ANY, NULL, NULL, NULL},
        {"replicates", FIELD_COUNT, true, offsetof(struct document, replicates),
         FIELD_FROM_TO(1, SWEEP_CASE_MAX), NULL, NULL, NULL},
    };
    const struct tree_node *root = tree_root(sweep->tree);
    struct document document = {0};
    if (!field_read(root, fields, G_N_ELEMENTS(fields), &document, error))
        return false;
    memcpy(sweep->name, document.name, sizeof sweep->name);
    if (document.axes == NULL && document.replicates == 0) {
        tree_error(root, error, "missing key 'axes': expected a list of axes, or `replicates`");
        return false;
    }
    if (!read_base(sweep, document.base, error) ||
        (document.axes != NULL && !read_axes(sweep, document.axes, error)))
        return false;
    if (document.replicates > 0 &&
        !add_replicates(sweep, tree_child(root, "replicates"), document.replicates, error))
        return false;
    label_columns(sweep);
    return check_overrides(sweep, error) && check_names(sweep, error);
}

enum status sweep_read_file(struct sweep **result, const char *path, const char *const *overrides,
                            size_t override_count, struct error *error)
{
    *result = NULL;
    struct error unread;
    error = error != NULL ? error : &unread;
    struct sweep *sweep = g_new0(struct sweep, 1);
    sweep->strings = g_string_chunk_new(4096);
    sweep->axes = g_array_new(FALSE, FALSE, sizeof(struct axis));
    sweep->paths = g_ptr_array_new_null_terminated(0, NULL, TRUE);
    sweep->labels = g_ptr_array_new();
    sweep->case_count = 1;
    const char **kept = g_new(const char *, override_count + 1);
    for (size_t i = 0; i < override_count; i++)
        kept[i] = g_string_chunk_insert(sweep->strings, overrides[i]);
    sweep->overrides = kept;
    sweep->override_count = override_count;
    sweep->tree = tree_load(path, error);
    if (sweep->tree == NULL || !read_document(sweep, error)) {
        sweep_free(sweep);
        return STATUS_INVALID;
    }
    *result = sweep;
    return STATUS_OK;
}

void sweep_free(struct sweep *sweep)
{
    if (sweep == NULL)
        return;
    for (guint i = 0; i < sweep->axes->len; i++) {
        struct axis *axis = &g_array_index(sweep->axes, struct axis, i);
        g_array_unref(axis->values);
        if (axis->labels != NULL)
            g_ptr_array_unref(axis->labels);
    }
    g_array_unref(sweep->axes);
    g_ptr_array_unref(sweep->paths);
    g_ptr_array_unref(sweep->labels);
    if (sweep->base != NULL)
        g_string_free(sweep->base, TRUE);
    g_free((gpointer)sweep->overrides);
    g_string_chunk_free(sweep->strings);
    tree_free(sweep->tree);
    g_free(sweep);
}

const char *sweep_name(const struct sweep *sweep)
{
    return sweep->name;
}

uint32_t sweep_case_count(const struct sweep *sweep)
{
    return sweep->case_count;
}

const char *const *sweep_columns(const struct sweep *sweep)
{
    return (const char *const *)sweep->paths->pdata;
}

uint32_t sweep_column_count(const struct sweep *sweep)
{
    return sweep->paths->len;
}

// ------------------------------------------------------------------------------------------------
// Cases

static const struct value *case_value(const struct sweep *sweep, uint32_t index, uint32_t column)
{
    guint a = 0;
    const struct axis *axis = &g_array_index(sweep->axes, struct axis, 0);
    while (column >= axis->first_column + axis->column_count)
        axis = &g_array_index(sweep->axes, struct axis, ++a);
    return axis_value(axis, case_row(sweep, index, a), column - axis->first_column);
}

const char *sweep_value(const struct sweep *sweep, uint32_t index, uint32_t column)
{
    assert(column < sweep->paths->len);
    return case_value(sweep, index, column)->text;
}

// The reader knows the values of a case as --set options. Where the message begins with one of
// them, it is to begin with the place in the sweep file.
static void point_at_sweep(const struct sweep *sweep, uint32_t index, struct error *error)
{
    for (guint c = 0; c < sweep->paths->len; c++) {
        const struct value *value = case_value(sweep, index, c);
        char *option = g_strdup_printf("--set %s=", (const char *)sweep->paths->pdata[c]);
        const bool here = g_str_has_prefix(error->text, option);
        // The place within the option follows what is shown of it: the first ":N:N: " behind.
        const char *rest = here ? error->text + strlen(option) : NULL;
        g_free(option);
        for (; here && *rest != '\0'; rest++) {
            unsigned line, column;
            int length = 0;
            if (*rest != ':' || sscanf(rest, ":%u:%u: %n", &line, &column, &length) != 2 ||
                length == 0)
                continue;
            char *message = g_strdup(rest + length);
            error_set(error, STATUS_INVALID, "%s:%u:%u: %s", value->source, value->line,
                      value->column, message);
            g_free(message);
            return;
        }
    }
}

enum status sweep_scenario(const struct sweep *sweep, uint32_t index, struct scenario *scenario,
                           struct error *error)
{
    struct error reason = {0};
    GPtrArray *overrides = g_ptr_array_new_with_free_func(g_free);
    for (size_t i = 0; i < sweep->override_count; i++)
        g_ptr_array_add(overrides, g_strdup(sweep->overrides[i]));
    for (guint c = 0; c < sweep->paths->len; c++)
        g_ptr_array_add(overrides, g_strdup_printf("%s=%s", (const char *)sweep->paths->pdata[c],
                                                   sweep_value(sweep, index, c)));
    enum status status =
        scenario_read_text(scenario, sweep->base_path, sweep->base->str, sweep->base->len,
                           (const char *const *)overrides->pdata, overrides->len, &reason);
    g_ptr_array_unref(overrides);
    if (status == STATUS_OK)
        return STATUS_OK;
    point_at_sweep(sweep, index, &reason);
    char name[SWEEP_CASE_NAME_SIZE];
    return error_set(error, status, "%s (in the case %s of %s)", reason.text,
                     sweep_case_name(sweep, index, name), tree_root(sweep->tree)->source);
}
