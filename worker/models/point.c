#include "worker/models/point.h"

#include "common/table/csv.h"

#include <glib.h>
#include <math.h>

enum column { COLUMN_VARIABLE, COLUMN_VALUE, COLUMN_COUNT };

static const char header_text[] = "variable,value";

void point_place(double *values, const struct scenario *scenario, enum design_place place)
{
    const struct box *space = &scenario->design_space;
    for (uint32_t i = 0; i < space->count; i++) {
        const double shares[] = {
            [DESIGN_CENTRE] = 0.5 * space->lower[i] + 0.5 * space->upper[i],
            [DESIGN_LOWER] = space->lower[i],
            [DESIGN_UPPER] = space->upper[i],
        };
        values[i] = shares[place];
    }
}

static enum status parse_header(struct csv *csv, struct error *error)
{
    if (csv_row(csv, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (csv->field_count == COLUMN_COUNT && csv_is(&csv->fields[COLUMN_VARIABLE], "variable") &&
        csv_is(&csv->fields[COLUMN_VALUE], "value")) {
        return STATUS_OK;
    }
    return csv_error(csv, 0, error, "expected the header %s", header_text);
}

// Takes a row in. Values that no row gave yet are NaN.
static enum status parse_row(double *values, const struct scenario *scenario, const struct csv *csv,
                             struct error *error)
{
    if (csv->field_count != COLUMN_COUNT) {
        return csv_error(csv, MIN(csv->field_count, COLUMN_COUNT), error,
                         "expected 2 fields (%s), found %u", header_text, csv->field_count);
    }
    const struct csv_field *name = &csv->fields[COLUMN_VARIABLE];
    char shown[CSV_SHOWN_SIZE];
    uint32_t i = 0;
    while (i < scenario->design_space.count && !csv_is(name, scenario->variables[i].name)) {
        i++;
    }
    if (i == scenario->design_space.count) {
        return csv_error(csv, COLUMN_VARIABLE, error,
                         "variable: expected one of the scenario, as %s; found \"%s\"",
                         scenario->variables[0].name, csv_shown(name, shown));
    }
    if (!isnan(values[i])) {
        return csv_error(csv, COLUMN_VARIABLE, error, "variable %s: expected one value, found two",
                         scenario->variables[i].name);
    }
    return csv_number(csv, COLUMN_VALUE, "value", "the variable's unit", &values[i], error);
}

static enum status fill_fixed(double *values, const struct scenario *scenario,
                              const struct csv *csv, struct error *error)
{
    const struct box *space = &scenario->design_space;
    for (uint32_t i = 0; i < space->count; i++) {
        if (!isnan(values[i])) {
            continue;
        }
        if (space->lower[i] < space->upper[i]) {
            return csv_error(csv, 0, error, "variable %s: expected a value, found none",
                             scenario->variables[i].name);
        }
        values[i] = space->lower[i];
    }
    return STATUS_OK;
}

enum status point_parse(double *values, const struct scenario *scenario, const char *source,
                        const char *text, size_t size, struct error *error)
{
    struct csv csv;
    csv_start(&csv, source, text, size);
    for (uint32_t i = 0; i < scenario->design_space.count; i++) {
        values[i] = NAN;
    }
    if (parse_header(&csv, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    for (;;) {
        if (csv_row(&csv, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
        if (csv.field_count == 0) {
            return fill_fixed(values, scenario, &csv, error);
        }
        if (parse_row(values, scenario, &csv, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
}
