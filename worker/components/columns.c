#include "worker/components/columns.h"

#include <glib.h>
#include <string.h>

static uint32_t find(const struct columns_name *columns, uint32_t count,
                     const struct csv_field *field)
{
    uint32_t column = 0;
    while (column < count && !csv_is(field, columns[column].name)) {
        column++;
    }
    return column;
}

enum status columns_read(struct csv *csv, const struct columns_name *columns, uint32_t count,
                         const char *expected, uint32_t *place, struct error *error)
{
    char shown[CSV_SHOWN_SIZE];
    if (csv_row(csv, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    for (uint32_t column = 0; column < count; column++) {
        place[column] = COLUMNS_ABSENT;
    }
    for (uint32_t i = 0; i < csv->field_count; i++) {
        const struct csv_field *field = &csv->fields[i];
        const uint32_t column = find(columns, count, field);
        if (column == count) {
            return csv_error(csv, i, error, "%s, found \"%s\"", expected, csv_shown(field, shown));
        }
        if (place[column] != COLUMNS_ABSENT) {
            return csv_error(csv, i, error, "expected the column %s once", columns[column].name);
        }
        place[column] = i;
    }
    for (uint32_t column = 0; column < count; column++) {
        if (place[column] == COLUMNS_ABSENT && !columns[column].optional) {
            return csv_error(csv, csv->field_count, error, "%s, found no %s", expected,
                             columns[column].name);
        }
    }
    return STATUS_OK;
}

enum status columns_row(struct csv *csv, uint32_t field_count, struct error *error)
{
    if (csv_row(csv, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (csv->field_count != 0 && csv->field_count != field_count) {
        return csv_error(csv, csv->field_count, error,
                         "expected %u fields as in the header, found %u", field_count,
                         csv->field_count);
    }
    return STATUS_OK;
}

enum status columns_identifier(const struct csv *csv, uint32_t field,
                               const struct columns_name *column, char *name, size_t size,
                               struct error *error)
{
    char shown[CSV_SHOWN_SIZE];
    const struct csv_field *at = &csv->fields[field];
    bool good = at->size < size;
    for (size_t i = 0; good && i < at->size; i++) {
        const char c = at->text[i];
        good = g_ascii_isalnum(c) || c == '_' || c == '-';
    }
    if (!good || (at->size == 0 && !column->optional)) {
        return csv_error(csv, field, error,
                         "%s: expected a name of 1 to %d letters, digits, '_' or '-', found \"%s\"",
                         column->name, (int)size - 1, csv_shown(at, shown));
    }
    memcpy(name, at->text, at->size);
    name[at->size] = '\0';
    return STATUS_OK;
}
