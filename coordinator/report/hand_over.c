// What leaves for other departments, and what comes back: curves for their solvers, and measured
// curves held against the corridors.
#include "common/base/whole_file.h"
#include "common/table/csv.h"
#include "coordinator/report/curves.h"
#include "coordinator/report/leaving.h"
#include "coordinator/report/number.h"
#include "coordinator/report/report.h"
#include "coordinator/report/seeds.h"
#include "coordinator/report/units.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

// ---- the search in question ----

// Loads a search whose corridors are curves over deformation.
static enum status load(struct run_data *data, struct run_data_search *search,
                        const char *directory, uint32_t index, struct error *error)
{
    *search = (struct run_data_search){0};
    enum status status = run_data_open(data, directory, error);
    if (status == STATUS_OK && index == REPORT_SEARCH_SHOWN)
        status = seeds_shown(data, &index, error);
    if (status == STATUS_OK && index >= data->run.search_count)
        status = error_set(error, STATUS_INVALID,
                           "%s: there is no search %" PRIu32 ", expected 0 to %" PRIu32, directory,
                           index, data->run.search_count - 1);
    if (status == STATUS_OK)
        status = run_data_load(data, index, search, error);
    if (status == STATUS_OK && search->box == NULL)
        status = error_set(error, STATUS_INVALID, "%s: search %" PRIu32 " has no corridors",
                           directory, index);
    if (status == STATUS_OK && search->scenario.spring_count == 0)
        status = error_set(error, STATUS_INVALID,
                           "%s: its model has no springs, so there are no curves over deformation",
                           directory);
    if (status == STATUS_OK)
        run_data_find_reach(search);
    return status;
}

// ---- out ----

static enum status find_format(const char *name, enum curves_format *format, struct error *error)
{
    for (int i = 0; i < CURVES_FORMAT_COUNT; i++)
        if (strcmp(curves_format_name((enum curves_format)i), name) == 0) {
            *format = (enum curves_format)i;
            return STATUS_OK;
        }
    return error_set(error, STATUS_INVALID,
                     "--export %s: expected ls-dyna, openradioss, csv or json", name);
}

static enum status make_folder(const char *path, struct error *error)
{
    if (g_mkdir_with_parents(path, 0777) == 0)
        return STATUS_OK;
    return error_set(error, STATUS_INVALID, "%s: cannot make the folder: %s", path,
                     g_strerror(errno));
}

enum status report_export(const char *directory, const struct report_export *export, char **path,
                          struct error *error)
{
    struct run_data data = {0};
    struct run_data_search search = {0};
    struct curves curves = {.search = &search, .first_id = export->first_id};
    enum curves_format format = CURVES_CSV;
    *path = NULL;
    enum status status = find_format(export->format, &format, error);
    if (status == STATUS_OK)
        status = units_find(export->units, &curves.units, error);
    if (status == STATUS_OK)
        status = load(&data, &search, directory, export->search, error);
    if (status == STATUS_OK)
        status = make_folder(export->folder, error);
    if (status == STATUS_OK) {
        curves.run_name = data.run.name;
        curves.version = data.run.version;
        char *text = curves_text(&curves, format);
        char *file = g_build_filename(export->folder, curves_file_name(format), NULL);
        status = whole_file_write(file, text, strlen(text), error);
        g_free(text);
        if (status == STATUS_OK)
            *path = file;
        else
            g_free(file);
    }
    run_data_release(&search);
    run_data_fini(&data);
    return status;
}

// ---- in ----

enum { PIECES_MAX = 1000 };

enum column { COLUMN_SPRING, COLUMN_DIRECTION, COLUMN_DEFORMATION, COLUMN_FORCE, COLUMN_COUNT };

static enum status misplaced(const struct csv *csv, uint32_t field, const char *expected,
                             struct error *error)
{
    char shown[CSV_SHOWN_SIZE];
    return csv_error(csv, field, error, "expected %s, found '%s'", expected,
                     csv_shown(&csv->fields[field], shown));
}

static enum status check_header(struct csv *csv, struct error *error)
{
    static const char *const names[COLUMN_COUNT] = {"spring", "direction", "deformation", "force"};
    if (csv_row(csv, error) != STATUS_OK)
        return STATUS_INVALID;
    for (uint32_t c = 0; c < COLUMN_COUNT; c++) {
        if (c >= csv->field_count)
            return csv_error(csv, c, error,
                             "expected the columns spring,direction,deformation,force; '%s' is "
                             "missing",
                             names[c]);
        if (!csv_is(&csv->fields[c], names[c]))
            return misplaced(csv, c, names[c], error);
    }
    return csv->field_count > COLUMN_COUNT ? misplaced(csv, COLUMN_COUNT, "four columns", error)
                                           : STATUS_OK;
}

// Moves to the next row; at the end of the table it has no field.
static enum status next_row(struct csv *csv, struct error *error)
{
    if (csv_row(csv, error) != STATUS_OK)
        return STATUS_INVALID;
    if (csv->field_count > 0 && csv->field_count != COLUMN_COUNT)
        return csv_error(csv, COLUMN_COUNT, error, "expected %d fields as in the header, found %u",
                         COLUMN_COUNT, csv->field_count);
    return STATUS_OK;
}

static enum status read_point(const struct csv *csv, const struct units *units, GArray *x,
                              GArray *y, struct error *error)
{
    double deformation, force;
    if (csv_number(csv, COLUMN_DEFORMATION, "deformation", units->length, &deformation, error) !=
            STATUS_OK ||
        csv_number(csv, COLUMN_FORCE, "force", units->force, &force, error) != STATUS_OK)
        return STATUS_INVALID;
    if (x->len > 0 && deformation <= g_array_index(x, double, x->len - 1))
        return misplaced(csv, COLUMN_DEFORMATION, "a deformation greater than the one above",
                         error);
    g_array_append_val(x, deformation);
    g_array_append_val(y, force);
    return STATUS_OK;
}

// Reads the points of one curve, from the row at hand up to the one that is of another.
static enum status read_curve(struct csv *csv, const char *spring, const char *direction,
                              const struct units *units, GArray *x, GArray *y, struct error *error)
{
    const uint64_t line = csv->line;
    g_array_set_size(x, 0);
    g_array_set_size(y, 0);
    do {
        if (read_point(csv, units, x, y, error) != STATUS_OK || next_row(csv, error) != STATUS_OK)
            return STATUS_INVALID;
    } while (csv->field_count > 0 && csv_is(&csv->fields[COLUMN_SPRING], spring) &&
             csv_is(&csv->fields[COLUMN_DIRECTION], direction));
    if (x->len < 2)
        return error_set(error, STATUS_INVALID,
                         "%s:%" PRIu64 ":1: expected at least 2 points of a curve", csv->source,
                         line);
    return STATUS_OK;
}

static enum status find_component(const struct csv *csv, const struct scenario *scenario,
                                  uint32_t *spring, enum scenario_direction *direction,
                                  struct error *error)
{
    *spring = 0;
    while (*spring < scenario->spring_count &&
           !csv_is(&csv->fields[COLUMN_SPRING], scenario->springs[*spring].name))
        ++*spring;
    if (*spring == scenario->spring_count) {
        GString *names = g_string_new("the name of a spring, one of");
        for (uint32_t i = 0; i < scenario->spring_count; i++)
            g_string_append_printf(names, "%s %s", i > 0 ? "," : "", scenario->springs[i].name);
        misplaced(csv, COLUMN_SPRING, names->str, error);
        g_string_free(names, TRUE);
        return STATUS_INVALID;
    }
    for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
        if (csv_is(&csv->fields[COLUMN_DIRECTION],
                   scenario_direction_name((enum scenario_direction)d))) {
            *direction = (enum scenario_direction)d;
            return STATUS_OK;
        }
    return misplaced(csv, COLUMN_DIRECTION, "x or y", error);
}

// Says where a curve leaves its corridor only behind all that designs of the box ask of the spring:
// it is outside, and in no crash that was simulated would it matter.
static void print_beyond(const struct run_data_search *search, uint32_t spring,
                         const struct leaving_piece *first, const struct units *units, FILE *out)
{
    const uint32_t beyond = reach_beyond(&search->reach, &search->scenario, spring);
    const struct scenario_spring *curve = &search->scenario.springs[spring];
    char designs[NUMBER_SIZE];
    if (beyond == curve->point_count || first->from < curve->deformation[beyond] * units->per_metre)
        return;
    fprintf(
        out,
        "    all of it beyond %.6g %s, where none of %s simulated designs of the corridors comes\n",
        curve->deformation[beyond] * units->per_metre, units->length,
        number_count(REACH_DESIGNS, designs));
}

static void print_pieces(const struct leaving_piece *pieces, uint32_t count,
                         const struct units *units, FILE *out)
{
    for (uint32_t i = 0; i < MIN(count, PIECES_MAX); i++) {
        const struct leaving_piece *piece = &pieces[i];
        fprintf(out, "    %s bound from %.6g to %.6g %s, most at %.6g %s: by %.6g %s\n",
                piece->above ? "above the upper" : "below the lower", piece->from, piece->to,
                units->length, piece->worst_at, units->length, piece->worst, units->force);
    }
    if (count > PIECES_MAX)
        fprintf(out, "    and %" PRIu32 " times more\n", count - PIECES_MAX);
}

// Holds one measured curve against its corridor and says what is found.
static bool hold(const struct run_data_search *search, uint32_t spring_index,
                 enum scenario_direction direction, const struct units *units, const GArray *x,
                 const GArray *y, FILE *out)
{
    const struct scenario_spring *spring = &search->scenario.springs[spring_index];
    double deformation[SCENARIO_POINT_MAX], lower[SCENARIO_POINT_MAX], upper[SCENARIO_POINT_MAX];
    for (uint32_t k = 0; k < spring->point_count; k++) {
        const uint32_t variable = run_data_variable(search, spring_index, direction, k);
        deformation[k] = spring->deformation[k] * units->per_metre;
        lower[k] = search->box->lower[variable] * units->per_newton;
        upper[k] = search->box->upper[variable] * units->per_newton;
    }
    const struct leaving_curves curves = {.x = (const double *)(const void *)x->data,
                                          .y = (const double *)(const void *)y->data,
                                          .count = x->len,
                                          .deformation = deformation,
                                          .lower = lower,
                                          .upper = upper,
                                          .point_count = spring->point_count};
    struct leaving_piece *pieces = g_new(struct leaving_piece, PIECES_MAX);
    double from, to;
    const uint32_t count = leaving_find(&curves, pieces, PIECES_MAX, &from, &to);
    fprintf(out, "%s F_%s: ", spring->name, scenario_direction_name(direction));
    if (from > to)
        fprintf(out, "not checked: the curve and the corridor share no deformation\n");
    else if (count == 0)
        fprintf(out, "inside its corridor from %.6g to %.6g %s\n", from, to, units->length);
    else
        fprintf(out, "leaves its corridor (looked at from %.6g to %.6g %s)\n", from, to,
                units->length);
    print_pieces(pieces, count, units, out);
    if (from <= to && count > 0)
        print_beyond(search, spring_index, &pieces[0], units, out);
    if (from <= to && (from > deformation[0] || to < deformation[spring->point_count - 1]))
        fprintf(out, "    the corridor reaches from %.6g to %.6g %s\n", deformation[0],
                deformation[spring->point_count - 1], units->length);
    g_free(pieces);
    return count == 0 && from <= to;
}

static enum status hold_all(struct csv *csv, const struct run_data_search *search,
                            const struct units *units, FILE *out, bool *inside, struct error *error)
{
    GArray *x = g_array_new(FALSE, FALSE, sizeof(double));
    GArray *y = g_array_new(FALSE, FALSE, sizeof(double));
    enum status status = check_header(csv, error);
    if (status == STATUS_OK)
        status = next_row(csv, error);
    if (status == STATUS_OK && csv->field_count == 0)
        status = csv_error(csv, 0, error, "expected rows below the header, found none");
    *inside = true;
    while (status == STATUS_OK && csv->field_count > 0) {
        uint32_t spring;
        enum scenario_direction direction = SCENARIO_DIRECTION_X;
        status = find_component(csv, &search->scenario, &spring, &direction, error);
        if (status == STATUS_OK)
            status = read_curve(csv, search->scenario.springs[spring].name,
                                scenario_direction_name(direction), units, x, y, error);
        if (status == STATUS_OK && !hold(search, spring, direction, units, x, y, out))
            *inside = false;
    }
    g_array_unref(x);
    g_array_unref(y);
    return status;
}

enum status report_check(const char *directory, const struct report_check *check, FILE *out,
                         bool *inside, struct error *error)
{
    struct run_data data = {0};
    struct run_data_search search = {0};
    struct csv csv;
    char *text = NULL;
    size_t size = 0;
    const struct units *units = NULL;
    *inside = false;
    enum status status = units_find(check->units, &units, error);
    if (status == STATUS_OK)
        status = (text = csv_load(check->path, &size, error)) != NULL ? STATUS_OK : STATUS_INVALID;
    if (status == STATUS_OK)
        status = load(&data, &search, directory, check->search, error);
    if (status == STATUS_OK) {
        csv_start(&csv, check->path, text, size);
        status = hold_all(&csv, &search, units, out, inside, error);
    }
    if (status == STATUS_OK && (fflush(out) != 0 || ferror(out)))
        status = error_set(error, STATUS_IO, "what was found could not be printed");
    if (status != STATUS_OK)
        *inside = false;
    g_free(text);
    run_data_release(&search);
    run_data_fini(&data);
    return status;
}
