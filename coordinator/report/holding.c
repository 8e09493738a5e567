#include "coordinator/report/holding.h"

#include "coordinator/report/number.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// ---- words ----

// " kg" behind a number; nothing behind one without a unit.
static const char *unit_words(const struct scenario *scenario, uint32_t outcome, char words[32])
{
    const char *unit = scenario_outcome_unit(scenario, outcome);
    g_snprintf(words, 32, "%s%s", strcmp(unit, "1") == 0 ? "" : " ",
               strcmp(unit, "1") == 0 ? "" : unit);
    return words;
}

char *holding_constraint(const struct scenario *scenario, uint32_t index, bool normalise)
{
    const struct scenario_constraint *constraint = &scenario->constraints[index];
    char name[SCENARIO_OUTCOME_NAME_SIZE], unit[32];
    if (normalise)
        return g_strdup(scenario_outcome_name(scenario, constraint->outcome, name));
    GString *words = g_string_new(NULL);
    if (isfinite(constraint->min) && isfinite(constraint->max))
        g_string_append_printf(words, "%g <= ", constraint->min);
    g_string_append(words, scenario_outcome_name(scenario, constraint->outcome, name));
    if (isfinite(constraint->max))
        g_string_append_printf(words, " <= %g", constraint->max);
    else
        g_string_append_printf(words, " >= %g", constraint->min);
    g_string_append(words, unit_words(scenario, constraint->outcome, unit));
    return g_string_free(words, FALSE);
}

// Its limits alone, moved outwards by `slack`: "0.2475 m", "-20.2 to 20.2 deg".
static char *relaxed_words(const struct scenario *scenario, uint32_t index, double slack)
{
    const struct scenario_constraint *constraint = &scenario->constraints[index];
    char unit[32];
    GString *words = g_string_new(NULL);
    if (isfinite(constraint->min))
        g_string_append_printf(words, "%g", constraint->min - slack);
    if (isfinite(constraint->min) && isfinite(constraint->max))
        g_string_append(words, " to ");
    if (isfinite(constraint->max))
        g_string_append_printf(words, "%g", constraint->max + slack);
    g_string_append(words, unit_words(scenario, constraint->outcome, unit));
    return g_string_free(words, FALSE);
}

static bool is_known(const struct run_data_search *search)
{
    return search->explain.scenario != NULL && search->explain.taken == search->explain.step_count;
}

static char *gain_words(const struct explain_gain *gain)
{
    if (isnan(gain->log_volume))
        return g_strdup("not known");
    return g_strdup_printf("%s%.3f", gain->at_least ? "at least +" : "+", gain->log_volume);
}

char *holding_costliest(const struct run_data_search *search)
{
    const struct explain *explain = &search->explain;
    uint32_t most = UINT32_MAX;
    for (uint32_t c = 0; is_known(search) && c < search->scenario.constraint_count; c++) {
        if (explain->gains[c].log_volume > 0 &&
            (most == UINT32_MAX || explain->gains[c].log_volume > explain->gains[most].log_volume))
            most = c;
    }
    if (most == UINT32_MAX)
        return NULL;
    char *constraint = holding_constraint(&search->scenario, most, false);
    char *gain = gain_words(&explain->gains[most]);
    char *words = g_strdup_printf("%s (%s)", constraint, gain);
    g_free(constraint);
    g_free(gain);
    return words;
}

static const struct explain_bound *bound_of(const struct run_data_search *search, uint32_t variable,
                                            bool upper)
{
    return &search->explain.bounds[2 * variable + (upper ? 1 : 0)];
}

// ---- by constraint ----

static uint32_t count_held(const struct explain *explain, enum explain_holder holder,
                           uint32_t constraint)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < 2 * explain->box.count; i++)
        count += explain->bounds[i].holder == holder &&
                 (holder != EXPLAIN_CONSTRAINT || explain->bounds[i].constraint == constraint);
    return count;
}

static void print_count(const struct explain *explain, enum explain_holder holder, const char *name,
                        FILE *out)
{
    const uint32_t count = count_held(explain, holder, 0);
    if (count > 0)
        fprintf(out, "  %-34s %6" PRIu32 "\n", name, count);
}

static void print_constraint(const struct run_data_search *search, uint32_t index, bool normalise,
                             FILE *out)
{
    const struct explain *explain = &search->explain;
    const struct explain_gain *gain = &explain->gains[index];
    char *words = holding_constraint(&search->scenario, index, normalise);
    char *gained = gain_words(gain);
    char *relaxed =
        normalise ? g_strdup("-") : relaxed_words(&search->scenario, index, gain->amount);
    fprintf(out, "  %-34s %6" PRIu32 "   %-22s %10s\n", words,
            count_held(explain, EXPLAIN_CONSTRAINT, index), relaxed, gained);
    g_free(relaxed);
    g_free(gained);
    g_free(words);
}

void holding_print_summary(const struct run_data_search *search, bool normalise, FILE *out)
{
    const struct explain *explain = &search->explain;
    if (!is_known(search))
        return;
    fprintf(out, "\n%-36s %6s   %-22s %10s\n", "what holds the corridors", "bounds",
            "relaxed by 1 %, to", "log-volume");
    for (uint32_t c = 0; c < search->scenario.constraint_count; c++)
        print_constraint(search, c, normalise, out);
    print_count(explain, EXPLAIN_DESIGN_SPACE, "edge of the design space", out);
    print_count(explain, EXPLAIN_NOTHING, "nothing: as good just outside", out);
    print_count(explain, EXPLAIN_HELD, "held by search.hold", out);
    print_count(explain, EXPLAIN_FIXED, "fixed", out);
}

// ---- by bound ----

enum { HOLDER_WIDTH = 25 }; // columns

static char *holder_words(const struct run_data_search *search, const struct explain_bound *bound,
                          bool normalise)
{
    char *words = NULL;
    switch (bound->holder) {
    case EXPLAIN_CONSTRAINT:
        words = holding_constraint(&search->scenario, bound->constraint, normalise);
        break;
    case EXPLAIN_NOTHING:
        words = g_strdup("nothing");
        break;
    case EXPLAIN_DESIGN_SPACE:
        words = g_strdup("edge of design space");
        break;
    default:
        words = g_strdup(explain_holder_name(bound->holder));
        break;
    }
    char *marked = g_strconcat(words, bound->at_minimum_width ? " (w)" : "",
                               bound->at_reference ? " (r)" : "", NULL);
    g_free(words);
    return marked;
}

static void print_holder(const struct run_data_search *search, uint32_t variable, bool upper,
                         bool normalise, FILE *out)
{
    const struct explain_bound *bound = bound_of(search, variable, upper);
    char *words = holder_words(search, bound, normalise);
    fprintf(out, "  %-*s", HOLDER_WIDTH, words);
    if (bound->samples > 0)
        fprintf(out, " %5.1f", 100 * (double)bound->good / (double)bound->samples);
    else
        fprintf(out, " %5s", "-");
    g_free(words);
}

static void print_both(const struct run_data_search *search, uint32_t variable, bool normalise,
                       FILE *out)
{
    print_holder(search, variable, false, normalise, out);
    print_holder(search, variable, true, normalise, out);
    fputc('\n', out);
}

static void print_head(const char *place, const char *unit, FILE *out)
{
    fprintf(out, "\n%-11.11s  %-*s %5s  %-*s %5s\n", place, HOLDER_WIDTH, "lower bound held by",
            "good", HOLDER_WIDTH, "upper bound held by", "good");
    fprintf(out, "%11s  %-*s %5s  %-*s %5s\n", unit, HOLDER_WIDTH, "", "[%]", HOLDER_WIDTH, "",
            "[%]");
}

static void print_spring(const struct run_data_search *search, uint32_t index,
                         enum scenario_direction direction, bool normalise, FILE *out)
{
    const struct scenario_spring *spring = &search->scenario.springs[index];
    const double first = normalise ? spring->deformation[0] : 0;
    const double span = normalise ? spring->deformation[spring->point_count - 1] - first : 1;
    fprintf(out, "\n%s F_%s", spring->name, scenario_direction_name(direction));
    print_head("deformation", normalise ? "" : "[m]", out);
    for (uint32_t k = 0; k < spring->point_count; k++) {
        fprintf(out, "%11.3f", (spring->deformation[k] - first) / span);
        print_both(search, run_data_variable(search, index, direction, k), normalise, out);
    }
}

static void print_marks(const struct explain *explain, FILE *out)
{
    bool width = false, reference = false;
    for (uint32_t i = 0; i < 2 * explain->box.count; i++) {
        width = width || explain->bounds[i].at_minimum_width;
        reference = reference || explain->bounds[i].at_reference;
    }
    if (width)
        fputs("(w) the corridor is no wider than search.minimum_widths asks for\n", out);
    if (reference)
        fputs("(r) the bound lies on search.reference\n", out);
}

void holding_print_bounds(const struct run_data_search *search, bool normalise, FILE *out)
{
    const struct scenario *scenario = &search->scenario;
    if (!is_known(search))
        return;
    fputs("\nwhat holds each corridor: good is the share of good designs just outside the\n"
          "bound, within a tenth of the corridor's width, all else inside its corridor\n",
          out);
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
            print_spring(search, i, (enum scenario_direction)d, normalise, out);
    if (scenario->spring_count == 0)
        print_head("variable", "", out);
    for (uint32_t i = 0; scenario->spring_count == 0 && i < scenario->design_space.count; i++) {
        fprintf(out, "%-11.11s", scenario->variables[i].name);
        print_both(search, i, normalise, out);
    }
    print_marks(&search->explain, out);
}

// ---- JSON ----

static json_t *json_finite(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static void json_constraint(json_t *object, const struct scenario *scenario, uint32_t index)
{
    const struct scenario_constraint *constraint = &scenario->constraints[index];
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    json_object_set_new(object, "outcome",
                        json_string(scenario_outcome_name(scenario, constraint->outcome, name)));
    if (isfinite(constraint->min))
        json_object_set_new(object, "min", json_real(constraint->min));
    if (isfinite(constraint->max))
        json_object_set_new(object, "max", json_real(constraint->max));
}

json_t *holding_json_bound(const struct run_data_search *search, uint32_t variable, bool upper)
{
    if (search->explain.scenario == NULL)
        return json_null();
    const struct explain_bound *bound = bound_of(search, variable, upper);
    json_t *object = json_pack("{s:s}", "holder", explain_holder_name(bound->holder));
    if (bound->holder == EXPLAIN_CONSTRAINT)
        json_constraint(object, &search->scenario, bound->constraint);
    if (bound->samples > 0) {
        json_object_set_new(object, "samples", json_integer((json_int_t)bound->samples));
        json_object_set_new(object, "good", json_integer((json_int_t)bound->good));
        json_object_set_new(object, "violated", json_integer((json_int_t)bound->violated));
        json_object_set_new(object, "good_share",
                            json_real((double)bound->good / (double)bound->samples));
    }
    if (bound->at_minimum_width)
        json_object_set_new(object, "at_minimum_width", json_true());
    if (bound->at_reference)
        json_object_set_new(object, "at_reference", json_true());
    return object;
}

json_t *holding_json_constraints(const struct run_data_search *search)
{
    const struct explain *explain = &search->explain;
    json_t *array = json_array();
    for (uint32_t c = 0; c < search->scenario.constraint_count; c++) {
        json_t *object = json_object();
        json_constraint(object, &search->scenario, c);
        json_object_set_new(object, "unit",
                            json_string(scenario_outcome_unit(
                                &search->scenario, search->scenario.constraints[c].outcome)));
        if (is_known(search)) {
            const struct explain_gain *gain = &explain->gains[c];
            json_object_set_new(
                object, "holds",
                json_integer((json_int_t)count_held(explain, EXPLAIN_CONSTRAINT, c)));
            json_object_set_new(object, "relaxed_by", json_real(gain->amount));
            json_object_set_new(object, "log_volume_gain", json_finite(gain->log_volume));
            json_object_set_new(object, "gain_at_least", json_boolean(gain->at_least));
        }
        json_array_append_new(array, object);
    }
    return array;
}

// ---- without a good design ----

static bool has_least(const struct run_data_search *search)
{
    return run_data_found_nothing(search) && search->judged == search->bad &&
           search->least_constraint != UINT32_MAX &&
           search->record.box.count == search->scenario.design_space.count;
}

json_t *holding_json_least(const struct run_data_search *search)
{
    const struct scenario *scenario = &search->scenario;
    if (!has_least(search))
        return json_null();
    const double relative = verdict_relative(search->least_violation);
    json_t *object = json_object(), *design = json_array();
    for (uint32_t i = 0; i < search->record.box.count; i++)
        json_array_append_new(design,
                              json_pack("{s:s, s:o}", "name", scenario->variables[i].name, "value",
                                        json_finite(0.5 * search->record.box.lower[i] +
                                                    0.5 * search->record.box.upper[i])));
    json_constraint(object, scenario, search->least_constraint);
    json_object_set_new(
        object, "missed_by",
        json_finite(relative * scenario->constraints[search->least_constraint].scale));
    json_object_set_new(object, "design", design);
    return object;
}

void holding_print_least(const struct run_data_search *search, bool normalise, FILE *out)
{
    const struct scenario *scenario = &search->scenario;
    if (!has_least(search))
        return;
    const struct scenario_constraint *constraint = &scenario->constraints[search->least_constraint];
    const double missed = verdict_relative(search->least_violation) * constraint->scale;
    char *words = holding_constraint(scenario, search->least_constraint, normalise);
    char unit[32];
    if (isfinite(missed) && normalise)
        fprintf(out, "nearest      a design that misses %s by %.2g %% of its limit\n", words,
                100 * verdict_relative(search->least_violation));
    else if (isfinite(missed))
        fprintf(out, "nearest      a design that misses %s by %.3g%s (see result.json)\n", words,
                missed, unit_words(scenario, constraint->outcome, unit));
    else
        fputs("nearest      none: no design had finite outcomes\n", out);
    g_free(words);
}
