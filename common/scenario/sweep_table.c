#include "common/scenario/sweep_state.h"
#include "common/table/csv.h"

#include <glib.h>
#include <string.h>

enum { NO_COLUMN = -1 };

// The reading in progress.
struct table {
    struct sweep *sweep;
    struct sweep_axis *axis;
    struct csv csv;
    const char *source;    // as long as the sweep
    uint32_t column_count; // as the header has them
    int32_t label_column;  // headed `case`; NO_COLUMN: there is none
};

char *sweep_table_path(const struct tree_node *node)
{
    if (g_path_is_absolute(node->text))
        return g_strdup(node->text);
    char *folder = g_path_get_dirname(node->source);
    char *path = strcmp(folder, ".") == 0 ? g_strdup(node->text)
                                          : g_build_filename(folder, node->text, NULL);
    g_free(folder);
    return path;
}

static struct tree_node place_of(const struct table *table, const struct csv_field *field)
{
    return (struct tree_node){.source = table->source,
                              .line = (uint32_t)table->csv.line,
                              .column = csv_column(&table->csv, field->text)};
}

// The text of a cell, which lives as long as the sweep; NULL with `error` filled. A control
// character would spoil the messages and tables in which the text appears.
static const char *cell_text(const struct table *table, const struct csv_field *field,
                             struct error *error)
{
    for (const char *c = field->text; c < field->text + field->size; c++) {
        if ((unsigned char)*c >= 0x20 && *c != 0x7f)
            continue;
        csv_error_at(&table->csv, c, error, "expected text, found the control character 0x%02x",
                     (unsigned char)*c);
        return NULL;
    }
    char *text = csv_text(field);
    const char *kept = g_string_chunk_insert_const(table->sweep->strings, text);
    g_free(text);
    return kept;
}

static bool take_header(struct table *table, struct error *error)
{
    struct csv *csv = &table->csv;
    if (csv_row(csv, error) != STATUS_OK)
        return false;
    if (csv->field_count == 0) {
        error_set(error, STATUS_INVALID, "%s:1:1: expected a header and rows, found nothing",
                  table->source);
        return false;
    }
    for (uint32_t i = 0; i < csv->field_count; i++) {
        const struct csv_field *head = &csv->fields[i];
        const struct tree_node place = place_of(table, head);
        const char *text = cell_text(table, head, error);
        if (text == NULL)
            return false;
        if (table->label_column == NO_COLUMN && csv_is(head, "case"))
            table->label_column = (int32_t)i;
        else if (!sweep_axes_add_column(table->sweep, table->axis, text, &place, error))
            return false;
    }
    table->column_count = csv->field_count;
    if (table->label_column != NO_COLUMN)
        table->axis->labels = g_ptr_array_new();
    return true;
}

static bool take_label(const struct table *table, const struct csv_field *field, const char *text,
                       struct error *error)
{
    g_ptr_array_add(table->axis->labels, (gpointer)text);
    return strchr(text, ',') == NULL ||
           csv_error_at(&table->csv, field->text, error,
                        "expected a name without commas, found '%s'", text) == STATUS_OK;
}

// What heads a column.
static const char *head_of(const struct table *table, uint32_t column)
{
    if ((int32_t)column == table->label_column)
        return "case";
    const bool behind = table->label_column != NO_COLUMN && (int32_t)column > table->label_column;
    return table->sweep->paths->pdata[table->axis->first_column + column - behind];
}

static bool take_cell(const struct table *table, uint32_t column, struct error *error)
{
    const struct csv_field *field = &table->csv.fields[column];
    const char *text = cell_text(table, field, error);
    if (text == NULL)
        return false;
    if ((int32_t)column == table->label_column && text[0] != '\0')
        return take_label(table, field, text, error);
    if (text[0] == '\0') {
        csv_error_at(&table->csv, field->text, error,
                     "expected a value for %s, found an empty cell", head_of(table, column));
        return false;
    }
    const struct tree_node place = place_of(table, field);
    return sweep_cell_add_text(table->sweep, table->axis, text, &place, error);
}

static bool take_rows(struct table *table, struct error *error)
{
    struct csv *csv = &table->csv;
    for (;;) {
        if (csv_row(csv, error) != STATUS_OK)
            return false;
        if (csv->field_count == 0)
            break;
        if (table->axis->row_count == SWEEP_CASE_MAX) {
            csv_error_at(csv, csv->line_begin, error, "expected at most %d rows", SWEEP_CASE_MAX);
            return false;
        }
        if (csv->field_count != table->column_count) {
            csv_error_at(csv, csv->line_begin, error,
                         "expected %u cells as in the header, found %u", table->column_count,
                         csv->field_count);
            return false;
        }
        for (uint32_t i = 0; i < csv->field_count; i++)
            if (!take_cell(table, i, error))
                return false;
        table->axis->row_count++;
    }
    if (table->axis->row_count == 0)
        csv_error(csv, 0, error, "expected rows below the header, found none");
    return table->axis->row_count > 0;
}

static bool take_text(struct sweep *sweep, struct sweep_axis *axis, const char *path,
                      const char *text, size_t size, struct error *error)
{
    struct table table = {.sweep = sweep,
                          .axis = axis,
                          .source = g_string_chunk_insert_const(sweep->strings, path),
                          .label_column = NO_COLUMN};
    csv_start(&table.csv, table.source, text, size);
    return take_header(&table, error) && take_rows(&table, error);
}

bool sweep_table_read(struct sweep *sweep, struct sweep_axis *axis, const struct tree_node *node,
                      struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind != TREE_SCALAR) {
        tree_error(node, error, "expected the name of a CSV file, found %s",
                   tree_shown(node, shown));
        return false;
    }
    char *path = sweep_table_path(node);
    size_t size;
    char *text = csv_load(path, &size, error);
    bool read = text != NULL && take_text(sweep, axis, path, text, size, error);
    if (read && axis->column_count == 0) {
        tree_error(node, error, "expected a column headed by the path of a key in %s", path);
        read = false;
    }
    g_free(text);
    g_free(path);
    return read;
}
