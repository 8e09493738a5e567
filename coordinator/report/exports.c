// result.json, corridors.csv, history.csv and, of a sweep, summary.csv. They are written side by
// side, one search after the other, so that a sweep of any size costs the memory of one search.
#include "common/base/plain.h"
#include "common/base/whole_file.h"
#include "common/table/decimal.h"
#include "coordinator/report/holding.h"
#include "coordinator/report/number.h"
#include "coordinator/report/report.h"
#include "coordinator/report/run_data.h"
#include "coordinator/report/seeds.h"
#include "coordinator/report/warnings.h"
#include "coordinator/report/worst.h"

#include <assert.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <string.h>

// ---- CSV ----

static void csv_number(FILE *csv, double value)
{
    char text[NUMBER_SIZE];
    fprintf(csv, ",%s", decimal_text(value, text));
}

// A number that is not known is an empty cell.
static void csv_known(FILE *csv, bool known, double value)
{
    if (known)
        csv_number(csv, value);
    else
        fputc(',', csv);
}

// Where a corridor's interval belongs: a point of a spring, or the variable that it is alone.
static void corridor_place(FILE *csv, uint32_t index, const struct scenario *scenario,
                           const struct scenario_variable *variable)
{
    if (variable->spring == SCENARIO_NO_SPRING) {
        fprintf(csv, "%" PRIu32 ",%s,,", index, variable->name);
        return;
    }
    const struct scenario_spring *spring = &scenario->springs[variable->spring];
    fprintf(csv, "%" PRIu32 ",%s,%s", index, spring->name,
            scenario_direction_name(variable->direction));
    csv_number(csv, spring->deformation[variable->point]);
}

// Of a variable that is no spring's force it is not known what it means in a crash.
static const char *reach_word(const struct run_data_search *search, uint32_t variable)
{
    if (search->reach.spring_count == 0)
        return "";
    return reach_variable(&search->reach, &search->scenario, variable) ? "yes" : "no";
}

// Of a run of several seeds the best box is the result; its bounds have a spread.
static void corridor_rows(FILE *csv, uint32_t index, const struct run_data_search *search,
                          const struct seeds *seeds)
{
    const bool alone = seeds->spread.count > 0;
    if (alone && index != seeds->best)
        return;
    const struct scenario *scenario = &search->scenario;
    for (uint32_t i = 0; search->box != NULL && i < search->box->count; i++) {
        corridor_place(csv, index, scenario, &scenario->variables[i]);
        csv_number(csv, search->box->lower[i]);
        csv_number(csv, search->box->upper[i]);
        csv_number(csv, scenario->design_space.lower[i]);
        csv_number(csv, scenario->design_space.upper[i]);
        fprintf(csv, ",%s", reach_word(search, i));
        if (alone) {
            csv_known(csv, !isnan(seeds->spread.lower[i]), seeds->spread.lower[i]);
            csv_known(csv, !isnan(seeds->spread.upper[i]), seeds->spread.upper[i]);
        }
        fputc('\n', csv);
    }
}

static void history_rows(FILE *csv, uint32_t index, const struct run_data_search *search)
{
    for (guint i = 0; i < search->steps->len; i++) {
        const struct run_step *step = &g_array_index(search->steps, struct run_step, i);
        fprintf(csv, "%" PRIu32 ",%s,%" PRIu32 ",%" PRIu32 ",%" PRIu32, index, step->phase,
                step->step, step->samples, step->good);
        csv_number(csv, step->growth);
        csv_number(csv, step->log_volume);
        fputc('\n', csv);
    }
}

// ---- The summary of a sweep ----

// A cell that may hold anything.
static void csv_text(FILE *csv, const char *text)
{
    char *plain = plain_text(text);
    if (strpbrk(plain, ",\"") == NULL) {
        fputs(plain, csv);
    } else {
        fputc('"', csv);
        for (const char *c = plain; *c != '\0'; c++) {
            if (*c == '"')
                fputc('"', csv);
            fputc(*c, csv);
        }
        fputc('"', csv);
    }
    g_free(plain);
}

// The columns of the corridors are those of the first case; in a case that has other variables the
// ones it lacks stay empty.
static void summary_header(FILE *csv, const struct run_data *data, char **variables)
{
    fputs("case", csv);
    for (char **axis = data->axes; *axis != NULL; axis++) {
        fputc(',', csv);
        csv_text(csv, *axis);
    }
    fputs(",status,log_volume,purity_estimate,purity_lower95,evaluations,wall_s,digest", csv);
    for (char **variable = variables; *variable != NULL; variable++) {
        char *lower = g_strconcat(*variable, ".lower", NULL);
        char *upper = g_strconcat(*variable, ".upper", NULL);
        fputc(',', csv);
        csv_text(csv, lower);
        fputc(',', csv);
        csv_text(csv, upper);
        g_free(lower);
        g_free(upper);
    }
    fputc('\n', csv);
}

// The variable of that name; it mostly stands where it stood in the first case.
static const struct scenario_variable *find_variable(const struct scenario *scenario,
                                                     const char *name, uint32_t likely)
{
    const uint32_t count = scenario->design_space.count;
    for (uint32_t i = 0; i < count; i++) {
        const struct scenario_variable *variable = &scenario->variables[(likely + i) % count];
        if (strcmp(variable->name, name) == 0)
            return variable;
    }
    return NULL;
}

static void summary_row(FILE *csv, const struct run_data_search *search, char **variables)
{
    const struct journal_search *record = &search->record;
    const bool certified = record->finished && record->purity_samples > 0;
    char hex[DIGEST_HEX_SIZE];
    csv_text(csv, search->name);
    for (char **value = search->values; *value != NULL; value++) {
        fputc(',', csv);
        csv_text(csv, *value);
    }
    fprintf(csv, ",%s", search->status);
    csv_known(csv, search->box != NULL, search->log_volume);
    csv_known(csv, certified, record->purity_estimate);
    csv_known(csv, certified, record->purity_lower95);
    fprintf(csv, ",%" PRIu64, search->evaluations);
    csv_number(csv, (double)search->wall_ns * 1e-9);
    fprintf(csv, ",%s", record->finished ? digest_hex(&record->digest, hex) : "");
    for (uint32_t v = 0; variables[v] != NULL; v++) {
        const struct scenario *scenario = &search->scenario;
        const struct scenario_variable *variable = find_variable(scenario, variables[v], v);
        const bool known = search->box != NULL && variable != NULL;
        const size_t place = known ? (size_t)(variable - scenario->variables) : 0;
        csv_known(csv, known, known ? search->box->lower[place] : 0);
        csv_known(csv, known, known ? search->box->upper[place] : 0);
    }
    fputc('\n', csv);
}

static char **variable_names(const struct scenario *scenario)
{
    char **names = g_new0(char *, scenario->design_space.count + 1);
    for (uint32_t i = 0; i < scenario->design_space.count; i++)
        names[i] = g_strdup(scenario->variables[i].name);
    return names;
}

// ---- JSON ----

// JSON knows no infinity and no NaN.
static json_t *json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

// JSON integers end at 2^63 - 1 here; greater ones become text rather than wrong.
static json_t *json_unsigned(uint64_t value)
{
    if (value <= INT64_MAX)
        return json_integer((json_int_t)value);
    char text[NUMBER_SIZE];
    g_snprintf(text, sizeof text, "%" PRIu64, value);
    return json_string(text);
}

static json_t *json_interval(const struct box *box, uint32_t variable)
{
    if (box == NULL)
        return json_null();
    return json_pack("[f, f]", box->lower[variable], box->upper[variable]);
}

// The point of a spring that a variable is the force of.
static void json_place(json_t *object, const struct scenario *scenario,
                       const struct scenario_variable *variable)
{
    const struct scenario_spring *spring = &scenario->springs[variable->spring];
    json_object_set_new(object, "spring", json_string(spring->name));
    json_object_set_new(object, "direction",
                        json_string(scenario_direction_name(variable->direction)));
    json_object_set_new(object, "deformation_m", json_real(spring->deformation[variable->point]));
}

static json_t *json_variables(const struct run_data_search *search)
{
    const struct scenario *scenario = &search->scenario;
    json_t *variables = json_array();
    for (uint32_t i = 0; i < scenario->design_space.count; i++) {
        const struct scenario_variable *variable = &scenario->variables[i];
        json_t *object = json_pack("{s:s}", "name", variable->name);
        if (variable->spring != SCENARIO_NO_SPRING)
            json_place(object, scenario, variable);
        json_object_set_new(object, "design", json_interval(&scenario->design_space, i));
        json_object_set_new(object, "corridor", json_interval(search->box, i));
        if (search->reach.spring_count > 0)
            json_object_set_new(object, "reached",
                                json_boolean(reach_variable(&search->reach, &search->scenario, i)));
        json_object_set_new(object, "lower", holding_json_bound(search, i, false));
        json_object_set_new(object, "upper", holding_json_bound(search, i, true));
        json_array_append_new(variables, object);
    }
    return variables;
}

// Which designs were looked at, how many of them turn too far, and how far they press each spring.
static json_t *json_reach(const struct run_data_search *search)
{
    const struct scenario *scenario = &search->scenario;
    if (search->reach.spring_count == 0)
        return json_null();
    json_t *springs = json_array();
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        json_array_append_new(
            springs, json_pack("{s:s, s:f, s:i, s:i}", "spring", scenario->springs[i].name,
                               "deformation_max_m", search->reach.deformation_max[i], "points",
                               (int)scenario->springs[i].point_count, "points_reached",
                               (int)reach_points(&search->reach, scenario, i)));
    return json_pack("{s:i, s:{s:i, s:i, s:i, s:i}, s:i, s:o}", "designs", (int)REACH_DESIGNS,
                     "kinds", "points", (int)REACH_POINTS, "curves", (int)REACH_CURVES, "levels",
                     (int)REACH_LEVELS, "bounds", (int)REACH_BOUNDS, "yaw_beyond_90_deg",
                     (int)search->reach.turned, "springs", springs);
}

static json_t *json_look(uint64_t samples, uint64_t bad, double estimate, double lower95)
{
    return json_pack("{s:o, s:o, s:o, s:o}", "samples", json_unsigned(samples), "bad",
                     json_unsigned(bad), "estimate", json_number(estimate), "lower95",
                     json_number(lower95));
}

static json_t *json_purity(const struct journal_search *record)
{
    if (!record->finished || record->purity_samples == 0)
        return json_null();
    return json_look(record->purity_samples, record->purity_bad, record->purity_estimate,
                     record->purity_lower95);
}

// Of each kind of designs that was looked at, points among them.
static json_t *json_kinds(const struct run_data_search *search)
{
    json_t *kinds = json_object();
    json_t *points = json_purity(&search->record);
    if (json_is_object(points))
        json_object_set(kinds, protocol_kind_name(DESIGN_KIND_POINTS), points);
    json_decref(points);
    for (int kind = DESIGN_KIND_POINTS + 1; kind < DESIGN_KIND_COUNT; kind++) {
        const uint64_t samples = search->kinds[kind].samples;
        const uint64_t bad = search->kinds[kind].bad;
        if (samples > 0)
            json_object_set_new(kinds, protocol_kind_name((enum design_kind)kind),
                                json_look(samples, bad, (double)(samples - bad) / (double)samples,
                                          search->kinds[kind].lower95));
    }
    return kinds;
}

// What the bounds were rounded to, and the variables whose interval was left as it was found.
static json_t *json_round(const struct run_data_search *search)
{
    const struct scenario *scenario = &search->scenario;
    json_t *left = json_array();
    for (uint32_t v = 0; search->box != NULL && v < search->box->count; v++) {
        if (!scenario_is_rounded(scenario, search->box, v))
            json_array_append_new(left, json_string(scenario->variables[v].name));
    }
    return json_pack("{s:f, s:o}", "step", scenario->search.round, "left", left);
}

static json_t *json_case(const struct run_data *data, const struct run_data_search *search)
{
    json_t *values = json_object();
    for (size_t i = 0; data->axes[i] != NULL; i++)
        json_object_set_new(values, data->axes[i], json_string(search->values[i]));
    return values;
}

static json_t *json_warnings(const struct run_data_search *search)
{
    json_t *warnings = json_array();
    char **texts = warnings_of(search);
    for (char **text = texts; *text != NULL; text++)
        json_array_append_new(warnings, json_string(*text));
    g_strfreev(texts);
    return warnings;
}

static json_t *json_search(const struct run_data *data, const struct run_data_search *search)
{
    const struct journal_search *record = &search->record;
    char hex[DIGEST_HEX_SIZE];
    json_t *object = json_pack(
        "{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:I, s:f}", "name", search->name, "status",
        search->status, "seed", json_unsigned(record->seed), "variables", json_variables(search),
        "log_volume", search->box != NULL ? json_number(search->log_volume) : json_null(), "purity",
        json_purity(record), "evaluations", json_unsigned(search->evaluations), "steps",
        (json_int_t)search->steps->len, "wall_s", (double)search->wall_ns * 1e-9);
    if (data->axes[0] != NULL)
        json_object_set_new(object, "case", json_case(data, search));
    if (record->finished && search->scenario.search.round > 0)
        json_object_set_new(object, "round", json_round(search));
    if (record->finished)
        json_object_set_new(object, "non_finite", json_unsigned(record->non_finite));
    json_object_set_new(object, "warnings", json_warnings(search));
    json_object_set_new(object, "promise",
                        json_string(protocol_promise_name(search->scenario.search.promise)));
    json_object_set_new(object, "kinds", json_kinds(search));
    json_object_set_new(object, "worst", worst_json(search));
    json_object_set_new(object, "reach", json_reach(search));
    json_object_set_new(object, "constraints", holding_json_constraints(search));
    if (record->blocking_constraint[0] != '\0') {
        json_object_set_new(object, "blocking_constraint",
                            json_string(record->blocking_constraint));
        json_object_set_new(object, "least_violating_design", holding_json_least(search));
    }
    json_object_set_new(object, "digest",
                        record->finished ? json_string(digest_hex(&record->digest, hex))
                                         : json_null());
    return object;
}

static json_t *json_bound(double value, double spread)
{
    return json_pack("{s:f, s:o}", "value", value, "spread", json_number(spread));
}

// What several seeds say of the best box.
static json_t *json_seeds(const struct seeds *seeds, const struct run_data_search *best)
{
    json_t *variables = json_array();
    for (uint32_t v = 0; v < seeds->spread.count; v++)
        json_array_append_new(
            variables, json_pack("{s:s, s:o, s:o}", "name", best->scenario.variables[v].name,
                                 "lower", json_bound(best->box->lower[v], seeds->spread.lower[v]),
                                 "upper", json_bound(best->box->upper[v], seeds->spread.upper[v])));
    json_t *log_volume = json_pack("{s:o, s:o, s:o, s:o}", "best", json_number(seeds->log_volume),
                                   "mean", json_number(seeds->log_volume_mean), "least",
                                   json_number(seeds->log_volume_least), "spread",
                                   json_number(seeds->log_volume_spread));
    return json_pack("{s:i, s:i, s:o, s:o}", "best", (int)seeds->best, "searches",
                     (int)seeds->searches, "log_volume", log_volume, "variables", variables);
}

// Writes a value as part of a greater one, its lines moved to the right.
static void json_put(FILE *out, json_t *value, const char *indent)
{
    assert(value != NULL); // all text is UTF-8 and all numbers are finite: run_data.c saw to it
    char *text = json_dumps(value, JSON_INDENT(2) | JSON_REAL_PRECISION(17) | JSON_ENCODE_ANY);
    for (const char *c = text; *c != '\0'; c++) {
        fputc(*c, out);
        if (*c == '\n') // in strings it is written as \n
            fputs(indent, out);
    }
    free(text);
    json_decref(value);
}

static void json_begin(FILE *out, const struct run_data *data)
{
    fputs("{\n  \"name\": ", out);
    json_put(out, json_string(data->run.name), "");
    fputs(",\n  \"version\": ", out);
    json_put(out, json_string(data->run.version), "");
    fputs(",\n  \"searches\": [", out);
}

static void json_end(FILE *out, json_t *seeds)
{
    fputs("\n  ]", out);
    if (seeds != NULL) {
        fputs(",\n  \"seeds\": ", out);
        json_put(out, seeds, "  ");
    }
    fputs("\n}\n", out);
}

// ---- All of them ----

// In the order in which they are put in their places: where result.json is, the others are.
enum export {
    EXPORT_CORRIDORS,
    EXPORT_HISTORY,
    EXPORT_SUMMARY,
    EXPORT_WORST,
    EXPORT_JSON,
    EXPORT_COUNT
};

static const char *const export_names[EXPORT_COUNT] = {
    [EXPORT_CORRIDORS] = "corridors.csv", [EXPORT_HISTORY] = "history.csv",
    [EXPORT_SUMMARY] = "summary.csv",     [EXPORT_WORST] = "worst.csv",
    [EXPORT_JSON] = "result.json",
};

struct exports {
    const struct run_data *data;
    struct whole_file files[EXPORT_COUNT];
    char **variables;   // of the first search
    struct seeds seeds; // of a run that differs in its seeds alone
    json_t *json_seeds; // NULL before the best search
};

static void put_search(struct exports *exports, uint32_t index,
                       const struct run_data_search *search)
{
    FILE *json = exports->files[EXPORT_JSON].file, *summary = exports->files[EXPORT_SUMMARY].file;
    fputs(index == 0 ? "\n    " : ",\n    ", json);
    json_put(json, json_search(exports->data, search), "    ");
    corridor_rows(exports->files[EXPORT_CORRIDORS].file, index, search, &exports->seeds);
    if (exports->seeds.spread.count > 0 && index == exports->seeds.best)
        exports->json_seeds = json_seeds(&exports->seeds, search);
    history_rows(exports->files[EXPORT_HISTORY].file, index, search);
    if (exports->files[EXPORT_WORST].file != NULL)
        worst_write(search, exports->files[EXPORT_WORST].file);
    if (summary == NULL)
        return;
    if (index == 0) {
        exports->variables = variable_names(&search->scenario);
        summary_header(summary, exports->data, exports->variables);
    }
    summary_row(summary, search, exports->variables);
}

static enum status exports_begin(struct exports *exports, struct error *error)
{
    enum status status = STATUS_OK;
    for (int i = 0; i < EXPORT_COUNT && status == STATUS_OK; i++) {
        if (i == EXPORT_SUMMARY && !run_data_is_sweep(exports->data))
            continue;
        // The cases of a sweep have theirs in result.json.
        if (i == EXPORT_WORST && run_data_is_sweep(exports->data))
            continue;
        char *path = g_build_filename(exports->data->directory, export_names[i], NULL);
        status = whole_file_begin(&exports->files[i], path, error);
        g_free(path);
    }
    if (status != STATUS_OK)
        return status;
    json_begin(exports->files[EXPORT_JSON].file, exports->data);
    fputs("search,spring,direction,deformation_m,lower_N,upper_N,design_lower_N,design_upper_N,"
          "reached",
          exports->files[EXPORT_CORRIDORS].file);
    fputs(exports->seeds.spread.count > 0 ? ",lower_spread_N,upper_spread_N\n" : "\n",
          exports->files[EXPORT_CORRIDORS].file);
    fputs("search,phase,step,samples,good,growth,log_volume\n",
          exports->files[EXPORT_HISTORY].file);
    return STATUS_OK;
}

enum status report_write(const char *directory, struct error *error)
{
    struct run_data data;
    enum status status = run_data_open(&data, directory, error);
    if (status != STATUS_OK)
        return status;
    struct exports exports = {.data = &data};
    if (seeds_alone(&data))
        status = seeds_read(&data, &exports.seeds, error);
    if (status == STATUS_OK)
        status = exports_begin(&exports, error);
    for (uint32_t i = 0; i < data.run.search_count && status == STATUS_OK; i++) {
        struct run_data_search search;
        status = run_data_load(&data, i, &search, error);
        if (status == STATUS_OK) {
            run_data_find_reach(&search);
            put_search(&exports, i, &search);
        }
        run_data_release(&search);
    }
    if (status == STATUS_OK)
        json_end(exports.files[EXPORT_JSON].file, g_steal_pointer(&exports.json_seeds));
    for (int i = 0; i < EXPORT_COUNT; i++)
        status = whole_file_end(&exports.files[i], status, error);
    g_strfreev(exports.variables);
    json_decref(exports.json_seeds);
    seeds_fini(&exports.seeds);
    run_data_fini(&data);
    return status;
}
