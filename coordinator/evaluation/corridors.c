#include "coordinator/evaluation/corridors.h"

#include "common/scenario/sheet.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum { CORRIDORS_ROWS_MAX = 100000 };

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
    struct sheet sheet;
    uint32_t columns[COLUMN_COUNT]; // where they stand; column_count: nowhere
    uint32_t *rows;                 // (variables) where each stands; 0: not yet
    struct box box;
    struct error *error;
};

static enum status wrong(const struct corridors *corridors, const struct sheet_cell *cell,
                         const char *expected)
{
    return error_set(corridors->error, STATUS_INVALID, "%s:%u:%u: expected %s, found '%.40s'",
                     corridors->sheet.source, cell->line, cell->column, expected, cell->text);
}

static const struct sheet_cell *cell_at(const struct corridors *corridors, uint32_t row,
                                        enum column column)
{
    return sheet_cell(&corridors->sheet, row, corridors->columns[column]);
}

// ---- the header

static enum status find_columns(struct corridors *corridors)
{
    const struct sheet *sheet = &corridors->sheet;
    for (int column = 0; column < COLUMN_COUNT; column++) {
        uint32_t at = 0;
        while (at < sheet->column_count &&
               strcmp(sheet_cell(sheet, 0, at)->text, column_names[column]) != 0)
            at++;
        corridors->columns[column] = at;
        if (at == sheet->column_count && column != COLUMN_SEARCH)
            return error_set(corridors->error, STATUS_INVALID,
                             "%s:%u:1: expected the columns spring,direction,deformation_m,lower_N,"
                             "upper_N with commas between them; '%s' is missing",
                             sheet->source, sheet_cell(sheet, 0, 0)->line, column_names[column]);
    }
    return STATUS_OK;
}

// The corridors of one search make a box.
static enum status check_search(const struct corridors *corridors, uint32_t row)
{
    if (corridors->columns[COLUMN_SEARCH] == corridors->sheet.column_count)
        return STATUS_OK;
    const struct sheet_cell *cell = cell_at(corridors, row, COLUMN_SEARCH);
    if (strcmp(cell->text, cell_at(corridors, 1, COLUMN_SEARCH)->text) == 0)
        return STATUS_OK;
    return wrong(corridors, cell, "the corridors of one search alone, as in the first row");
}

// ---- which variable a row is

static enum status read_number(const struct corridors *corridors, const struct sheet_cell *cell,
                               double *number)
{
    char *end;
    *number = g_ascii_strtod(cell->text, &end);
    if (end == cell->text || *end != '\0' || !isfinite(*number))
        return wrong(corridors, cell, "a number");
    return STATUS_OK;
}

static bool is_place(const struct scenario *scenario, const struct scenario_variable *variable,
                     const struct sheet_cell *name, const char *direction, double deformation)
{
    if (variable->spring == SCENARIO_NO_SPRING)
        return strcmp(variable->name, name->text) == 0;
    const struct scenario_spring *spring = &scenario->springs[variable->spring];
    return strcmp(spring->name, name->text) == 0 &&
           strcmp(scenario_direction_name(variable->direction), direction) == 0 &&
           fabs(spring->deformation[variable->point] - deformation) <= corridors_rounding;
}

// What of the place is wrong: the first part of it that no variable has.
static enum status no_place(const struct corridors *corridors, uint32_t row)
{
    const struct scenario *scenario = corridors->scenario;
    const struct sheet_cell *name = cell_at(corridors, row, COLUMN_SPRING);
    const struct sheet_cell *direction = cell_at(corridors, row, COLUMN_DIRECTION);
    uint32_t s = 0;
    while (s < scenario->spring_count && strcmp(scenario->springs[s].name, name->text) != 0)
        s++;
    if (s == scenario->spring_count)
        return wrong(corridors, name,
                     scenario->spring_count > 0 ? "the name of a spring of the scenario"
                                                : "the name of a variable of the scenario");
    if (strcmp(direction->text, "x") != 0 && strcmp(direction->text, "y") != 0)
        return wrong(corridors, direction, "x or y");
    return wrong(corridors, cell_at(corridors, row, COLUMN_DEFORMATION),
                 "a deformation at which the scenario has a point of this spring [m]");
}

static enum status find_variable(const struct corridors *corridors, uint32_t row,
                                 uint32_t *variable)
{
    const struct scenario *scenario = corridors->scenario;
    const struct sheet_cell *name = cell_at(corridors, row, COLUMN_SPRING);
    const struct sheet_cell *place = cell_at(corridors, row, COLUMN_DEFORMATION);
    double deformation = NAN;
    if (place->text[0] != '\0' && read_number(corridors, place, &deformation) != STATUS_OK)
        return STATUS_INVALID;
    const char *direction = cell_at(corridors, row, COLUMN_DIRECTION)->text;
    for (uint32_t v = 0; v < scenario->design_space.count; v++) {
        if (!is_place(scenario, &scenario->variables[v], name, direction, deformation))
            continue;
        *variable = v;
        return corridors->rows[v] == 0 ? STATUS_OK
                                       : wrong(corridors, name, "each corridor's place once");
    }
    return no_place(corridors, row);
}

// ---- its bounds

static enum status read_bound(const struct corridors *corridors, uint32_t row, enum column column,
                              uint32_t variable, double *bound)
{
    const struct box *space = &corridors->scenario->design_space;
    const double lower = space->lower[variable], upper = space->upper[variable];
    const double slack = corridors_rounding * fmax(upper - lower, fabs(upper));
    const struct sheet_cell *cell = cell_at(corridors, row, column);
    if (read_number(corridors, cell, bound) != STATUS_OK)
        return STATUS_INVALID;
    if (*bound < lower - slack || *bound > upper + slack)
        return error_set(corridors->error, STATUS_INVALID,
                         "%s:%u:%u: %s: expected a bound inside the design space, %.15g to %.15g, "
                         "found %.40s",
                         corridors->sheet.source, cell->line, cell->column,
                         corridors->scenario->variables[variable].name, lower, upper, cell->text);
    *bound = fmin(fmax(*bound, lower), upper);
    return STATUS_OK;
}

static enum status read_row(struct corridors *corridors, uint32_t row)
{
    uint32_t v = 0;
    if (check_search(corridors, row) != STATUS_OK ||
        find_variable(corridors, row, &v) != STATUS_OK ||
        read_bound(corridors, row, COLUMN_LOWER, v, &corridors->box.lower[v]) != STATUS_OK ||
        read_bound(corridors, row, COLUMN_UPPER, v, &corridors->box.upper[v]) != STATUS_OK)
        return STATUS_INVALID;
    corridors->rows[v] = row;
    if (corridors->box.lower[v] <= corridors->box.upper[v])
        return STATUS_OK;
    const struct sheet_cell *cell = cell_at(corridors, row, COLUMN_UPPER);
    return error_set(corridors->error, STATUS_INVALID,
                     "%s:%u:%u: %s: expected an upper bound at least at the lower one of %.15g, "
                     "found %.40s",
                     corridors->sheet.source, cell->line, cell->column,
                     corridors->scenario->variables[v].name, corridors->box.lower[v], cell->text);
}

// ---- the whole

// A variable without a row is one that has a value of its own.
static enum status complete(struct corridors *corridors)
{
    const struct box *space = &corridors->scenario->design_space;
    bool wide = false;
    for (uint32_t v = 0; v < space->count; v++) {
        if (corridors->rows[v] == 0 && space->lower[v] < space->upper[v])
            return error_set(corridors->error, STATUS_INVALID,
                             "%s:%u:1: expected a row for every variable; that of %s is missing",
                             corridors->sheet.source, sheet_cell(&corridors->sheet, 0, 0)->line,
                             corridors->scenario->variables[v].name);
        if (corridors->rows[v] == 0)
            corridors->box.lower[v] = corridors->box.upper[v] = space->lower[v];
        wide = wide || corridors->box.lower[v] < corridors->box.upper[v];
    }
    if (wide)
        return STATUS_OK;
    return error_set(corridors->error, STATUS_INVALID,
                     "%s:%u:1: every corridor is a single value: expected a lower bound below its "
                     "upper one (sobox-simulate looks at one design)",
                     corridors->sheet.source, sheet_cell(&corridors->sheet, 0, 0)->line);
}

static enum status read_sheet(struct corridors *corridors)
{
    enum status status = find_columns(corridors);
    for (uint32_t row = 1; row <= corridors->sheet.row_count && status == STATUS_OK; row++)
        status = read_row(corridors, row);
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
    enum status status =
        sheet_read_file(&corridors.sheet, file, CORRIDORS_ROWS_MAX, corridors.error);
    if (status != STATUS_OK)
        return status;
    corridors.rows = g_new0(uint32_t, scenario->design_space.count + 1);
    box_init(&corridors.box, scenario->design_space.count);
    status = read_sheet(&corridors);
    if (status == STATUS_OK) {
        *box = corridors.box;
        corridors.box = (struct box){0};
    }
    box_fini(&corridors.box);
    g_free(corridors.rows);
    sheet_fini(&corridors.sheet);
    return status;
}

static void put_numbers(GString *text, const char *key, const double *numbers, uint32_t count)
{
    char number[G_ASCII_DTOSTR_BUF_SIZE];
    g_string_append_printf(text, "%s: [", key);
    for (uint32_t i = 0; i < count; i++)
        g_string_append_printf(text, "%s%s", i > 0 ? ", " : "",
                               g_ascii_formatd(number, sizeof number, "%.17g", numbers[i]));
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
