#include "monitor/http/xray.h"

#include "common/table/decimal.h"
#include "monitor/feed/feed.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// values[variable * picture->count + i] belongs to sample i. The caller frees them.
static double *samples_of(const struct album_picture *picture)
{
    double *values = g_new(double, (gsize)picture->sampled.count * picture->count);
    sampling_fill(&picture->sampling, &picture->sampled, 0, picture->count, values, picture->count);
    return values;
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

// ---- Points ----

static json_t *constraint_json(const struct album_picture *picture, const struct verdict *verdict)
{
    if (verdict->violation == VERDICT_GOOD)
        return json_integer(-1);
    return picture->detail == VERDICT_DETAIL_FULL ? json_integer(verdict->constraint) : json_null();
}

static json_t *violation_json(const struct album_picture *picture, const struct verdict *verdict)
{
    return picture->detail == VERDICT_DETAIL_FULL && verdict->violation != VERDICT_GOOD
               ? number(verdict_relative(verdict->violation))
               : json_null();
}

static json_t *sides(const struct box *box, uint32_t x, uint32_t y)
{
    return json_pack("{s:[o, o], s:[o, o]}", "x", number(box->lower[x]), number(box->upper[x]), "y",
                     number(box->lower[y]), number(box->upper[y]));
}

bool xray_points(const struct album_picture *picture, uint32_t x, uint32_t y, GString *out)
{
    if (x >= picture->sampled.count || y >= picture->sampled.count)
        return false;
    double *values = samples_of(picture);
    json_t *points = json_array();
    for (uint32_t i = 0; i < picture->count; i++) {
        const struct verdict *verdict = &picture->verdicts[i];
        json_array_append_new(
            points, json_pack("[o, o, o, o]", number(values[(gsize)x * picture->count + i]),
                              number(values[(gsize)y * picture->count + i]),
                              constraint_json(picture, verdict), violation_json(picture, verdict)));
    }
    g_free(values);
    json_t *object = json_pack(
        "{s:I, s:s, s:s, s:o, s:I, s:I, s:I, s:I, s:I, s:o, s:o, s:o}", "step",
        (json_int_t)picture->sampling.step, "phase", protocol_phase_name(picture->phase), "detail",
        picture->detail == VERDICT_DETAIL_FULL ? "full" : "share", "seed",
        json_sprintf("%" PRIu64, picture->sampling.seed), "samples",
        (json_int_t)picture->sampling.samples, "good", (json_int_t)picture->good, "count",
        (json_int_t)picture->count, "x", (json_int_t)x, "y", (json_int_t)y, "sampled",
        sides(&picture->sampled, x, y), "box", sides(&picture->box, x, y), "points", points);
    char *text = json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(9));
    g_string_append(out, text);
    g_string_append_c(out, '\n');
    free(text);
    json_decref(object);
    return true;
}

// ---- Tables ----

// A name as a field of CSV: one that a spreadsheet would take for a formula is made text.
static void append_name(GString *out, const char *name)
{
    g_string_append_c(out, '"');
    if (strchr("=+-@\t\r", name[0]) != NULL && name[0] != '\0')
        g_string_append_c(out, '\'');
    for (; *name != '\0'; name++)
        g_string_append(out, *name == '"' ? "\"\"" : (char[]){*name, '\0'});
    g_string_append_c(out, '"');
}

static void append_double(GString *out, double value)
{
    char text[DECIMAL_SIZE];
    g_string_append(out, decimal_text(value, text));
}

static void append_verdict(GString *out, const struct album_picture *picture,
                           const struct scenario *scenario, const struct verdict *verdict)
{
    const bool good = verdict->violation == VERDICT_GOOD;
    g_string_append(out, good ? "1," : "0,");
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    if (!good && picture->detail == VERDICT_DETAIL_FULL) {
        if (scenario != NULL && verdict->constraint < scenario->constraint_count)
            append_name(out,
                        scenario_outcome_name(
                            scenario, scenario->constraints[verdict->constraint].outcome, name));
        else
            g_string_append_printf(out, "%u", verdict->constraint);
        g_string_append_c(out, ',');
        append_double(out, verdict_relative(verdict->violation));
    } else {
        g_string_append_c(out, ',');
    }
}

void xray_csv(const struct album_picture *picture, const struct scenario *scenario, GString *out)
{
    const uint32_t variables = picture->sampled.count;
    if (scenario != NULL && scenario->design_space.count != variables)
        scenario = NULL;
    g_string_append(out, "sample,good,violates_most,relative_violation");
    for (uint32_t v = 0; v < variables; v++) {
        char number[32];
        g_snprintf(number, sizeof number, "variable %" PRIu32, v + 1);
        g_string_append_c(out, ',');
        append_name(out, scenario != NULL ? scenario->variables[v].name : number);
    }
    g_string_append_c(out, '\n');
    double *values = samples_of(picture);
    for (uint32_t i = 0; i < picture->count; i++) {
        g_string_append_printf(out, "%" PRIu32 ",", i);
        append_verdict(out, picture, scenario, &picture->verdicts[i]);
        for (uint32_t v = 0; v < variables; v++) {
            g_string_append_c(out, ',');
            append_double(out, values[(gsize)v * picture->count + i]);
        }
        g_string_append_c(out, '\n');
    }
    g_free(values);
}

json_t *xray_constraints(const struct scenario *scenario)
{
    json_t *array = json_array();
    for (uint32_t i = 0; i < scenario->constraint_count; i++) {
        const struct scenario_constraint *constraint = &scenario->constraints[i];
        char name[SCENARIO_OUTCOME_NAME_SIZE];
        json_array_append_new(
            array, json_pack("{s:s, s:s, s:o, s:o}", "outcome",
                             scenario_outcome_name(scenario, constraint->outcome, name), "unit",
                             scenario_outcome_unit(scenario, constraint->outcome), "min",
                             number(constraint->min), "max", number(constraint->max)));
    }
    return array;
}
