#include "coordinator/evaluation/designs.h"

#include "common/table/csv.h"
#include "common/table/decimal.h"

#include <glib.h>
#include <stdbool.h>
#include <string.h>

// ---- The header ----

static enum status take_column(struct designs_layout *layout, GHashTable *numbers,
                               const struct csv *csv, const struct csv_field *field,
                               GArray *columns, struct error *error)
{
    char shown[CSV_SHOWN_SIZE];
    int32_t column = DESIGNS_ID;
    if (!csv_is(field, "id")) {
        g_autofree char *name = csv_text(field);
        gpointer number;
        if (!g_hash_table_lookup_extended(numbers, name, NULL, &number))
            return csv_error_at(csv, field->text, error,
                                "expected the name of a variable of the scenario, as %s, or id; "
                                "found \"%s\"",
                                layout->scenario->variables[0].name, csv_shown(field, shown));
        column = GPOINTER_TO_INT(number);
    }
    for (guint i = 0; i < columns->len; i++)
        if (g_array_index(columns, int32_t, i) == column)
            return csv_error_at(csv, field->text, error, "expected one column %s, found a second",
                                csv_shown(field, shown));
    if (column == DESIGNS_ID)
        layout->id = (int32_t)columns->len;
    g_array_append_val(columns, column);
    return STATUS_OK;
}

// A variable may only be left out where there is nothing to choose.
static enum status check_complete(const struct designs_layout *layout, const struct csv *csv,
                                  struct error *error)
{
    const struct scenario *scenario = layout->scenario;
    const struct box *space = &scenario->design_space;
    g_autofree bool *there = g_new0(bool, space->count);
    for (uint32_t i = 0; i < layout->column_count; i++)
        if (layout->columns[i] != DESIGNS_ID)
            there[layout->columns[i]] = true;
    for (uint32_t i = 0; i < space->count; i++)
        if (!there[i] && space->lower[i] < space->upper[i])
            return csv_error_at(csv, csv->line_end, error,
                                "expected a column for every variable that is not fixed: %s is "
                                "missing",
                                scenario->variables[i].name);
    return STATUS_OK;
}

enum status designs_layout_read(struct designs_layout *layout, const struct scenario *scenario,
                                const char *source, uint64_t line, const char *text, size_t size,
                                struct error *error)
{
    struct csv csv;
    csv_start(&csv, source, text, size);
    csv.line = line - 1;
    *layout = (struct designs_layout){.scenario = scenario, .id = -1};
    GHashTable *numbers = g_hash_table_new(g_str_hash, g_str_equal);
    for (uint32_t i = 0; i < scenario->design_space.count; i++)
        g_hash_table_insert(numbers, scenario->variables[i].name, GINT_TO_POINTER((int)i));
    GArray *columns = g_array_new(FALSE, FALSE, sizeof(int32_t));
    enum status status = STATUS_OK;
    csv_line(&csv);
    while (status == STATUS_OK && csv.at != NULL) {
        struct csv_field field;
        status = csv_next(&csv, &field, error);
        if (status == STATUS_OK)
            status = take_column(layout, numbers, &csv, &field, columns, error);
    }
    layout->column_count = columns->len;
    layout->columns = (int32_t *)(void *)g_array_free(columns, FALSE);
    g_hash_table_unref(numbers);
    if (status == STATUS_OK)
        status = check_complete(layout, &csv, error);
    if (status != STATUS_OK)
        designs_layout_fini(layout);
    return status;
}

void designs_layout_fini(struct designs_layout *layout)
{
    g_free(layout->columns);
    *layout = (struct designs_layout){0};
}

// ---- The rows ----

// Says how many fields there are, of which `found` were read.
static enum status refuse_count(const struct designs_layout *layout, struct csv *csv,
                                uint32_t found, struct error *error)
{
    struct csv_field field;
    while (csv->at != NULL && csv_next(csv, &field, NULL) == STATUS_OK)
        found++;
    return csv_error_at(
        csv, csv->line_end, error, "expected %u field%s, as in the header, found %u%s",
        layout->column_count, layout->column_count == 1 ? "" : "s", found,
        found < layout->column_count ? ": the line is cut off, or a value is missing" : "");
}

static enum status read_field(const struct designs_layout *layout, struct csv *csv,
                              int32_t variable, double *values, struct csv_field *id,
                              struct error *error)
{
    struct csv_field field;
    if (csv_next(csv, &field, error) != STATUS_OK)
        return STATUS_INVALID;
    if (variable == DESIGNS_ID) {
        *id = field;
        return field.quoted || memchr(field.text, '"', field.size) != NULL
                   ? csv_error_at(csv, field.text, error, "id: expected a text without quotes")
                   : STATUS_OK;
    }
    char shown[CSV_SHOWN_SIZE];
    return decimal_read(field.text, field.size, &values[variable])
               ? STATUS_OK
               : csv_error_at(csv, field.text, error, "%s: expected a finite number, found \"%s\"",
                              layout->scenario->variables[variable].name, csv_shown(&field, shown));
}

static enum status read_row(const struct designs_layout *layout, struct csv *csv, double *values,
                            struct csv_field *id, struct error *error)
{
    for (uint32_t column = 0; column < layout->column_count; column++) {
        if (csv->at == NULL)
            return refuse_count(layout, csv, column, error);
        if (read_field(layout, csv, layout->columns[column], values, id, error) != STATUS_OK)
            return STATUS_INVALID;
    }
    return csv->at == NULL ? STATUS_OK : refuse_count(layout, csv, layout->column_count, error);
}

static uint32_t lines_of(const char *text, size_t size)
{
    uint32_t lines = 0;
    const char *end = text + size;
    for (const char *at = text; at < end; lines++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        at = newline != NULL ? newline + 1 : end;
    }
    return lines;
}

enum status designs_read(struct designs *designs, const struct designs_layout *layout,
                         const char *source, uint64_t line, const char *text, size_t size,
                         struct error *error)
{
    const struct box *space = &layout->scenario->design_space;
    const size_t row_size = space->count * sizeof(double);
    const uint32_t room = lines_of(text, size);
    struct csv csv;
    csv_start(&csv, source, text, size);
    csv.line = line - 1;
    *designs = (struct designs){.values = g_malloc_n(room, row_size)};
    if (layout->id >= 0) {
        designs->ids = g_new(const char *, room);
        designs->id_sizes = g_new(uint32_t, room);
    }
    while (csv_line(&csv)) {
        double *values = designs->values + designs->count * (size_t)space->count;
        struct csv_field id = {0};
        memcpy(values, space->lower, row_size); // of the variables without a column all there is
        if (read_row(layout, &csv, values, &id, error) != STATUS_OK) {
            designs_fini(designs);
            return STATUS_INVALID;
        }
        if (designs->ids != NULL) {
            designs->ids[designs->count] = id.text;
            designs->id_sizes[designs->count] = (uint32_t)id.size;
        }
        designs->count++;
    }
    return STATUS_OK;
}

void designs_fini(struct designs *designs)
{
    g_free(designs->values);
    g_free((void *)designs->ids);
    g_free(designs->id_sizes);
    *designs = (struct designs){0};
}
