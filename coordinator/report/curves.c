#include "coordinator/report/curves.h"

#include "common/base/plain.h"
#include "common/table/decimal.h"
#include "coordinator/report/number.h"

#include <assert.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <string.h>

enum bound { BOUND_LOWER, BOUND_MIDDLE, BOUND_UPPER, BOUND_COUNT };

static const char *const bound_names[] = {
    [BOUND_LOWER] = "lower", [BOUND_MIDDLE] = "middle", [BOUND_UPPER] = "upper"};

static const struct {
    const char *name, *file;
} formats[CURVES_FORMAT_COUNT] = {
    [CURVES_LS_DYNA] = {"ls-dyna", "curves.k"},
    [CURVES_OPENRADIOSS] = {"openradioss", "curves.inc"},
    [CURVES_CSV] = {"csv", "curves.csv"},
    [CURVES_JSON] = {"json", "curves.json"},
};

const char *curves_format_name(enum curves_format format)
{
    assert(format < CURVES_FORMAT_COUNT);
    return formats[format].name;
}

const char *curves_file_name(enum curves_format format)
{
    assert(format < CURVES_FORMAT_COUNT);
    return formats[format].file;
}

// ---- one curve ----

struct curve {
    const struct curves *curves;
    uint32_t spring;
    enum scenario_direction direction;
    enum bound bound;
    uint32_t id;
};

static const struct scenario_spring *spring_of(const struct curve *curve)
{
    return &curve->curves->search->scenario.springs[curve->spring];
}

static bool reached(const struct curve *curve, uint32_t point)
{
    const struct run_data_search *search = curve->curves->search;
    return point < reach_points(&search->reach, &search->scenario, curve->spring);
}

static double deformation(const struct curve *curve, uint32_t point)
{
    return spring_of(curve)->deformation[point] * curve->curves->units->per_metre;
}

static double force(const struct curve *curve, uint32_t point)
{
    const struct run_data_search *search = curve->curves->search;
    const uint32_t variable = run_data_variable(search, curve->spring, curve->direction, point);
    const double lower = search->box->lower[variable], upper = search->box->upper[variable];
    const double newton = curve->bound == BOUND_LOWER   ? lower
                          : curve->bound == BOUND_UPPER ? upper
                                                        : (lower + upper) / 2;
    return newton * curve->curves->units->per_newton;
}

typedef void curve_writer(GString *text, const struct curve *curve);

static void each_curve(const struct curves *curves, GString *text, curve_writer *write)
{
    uint32_t id = curves->first_id;
    for (uint32_t s = 0; s < curves->search->scenario.spring_count; s++)
        for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
            for (int b = 0; b < BOUND_COUNT; b++)
                write(text, &(struct curve){.curves = curves,
                                            .spring = s,
                                            .direction = (enum scenario_direction)d,
                                            .bound = (enum bound)b,
                                            .id = id++});
}

// ---- solvers ----

// Where the curves come from and what they are good for, as comments.
static void put_comments(GString *text, const struct curves *curves, const char *mark)
{
    const struct journal_search *record = &curves->search->record;
    char *run = plain_text(curves->run_name), *name = plain_text(curves->search->name);
    char *status = plain_text(curves->search->status);
    g_string_append_printf(text, "%s Force over deformation, made by sobox %s\n", mark,
                           curves->version);
    g_string_append_printf(text, "%s run %s, search %s, %s\n", mark, run, name, status);
    if (record->finished && record->purity_samples > 0)
        g_string_append_printf(text,
                               "%s between lower and upper at least %.4f of all designs are good\n",
                               mark, floor(record->purity_lower95 * 1e4) * 1e-4);
    g_string_append_printf(text, "%s units %s: deformation in %s, force in %s\n", mark,
                           curves->units->name, curves->units->length, curves->units->force);
    g_free(status);
    g_free(name);
    g_free(run);
}

// From where on a curve means nothing to the crash, as a comment before its points.
static void put_reach(GString *text, const struct curve *curve, const char *mark)
{
    char designs[NUMBER_SIZE], from[G_ASCII_DTOSTR_BUF_SIZE];
    uint32_t first = 0;
    while (first < spring_of(curve)->point_count && reached(curve, first))
        first++;
    if (first == spring_of(curve)->point_count)
        return;
    g_ascii_formatd(from, sizeof from, "%.12g", deformation(curve, first));
    g_string_append_printf(
        text, "%s from %s %s on: reached by none of %s designs that were simulated\n", mark, from,
        curve->curves->units->length, number_count(REACH_DESIGNS, designs));
}

// Two numbers in fields of 20 characters, which both solvers read.
static void put_fields(GString *text, double x, double y)
{
    char one[G_ASCII_DTOSTR_BUF_SIZE], two[G_ASCII_DTOSTR_BUF_SIZE];
    g_ascii_formatd(one, sizeof one, "%.12g", x);
    g_ascii_formatd(two, sizeof two, "%.12g", y);
    g_string_append_printf(text, "%20s%20s\n", one, two);
}

static void put_points(GString *text, const struct curve *curve)
{
    for (uint32_t k = 0; k < spring_of(curve)->point_count; k++)
        put_fields(text, deformation(curve, k), force(curve, k));
}

static void put_title(GString *text, const struct curve *curve)
{
    g_string_append_printf(text, "%s F_%s %s\n", spring_of(curve)->name,
                           scenario_direction_name(curve->direction), bound_names[curve->bound]);
}

static void write_ls_dyna(GString *text, const struct curve *curve)
{
    g_string_append(text, "*DEFINE_CURVE_TITLE\n");
    put_title(text, curve);
    g_string_append_printf(
        text,
        "$#    lcid      sidr       sfa       sfo      offa      offo    dattyp\n"
        "%10" PRIu32 "         0       1.0       1.0       0.0       0.0         "
        "0\n"
        "$#                a1                  o1\n",
        curve->id);
    put_reach(text, curve, "$");
    put_points(text, curve);
}

static void write_openradioss(GString *text, const struct curve *curve)
{
    g_string_append_printf(text, "/FUNCT/%" PRIu32 "\n", curve->id);
    put_title(text, curve);
    g_string_append(text, "#                  X                   Y\n");
    put_reach(text, curve, "#");
    put_points(text, curve);
}

// ---- tables ----

static void write_csv(GString *text, const struct curve *curve)
{
    for (uint32_t k = 0; k < spring_of(curve)->point_count; k++) {
        char x[NUMBER_SIZE], y[NUMBER_SIZE];
        g_string_append_printf(text, "%s,%s,%s,%s,%s,%s\n", spring_of(curve)->name,
                               scenario_direction_name(curve->direction), bound_names[curve->bound],
                               decimal_text(deformation(curve, k), x),
                               decimal_text(force(curve, k), y), reached(curve, k) ? "yes" : "no");
    }
}

static char *json_text(const struct curves *curves)
{
    json_t *list = json_array();
    for (uint32_t s = 0; s < curves->search->scenario.spring_count; s++)
        for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
            for (int b = 0; b < BOUND_COUNT; b++) {
                const struct curve curve = {.curves = curves,
                                            .spring = s,
                                            .direction = (enum scenario_direction)d,
                                            .bound = (enum bound)b};
                json_t *points = json_array();
                for (uint32_t k = 0; k < spring_of(&curve)->point_count; k++)
                    json_array_append_new(
                        points, json_pack("[f, f]", deformation(&curve, k), force(&curve, k)));
                json_array_append_new(
                    list, json_pack("{s:s, s:s, s:s, s:o, s:i}", "spring", spring_of(&curve)->name,
                                    "direction", scenario_direction_name(curve.direction), "bound",
                                    bound_names[b], "points", points, "points_reached",
                                    (int)reach_points(&curves->search->reach,
                                                      &curves->search->scenario, s)));
            }
    json_t *root =
        json_pack("{s:s, s:s, s:s, s:s, s:s, s:o}", "run", curves->run_name, "search",
                  curves->search->name, "units", curves->units->name, "deformation_unit",
                  curves->units->length, "force_unit", curves->units->force, "curves", list);
    assert(root != NULL); // names are UTF-8, numbers finite: run_data.c saw to it
    char *text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    char *line = g_strconcat(text, "\n", NULL);
    free(text);
    json_decref(root);
    return line;
}

char *curves_text(const struct curves *curves, enum curves_format format)
{
    GString *text = g_string_new(NULL);
    switch (format) {
    case CURVES_LS_DYNA:
        g_string_append(text, "*KEYWORD\n");
        put_comments(text, curves, "$");
        each_curve(curves, text, write_ls_dyna);
        g_string_append(text, "*END\n");
        break;
    case CURVES_OPENRADIOSS:
        put_comments(text, curves, "#");
        each_curve(curves, text, write_openradioss);
        break;
    case CURVES_CSV:
        g_string_append_printf(text, "spring,direction,bound,deformation_%s,force_%s,reached\n",
                               curves->units->length, curves->units->force);
        each_curve(curves, text, write_csv);
        break;
    case CURVES_JSON:
        g_string_free(text, TRUE);
        return json_text(curves);
    case CURVES_FORMAT_COUNT:
        break;
    }
    return g_string_free(text, FALSE);
}
