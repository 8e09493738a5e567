#include "coordinator/evaluation/corridors.h"

#include "common/table/csv.h"
#include "common/table/decimal.h"

#include <glib.h>
#include <math.h>
#include <string.h>

// Spreadsheets keep 15 digits, and a sum of deformations or of forces is rounded as well.
static const double corridors_rounding = 1e-9; // of the design space's width, and [m]

enum column {
    COLUMN_SPRING,
    COLUMN_DIRECTION,
    COLUMN_DEFORMATION,
    COLUMN_LOWER,
    COLUMN_UPPER,
    COLUMN_SEARCH, // need not be there
    COLUMN_COUNT
};

static const char *const column_names[COLUMN_COUNT] = {
    [COLUMN_SPRING] = "spring",
    [COLUMN_DIRECTION] = "direction",
    [COLUMN_DEFORMATION] = "deformation_m",
    [COLUMN_LOWER] = "lower_N",
    [COLUMN_UPPER] = "upper_N",
    [COLUMN_SEARCH] = "search",
};

// The reading in progress.
struct corridors {
    const struct scenario *scenario; // borrowed
    struct csv csv;
    uint32_t column_count;          // of the header
    uint32_t columns[COLUMN_COUNT]; // where they stand; column_count: nowhere
    char *search;                   // of the first row; NULL before it
    bool *there;                    // (variables) which have had their row
    struct box box;
    struct error *error;
};

static const struct csv_field *field_at(const struct corridors *corridors, enum column column)
{
    return &corridors->csv.fields[corridors->columns[column]];
}

static enum status wrong(const struct corridors *corridors, enum column column,
                         const char *expected)
{
    char shown[CSV_SHOWN_SIZE];
    return csv_error(&corridors->csv, corridors->columns[column], corridors->error,
                     "expected %s, found '%s'", expected,
                     csv_shown(field_at(corridors, column), shown));
}

// ---- the header

static enum status find_columns(struct corridors *corridors)
{
    struct csv *csv = &corridors->csv;
    if (csv_row(csv, corridors->error) != STATUS_OK)
        return STATUS_INVALID;
    corridors->column_count = csv->field_count;
    for (int column = 0; column < COLUMN_COUNT; column++) {
        uint32_t at = 0;
        while (at < csv->field_count && !csv_is(&csv->fields[at], column_names[column]))
            at++;
        corridors->columns[column] = at;
        if (at == csv->field_count && column != COLUMN_SEARCH)
            return csv_error_at(csv, csv->line_begin, corridors->error,
                                "expected the columns spring,direction,deformation_m,lower_N,"
                                "upper_N with commas between them; '%s' is missing",
                                column_names[column]);
    }
    return STATUS_OK;
}

// The corridors of one search make a box.
static enum status check_search(struct corridors *corridors)
{
    if (corridors->columns[COLUMN_SEARCH] == corridors->column_count)
        return STATUS_OK;
    const struct csv_field *field = field_at(corridors, COLUMN_SEARCH);
    if (corridors->search == NULL)
        corridors->search = csv_text(field);
    return csv_is(field, corridors->search)
               ? STATUS_OK
               : wrong(corridors, COLUMN_SEARCH,
                       "the corridors of one search alone, as in the first row");
}

// ---- which variable a row is

static enum status read_number(const struct corridors *corridors, enum column column,
                               double *number)
{
    const struct csv_field *field = field_at(corridors, column);
    return decimal_read(field->text, field->size, number) ? STATUS_OK
                                                          : wrong(corridors, column, "a number");
}

static bool is_place(const struct corridors *corridors, const struct scenario_variable *variable,
                     double deformation)
{
    const struct csv_field *name = field_at(corridors, COLUMN_SPRING);
    if (variable->spring == SCENARIO_NO_SPRING)
        return csv_is(name, variable->name);
    const struct scenario_spring *spring = &corridors->scenario->springs[variable->spring];
    return csv_is(name, spring->name) &&
           csv_is(field_at(corridors, COLUMN_DIRECTION),
                  scenario_direction_name(variable->direction)) &&
           fabs(spring->deformation[variable->point] - deformation) <= corridors_rounding;
}

// What of the place is wrong: the first part of it that no variable has.
static enum status no_place(const struct corridors *corridors)
{
    const struct scenario *scenario = corridors->scenario;
    const struct csv_field *direction = field_at(corridors, COLUMN_DIRECTION);
    uint32_t s = 0;
    while (s < scenario->spring_count &&
           !csv_is(field_at(corridors, COLUMN_SPRING), scenario->springs[s].name))
        s++;
    if (s == scenario->spring_count)
        return wrong(corridors, COLUMN_SPRING,
                     scenario->spring_count > 0 ? "the name of a spring of the scenario"
                                                : "the name of a variable of the scenario");
    if (!csv_is(direction, "x") && !csv_is(direction, "y"))
        return wrong(corridors, COLUMN_DIRECTION, "x or y");
    return wrong(corridors, COLUMN_DEFORMATION,
                 "a deformation at which the scenario has a point of this spring [m]");
}

static enum status find_variable(const struct corridors *corridors, uint32_t *variable)
{
    const struct scenario *scenario = corridors->scenario;
    double deformation = NAN;
    if (field_at(corridors, COLUMN_DEFORMATION)->size > 0 &&
        read_number(corridors, COLUMN_DEFORMATION, &deformation) != STATUS_OK)
        return STATUS_INVALID;
    for (uint32_t v = 0; v < scenario->design_space.count; v++) {
        if (!is_place(corridors, &scenario->variables[v], deformation))
            continue;
        *variable = v;
        return corridors->there[v] ? wrong(corridors, COLUMN_SPRING, "each corridor's place once")
                                   : STATUS_OK;
    }
    return no_place(corridors);
}

// ---- its bounds

static enum status read_bound(const struct corridors *corridors, enum column column,
                              uint32_t variable, double *bound)
{
    const struct box *space = &corridors->scenario->design_space;
    const double lower = space->lower[variable], upper = space->upper[variable];
    const double slack = corridors_rounding * fmax(upper - lower, fabs(upper));
    char shown[CSV_SHOWN_SIZE];
    if (read_number(corridors, column, bound) != STATUS_OK)
        return STATUS_INVALID;
    if (*bound < lower - slack || *bound > upper + slack)
        return csv_error(&corridors->csv, corridors->columns[column], corridors->error,
                         "%s: expected a bound inside the design space, %.15g to %.15g, found %s",
                         corridors->scenario->variables[variable].name, lower, upper,
                         csv_shown(field_at(corridors, column), shown));
    *bound = fmin(fmax(*bound, lower), upper);
    return STATUS_OK;
}

static enum status read_row(struct corridors *corridors)
{
    const struct csv *csv = &corridors->csv;
    char shown[CSV_SHOWN_SIZE];
    uint32_t v = 0;
    if (csv->field_count != corridors->column_count)
        return csv_error_at(csv, csv->line_begin, corridors->error,
                            "expected %u cells as in the header, found %u", corridors->column_count,
                            csv->field_count);
    if (check_search(corridors) != STATUS_OK || find_variable(corridors, &v) != STATUS_OK ||
        read_bound(corridors, COLUMN_LOWER, v, &corridors->box.lower[v]) != STATUS_OK ||
        read_bound(corridors, COLUMN_UPPER, v, &corridors->box.upper[v]) != STATUS_OK)
        return STATUS_INVALID;
    corridors->there[v] = true;
    if (corridors->box.lower[v] <= corridors->box.upper[v])
        return STATUS_OK;
    return csv_error(csv, corridors->columns[COLUMN_UPPER], corridors->error,
                     "%s: expected an upper bound at least at the lower one of %.15g, found %s",
                     corridors->scenario->variables[v].name, corridors->box.lower[v],
                     csv_shown(field_at(corridors, COLUMN_UPPER), shown));
}

// ---- the whole

// A variable without a row is one that has a value of its own.
static enum status complete(struct corridors *corridors)
{
    const struct box *space = &corridors->scenario->design_space;
    bool wide = false;
    for (uint32_t v = 0; v < space->count; v++) {
        if (!corridors->there[v] && space->lower[v] < space->upper[v])
            return error_set(corridors->error, STATUS_INVALID,
                             "%s:1:1: expected a row for every variable; that of %s is missing",
                             corridors->csv.source, corridors->scenario->variables[v].name);
        if (!corridors->there[v])
            corridors->box.lower[v] = corridors->box.upper[v] = space->lower[v];
        wide = wide || corridors->box.lower[v] < corridors->box.upper[v];
    }
    if (wide)
        return STATUS_OK;
    return error_set(corridors->error, STATUS_INVALID,
                     "%s:1:1: every corridor is a single value: expected a lower bound below its "
                     "upper one (sobox-simulate looks at one design)",
                     corridors->csv.source);
}

static enum status read_rows(struct corridors *corridors)
{
    struct csv *csv = &corridors->csv;
    enum status status = find_columns(corridors);
    while (status == STATUS_OK && csv->field_count > 0) {
        status = csv_row(csv, corridors->error);
        if (status == STATUS_OK && csv->field_count > 0)
            status = read_row(corridors);
    }
    return status == STATUS_OK ? complete(corridors) : status;
}

enum status corridors_read(struct box *box, const struct scenario *scenario, const char *path,
                           struct error *error)
{
    struct error unread;
    struct corridors corridors = {.scenario = scenario, .error = error != NULL ? error : &unread};
    const bool folder = g_file_test(path, G_FILE_TEST_IS_DIR);
    g_autofree char *file = folder ? g_build_filename(path, "corridors.csv", NULL) : g_strdup(path);
    *box = (struct box){0};
    size_t size;
    g_autofree char *text = csv_load(file, &size, corridors.error);
    if (text == NULL)
        return STATUS_INVALID;
    csv_start(&corridors.csv, file, text, size);
    corridors.there = g_new0(bool, scenario->design_space.count + 1);
    box_init(&corridors.box, scenario->design_space.count);
    const enum status status = read_rows(&corridors);
    if (status == STATUS_OK) {
        *box = corridors.box;
        corridors.box = (struct box){0};
    }
    box_fini(&corridors.box);
    g_free(corridors.there);
    g_free(corridors.search);
    return status;
}

static void put_numbers(GString *text, const char *key, const double *numbers, uint32_t count)
{
    char number[DECIMAL_SIZE];
    g_string_append_printf(text, "%s: [", key);
    for (uint32_t i = 0; i < count; i++)
        g_string_append_printf(text, "%s%s", i > 0 ? ", " : "", decimal_text(numbers[i], number));
    g_string_append_c(text, ']');
}

char *corridors_text(const struct box *box)
{
    GString *text = g_string_new("{");
    put_numbers(text, "lower", box->lower, box->count);
    g_string_append(text, ", ");
    put_numbers(text, "upper", box->upper, box->count);
    g_string_append_c(text, '}');
    return g_string_free(text, FALSE);
}
