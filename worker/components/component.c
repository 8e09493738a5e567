#include "worker/components/component.h"
#include "worker/components/columns.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum column {
    COLUMN_NAME,
    COLUMN_GROUP,
    COLUMN_X_MIN,
    COLUMN_X_MAX,
    COLUMN_Y_MIN,
    COLUMN_Y_MAX,
    COLUMN_Z_MIN,
    COLUMN_Z_MAX,
    COLUMN_FORCE_X,
    COLUMN_FORCE_Y,
    COLUMN_COUNT
};

static const struct columns_name columns[COLUMN_COUNT] = {
    [COLUMN_NAME] = {"name", false},        [COLUMN_GROUP] = {"group", true},
    [COLUMN_X_MIN] = {"x_min_m", false},    [COLUMN_X_MAX] = {"x_max_m", false},
    [COLUMN_Y_MIN] = {"y_min_m", false},    [COLUMN_Y_MAX] = {"y_max_m", false},
    [COLUMN_Z_MIN] = {"z_min_m", false},    [COLUMN_Z_MAX] = {"z_max_m", false},
    [COLUMN_FORCE_X] = {"force_x_N", true}, [COLUMN_FORCE_Y] = {"force_y_N", true},
};

static const char expected_columns[] = "expected the columns name, x_min_m, x_max_m, y_min_m, "
                                       "y_max_m, z_min_m and z_max_m, and any of group, force_x_N "
                                       "and force_y_N";

// No car reaches so far from its centre of gravity; a box in millimetres does. [m]
static const double farthest = 10.0;

// ---- A row ----

static enum status parse_name(const struct csv *csv, uint32_t at, enum column column,
                              char name[SCENARIO_NAME_SIZE], struct error *error)
{
    return columns_identifier(csv, at, &columns[column], name, SCENARIO_NAME_SIZE, error);
}

static enum status parse_coordinate(const struct csv *csv, uint32_t at, enum column column,
                                    double *number, struct error *error)
{
    if (csv_number(csv, at, columns[column].name, "m", number, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    const bool height = column == COLUMN_Z_MIN || column == COLUMN_Z_MAX;
    const double least = height ? 0.0 : -farthest;
    if (!(*number >= least && *number <= farthest)) {
        return csv_error(csv, at, error, "%s: expected %s within %g .. %g m, found %g%s",
                         columns[column].name, height ? "a height above the road" : "a place",
                         least, farthest, *number,
                         fabs(*number) > farthest ? " (in millimetres?)" : "");
    }
    return STATUS_OK;
}

static enum status parse_box(const struct csv *csv, const uint32_t place[COLUMN_COUNT],
                             struct component_box *box, struct error *error)
{
    for (int axis = 0; axis < COMPONENT_AXIS_COUNT; axis++) {
        const enum column low = COLUMN_X_MIN + 2 * axis;
        const enum column high = low + 1;
        if (parse_coordinate(csv, place[low], low, &box->min[axis], error) != STATUS_OK ||
            parse_coordinate(csv, place[high], high, &box->max[axis], error) != STATUS_OK) {
            return STATUS_INVALID;
        }
        if (!(box->max[axis] > box->min[axis])) {
            return csv_error(csv, place[high], error, "%s: expected more than %s, %g m, found %g",
                             columns[high].name, columns[low].name, box->min[axis], box->max[axis]);
        }
    }
    return STATUS_OK;
}

// An empty cell of a force, or none, means that nobody knows it yet.
static enum status parse_force(const struct csv *csv, uint32_t at, enum column column,
                               double *force, struct error *error)
{
    *force = NAN;
    if (at == COLUMNS_ABSENT || csv->fields[at].size == 0) {
        return STATUS_OK;
    }
    if (csv_number(csv, at, columns[column].name, "N", force, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (*force < 0.0) {
        return csv_error(csv, at, error, "%s: expected at least 0 N, found %g",
                         columns[column].name, *force);
    }
    return STATUS_OK;
}

static enum status check_new(const struct csv *csv, uint32_t at, const struct component_list *list,
                             struct error *error)
{
    const char *name = list->items[list->count].name;
    for (uint32_t i = 0; i < list->count; i++) {
        if (strcmp(list->items[i].name, name) == 0) {
            return csv_error(csv, at, error,
                             "name: expected a name that no other component has, found %s", name);
        }
    }
    return STATUS_OK;
}

static enum status parse_row(const struct csv *csv, const uint32_t place[COLUMN_COUNT],
                             struct component_list *list, struct error *error)
{
    if (list->count == COMPONENT_MAX) {
        return csv_error(csv, 0, error, "expected at most %d components", COMPONENT_MAX);
    }
    struct component *item = &list->items[list->count];
    *item = (struct component){.line = csv->line};
    if (parse_name(csv, place[COLUMN_NAME], COLUMN_NAME, item->name, error) != STATUS_OK ||
        check_new(csv, place[COLUMN_NAME], list, error) != STATUS_OK ||
        (place[COLUMN_GROUP] != COLUMNS_ABSENT &&
         parse_name(csv, place[COLUMN_GROUP], COLUMN_GROUP, item->group, error) != STATUS_OK) ||
        parse_box(csv, place, &item->box, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
        const enum column column = COLUMN_FORCE_X + k;
        if (parse_force(csv, place[column], column, &item->force[k], error) != STATUS_OK) {
            return STATUS_INVALID;
        }
        list->forces = list->forces && !isnan(item->force[k]);
    }
    list->count++;
    return STATUS_OK;
}

enum status component_parse(struct component_list *list, const char *source, const char *text,
                            size_t size, struct error *error)
{
    struct csv csv;
    uint32_t place[COLUMN_COUNT];
    csv_start(&csv, source, text, size);
    list->source = source;
    list->count = 0;
    list->forces = true;
    if (columns_read(&csv, columns, COLUMN_COUNT, expected_columns, place, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    const uint32_t field_count = csv.field_count;
    do {
        if (columns_row(&csv, field_count, error) != STATUS_OK ||
            (csv.field_count > 0 && parse_row(&csv, place, list, error) != STATUS_OK)) {
            return STATUS_INVALID;
        }
    } while (csv.field_count > 0);
    return list->count > 0 ? STATUS_OK
                           : csv_error(&csv, 0, error, "expected at least one component");
}
