#include "worker/models/design.h"
#include "common/table/csv.h"
#include "common/table/decimal.h"

#include <glib.h>
#include <string.h>

enum design_column {
    COLUMN_SPRING,
    COLUMN_BRANCH,
    COLUMN_DEFORMATION,
    COLUMN_FORCE_X,
    COLUMN_FORCE_Y,
    COLUMN_COUNT
};

static const char *const column_names[COLUMN_COUNT] = {
    [COLUMN_SPRING] = "spring",
    [COLUMN_BRANCH] = "branch",
    [COLUMN_DEFORMATION] = "deformation_m",
    [COLUMN_FORCE_X] = "force_x_N",
    [COLUMN_FORCE_Y] = "force_y_N",
};

static const char header_text[] = "spring,branch,deformation_m,force_x_N,force_y_N";

void design_init(struct design *design, const struct scenario *scenario)
{
    design->spring_count = scenario->spring_count;
    design->springs = g_new0(struct design_spring, design->spring_count);
}

static void branch_fini(struct design_branch *branch)
{
    g_free(branch->deformation);
    for (int direction = 0; direction < SCENARIO_DIRECTION_COUNT; direction++) {
        g_free(branch->force[direction]);
    }
}

void design_fini(struct design *design)
{
    for (uint32_t i = 0; i < design->spring_count; i++) {
        branch_fini(&design->springs[i].load);
        branch_fini(&design->springs[i].unload);
    }
    g_free(design->springs);
    *design = (struct design){0};
}

void design_add(struct design_branch *branch, double deformation, double force_x, double force_y)
{
    const uint32_t last = branch->point_count++;
    branch->deformation = g_renew(double, branch->deformation, branch->point_count);
    branch->deformation[last] = deformation;
    const double force[SCENARIO_DIRECTION_COUNT] = {
        [SCENARIO_DIRECTION_X] = force_x,
        [SCENARIO_DIRECTION_Y] = force_y,
    };
    for (int direction = 0; direction < SCENARIO_DIRECTION_COUNT; direction++) {
        branch->force[direction] = g_renew(double, branch->force[direction], branch->point_count);
        branch->force[direction][last] = force[direction];
    }
}

static double place_force(const struct scenario_spring *spring, enum design_place place,
                          enum scenario_direction direction, uint32_t point)
{
    const double lower = spring->force_lower[direction][point];
    const double upper = spring->force_upper[direction][point];
    switch (place) {
    case DESIGN_LOWER:
        return lower;
    case DESIGN_UPPER:
        return upper;
    default:
        return lower + 0.5 * (upper - lower);
    }
}

void design_init_place(struct design *design, const struct scenario *scenario,
                       enum design_place place)
{
    design_init(design, scenario);
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const struct scenario_spring *spring = &scenario->springs[i];
        for (uint32_t point = 0; point < spring->point_count; point++) {
            design_add(&design->springs[i].load, spring->deformation[point],
                       place_force(spring, place, SCENARIO_DIRECTION_X, point),
                       place_force(spring, place, SCENARIO_DIRECTION_Y, point));
        }
    }
}

static enum status parse_header(struct csv *csv, struct error *error)
{
    if (csv_row(csv, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    for (uint32_t i = 0; i < COLUMN_COUNT; i++) {
        if (i >= csv->field_count || !csv_is(&csv->fields[i], column_names[i])) {
            return csv_error(csv, i, error, "expected the header %s", header_text);
        }
    }
    if (csv->field_count > COLUMN_COUNT) {
        return csv_error(csv, COLUMN_COUNT, error, "expected the header %s", header_text);
    }
    return STATUS_OK;
}

// The branch that a row belongs to, or NULL with the error set.
static struct design_branch *parse_branch(struct design *design, const struct scenario *scenario,
                                          const struct csv *csv, struct error *error)
{
    const struct csv_field *name = &csv->fields[COLUMN_SPRING];
    const struct csv_field *branch = &csv->fields[COLUMN_BRANCH];
    char shown[CSV_SHOWN_SIZE];
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        if (!csv_is(name, scenario->springs[i].name)) {
            continue;
        }
        if (csv_is(branch, "load")) {
            return &design->springs[i].load;
        }
        if (csv_is(branch, "unload")) {
            return &design->springs[i].unload;
        }
        csv_error(csv, COLUMN_BRANCH, error, "branch: expected load or unload, found \"%s\"",
                  csv_shown(branch, shown));
        return NULL;
    }
    GString *names = g_string_new(NULL);
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        g_string_append_printf(names, "%s%s", i > 0 ? ", " : "", scenario->springs[i].name);
    }
    csv_error(csv, COLUMN_SPRING, error, "spring: expected one of %s; found \"%s\"", names->str,
              csv_shown(name, shown));
    g_string_free(names, TRUE);
    return NULL;
}

static enum status parse_point(struct design *design, const struct scenario *scenario,
                               const struct csv *csv, struct error *error)
{
    if (csv->field_count != COLUMN_COUNT) {
        return csv_error(csv, MIN(csv->field_count, COLUMN_COUNT), error,
                         "expected %d fields (%s), found %u", COLUMN_COUNT, header_text,
                         csv->field_count);
    }
    struct design_branch *branch = parse_branch(design, scenario, csv, error);
    if (branch == NULL) {
        return STATUS_INVALID;
    }
    double number[COLUMN_COUNT];
    for (uint32_t i = COLUMN_DEFORMATION; i < COLUMN_COUNT; i++) {
        const char *unit = i == COLUMN_DEFORMATION ? "m" : "N";
        if (csv_number(csv, i, column_names[i], unit, &number[i], error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    const double deformation = number[COLUMN_DEFORMATION];
    if (branch->point_count > 0 && !(deformation > branch->deformation[branch->point_count - 1])) {
        return csv_error(csv, COLUMN_DEFORMATION, error,
                         "deformation_m: expected more than %g m, the point before of this branch, "
                         "found %g",
                         branch->deformation[branch->point_count - 1], deformation);
    }
    design_add(branch, deformation, number[COLUMN_FORCE_X], number[COLUMN_FORCE_Y]);
    return STATUS_OK;
}

static enum status parse_points(struct design *design, const struct scenario *scenario,
                                struct csv *csv, struct error *error)
{
    for (uint32_t points = 0;; points++) {
        if (csv_row(csv, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
        if (csv->field_count == 0) {
            return STATUS_OK;
        }
        if (points == DESIGN_POINT_MAX) {
            return csv_error(csv, 0, error, "expected at most %d points", DESIGN_POINT_MAX);
        }
        if (parse_point(design, scenario, csv, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
}

static enum status check_branch(const struct csv *csv, const char *spring, const char *name,
                                const struct design_branch *branch, uint32_t least,
                                struct error *error)
{
    if (branch->point_count < least) {
        return csv_error(csv, 0, error,
                         "spring %s: expected at least 2 points of the branch %s, found %u", spring,
                         name, branch->point_count);
    }
    return STATUS_OK;
}

// Every spring has its load branch, and no branch is a single point.
static enum status check_branches(const struct design *design, const struct scenario *scenario,
                                  const struct csv *csv, struct error *error)
{
    for (uint32_t i = 0; i < design->spring_count; i++) {
        const struct design_spring *spring = &design->springs[i];
        const char *name = scenario->springs[i].name;
        const uint32_t unload_least = spring->unload.point_count > 0 ? 2 : 0;
        if (check_branch(csv, name, "load", &spring->load, 2, error) != STATUS_OK ||
            check_branch(csv, name, "unload", &spring->unload, unload_least, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    return STATUS_OK;
}

enum status design_parse(struct design *design, const struct scenario *scenario, const char *source,
                         const char *text, size_t size, struct error *error)
{
    struct csv csv;
    csv_start(&csv, source, text, size);
    design_init(design, scenario);
    if (parse_header(&csv, error) != STATUS_OK ||
        parse_points(design, scenario, &csv, error) != STATUS_OK ||
        check_branches(design, scenario, &csv, error) != STATUS_OK) {
        design_fini(design);
        return STATUS_INVALID;
    }
    return STATUS_OK;
}

static void append_branch(GString *text, const char *spring, const char *name,
                          const struct design_branch *branch)
{
    for (uint32_t i = 0; i < branch->point_count; i++) {
        const double numbers[] = {
            branch->deformation[i],
            branch->force[SCENARIO_DIRECTION_X][i],
            branch->force[SCENARIO_DIRECTION_Y][i],
        };
        g_string_append_printf(text, "%s,%s", spring, name);
        for (size_t k = 0; k < G_N_ELEMENTS(numbers); k++) {
            char digits[DECIMAL_SIZE];
            g_string_append_c(text, ',');
            g_string_append(text, decimal_text(numbers[k], digits));
        }
        g_string_append_c(text, '\n');
    }
}

char *design_text(const struct design *design, const struct scenario *scenario)
{
    GString *text = g_string_new(header_text);
    g_string_append_c(text, '\n');
    for (uint32_t i = 0; i < design->spring_count; i++) {
        append_branch(text, scenario->springs[i].name, "load", &design->springs[i].load);
        append_branch(text, scenario->springs[i].name, "unload", &design->springs[i].unload);
    }
    return g_string_free(text, FALSE);
}
