#include "worker/components/reference.h"
#include "worker/components/columns.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum column {
    COLUMN_SPRING,
    COLUMN_BRANCH,
    COLUMN_DEFORMATION,
    COLUMN_FORCE_X,
    COLUMN_FORCE_Y,
    COLUMN_COUNT
};

static const struct columns_name columns[COLUMN_COUNT] = {
    [COLUMN_SPRING] = {"spring", false},
    [COLUMN_BRANCH] = {"branch", true},
    [COLUMN_DEFORMATION] = {"deformation_m", false},
    [COLUMN_FORCE_X] = {"force_x_N", false},
    [COLUMN_FORCE_Y] = {"force_y_N", true},
};

static const char expected_columns[] =
    "expected the columns spring, deformation_m and force_x_N, and any of force_y_N and branch";

// Samples nearer than this along the deformation are jitter. [m]
static const double step_min = 1e-4;

// No structure is crushed so far; a table in millimetres is. [m]
static const double farthest = 10.0;

static void item_fini(struct reference *item)
{
    g_free(item->deformation);
    for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
        g_free(item->force[k]);
    }
}

void reference_fini(struct reference_list *list)
{
    for (uint32_t i = 0; i < list->count; i++) {
        item_fini(&list->items[i]);
    }
    *list = (struct reference_list){0};
}

static uint32_t find(const struct reference_list *list, const char *name)
{
    uint32_t at = 0;
    while (at < list->count && strcmp(list->items[at].name, name) != 0) {
        at++;
    }
    return at;
}

const struct reference *reference_find(const struct reference_list *list, const char *name)
{
    const uint32_t at = find(list, name);
    return at < list->count ? &list->items[at] : NULL;
}

// The curve that the row belongs to, or NULL with the error set.
static struct reference *row_curve(const struct csv *csv, const uint32_t place[COLUMN_COUNT],
                                   struct reference_list *list, struct error *error)
{
    char name[SCENARIO_NAME_SIZE];
    if (columns_identifier(csv, place[COLUMN_SPRING], &columns[COLUMN_SPRING], name, sizeof name,
                           error) != STATUS_OK) {
        return NULL;
    }
    const uint32_t at = find(list, name);
    if (at == REFERENCE_MAX) {
        csv_error(csv, place[COLUMN_SPRING], error, "expected at most %d springs", REFERENCE_MAX);
        return NULL;
    }
    if (at == list->count) {
        memcpy(list->items[list->count++].name, name, sizeof name);
    }
    return &list->items[at];
}

static enum status parse_numbers(const struct csv *csv, const uint32_t place[COLUMN_COUNT],
                                 double *deformation, double force[SCENARIO_DIRECTION_COUNT],
                                 struct error *error)
{
    const uint32_t at = place[COLUMN_DEFORMATION];
    if (csv_number(csv, at, columns[COLUMN_DEFORMATION].name, "m", deformation, error) !=
        STATUS_OK) {
        return STATUS_INVALID;
    }
    if (fabs(*deformation) > farthest) {
        return csv_error(csv, at, error,
                         "deformation_m: expected at most %g m, found %g (in millimetres?)",
                         farthest, *deformation);
    }
    for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
        const enum column column = COLUMN_FORCE_X + k;
        force[k] = 0.0;
        if (place[column] != COLUMNS_ABSENT && csv_number(csv, place[column], columns[column].name,
                                                          "N", &force[k], error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    return STATUS_OK;
}

// A structure is crushed once: what does not go further is passed over.
static void add(struct reference *curve, double deformation,
                const double force[SCENARIO_DIRECTION_COUNT])
{
    const uint32_t last = curve->count;
    if (last > 0 && deformation - curve->deformation[last - 1] < step_min) {
        curve->passed++;
        return;
    }
    curve->count++;
    curve->deformation = g_renew(double, curve->deformation, curve->count);
    curve->deformation[last] = deformation;
    for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
        curve->force[k] = g_renew(double, curve->force[k], curve->count);
        curve->force[k][last] = force[k];
    }
}

static enum status parse_row(const struct csv *csv, const uint32_t place[COLUMN_COUNT],
                             struct reference_list *list, struct error *error)
{
    const uint32_t branch = place[COLUMN_BRANCH];
    if (branch != COLUMNS_ABSENT && csv_is(&csv->fields[branch], "unload")) {
        return STATUS_OK;
    }
    if (branch != COLUMNS_ABSENT && !csv_is(&csv->fields[branch], "load")) {
        return csv_error(csv, branch, error, "branch: expected load or unload");
    }
    double deformation;
    double force[SCENARIO_DIRECTION_COUNT];
    struct reference *curve = row_curve(csv, place, list, error);
    if (curve == NULL || parse_numbers(csv, place, &deformation, force, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (curve->count == REFERENCE_POINT_MAX) {
        return csv_error(csv, 0, error, "expected at most %d points of a spring",
                         REFERENCE_POINT_MAX);
    }
    add(curve, deformation, force);
    return STATUS_OK;
}

static enum status parse_rows(struct csv *csv, const uint32_t place[COLUMN_COUNT],
                              struct reference_list *list, struct error *error)
{
    const uint32_t field_count = csv->field_count;
    do {
        if (columns_row(csv, field_count, error) != STATUS_OK ||
            (csv->field_count > 0 && parse_row(csv, place, list, error) != STATUS_OK)) {
            return STATUS_INVALID;
        }
    } while (csv->field_count > 0);
    return STATUS_OK;
}

static enum status check_curves(const struct csv *csv, const struct reference_list *list,
                                struct error *error)
{
    if (list->count == 0) {
        return csv_error(csv, 0, error, "expected a curve of at least one spring");
    }
    for (uint32_t i = 0; i < list->count; i++) {
        if (list->items[i].count < 2) {
            return csv_error(csv, 0, error,
                             "spring %s: expected at least 2 points that ascend by 0.1 mm",
                             list->items[i].name);
        }
    }
    return STATUS_OK;
}

enum status reference_parse(struct reference_list *list, const char *source, const char *text,
                            size_t size, struct error *error)
{
    struct csv csv;
    uint32_t place[COLUMN_COUNT];
    *list = (struct reference_list){0};
    csv_start(&csv, source, text, size);
    if (columns_read(&csv, columns, COLUMN_COUNT, expected_columns, place, error) != STATUS_OK ||
        parse_rows(&csv, place, list, error) != STATUS_OK ||
        check_curves(&csv, list, error) != STATUS_OK) {
        reference_fini(list);
        return STATUS_INVALID;
    }
    return STATUS_OK;
}
