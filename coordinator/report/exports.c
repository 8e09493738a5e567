// result.json, corridors.csv and history.csv.
#include "coordinator/report/number.h"
#include "coordinator/report/report.h"
#include "coordinator/report/run_data.h"
#include "coordinator/report/whole_file.h"

#include <assert.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <string.h>

static enum status write_file(const char *directory, const char *name, const char *text,
                              size_t size, struct error *error)
{
    char *path = g_build_filename(directory, name, NULL);
    enum status status = whole_file_write(path, text, size, error);
    g_free(path);
    return status;
}

// ---- CSV ----

static void csv_number(GString *csv, double value)
{
    char text[NUMBER_SIZE];
    g_string_append_printf(csv, ",%s", number_exact(value, text));
}

// Where a corridor's interval belongs: a point of a spring, or the variable that it is alone.
static void corridor_place(GString *csv, uint32_t index, const struct scenario *scenario,
                           const struct scenario_variable *variable)
{
    if (variable->spring == SCENARIO_NO_SPRING) {
        g_string_append_printf(csv, "%" PRIu32 ",%s,,", index, variable->name);
        return;
    }
    const struct scenario_spring *spring = &scenario->springs[variable->spring];
    g_string_append_printf(csv, "%" PRIu32 ",%s,%s", index, spring->name,
                           scenario_direction_name(variable->direction));
    csv_number(csv, spring->deformation[variable->point]);
}

static void corridor_rows(GString *csv, uint32_t index, const struct run_data_search *search)
{
    const struct scenario *scenario = &search->scenario;
    for (uint32_t i = 0; search->box != NULL && i < search->box->count; i++) {
        corridor_place(csv, index, scenario, &scenario->variables[i]);
        csv_number(csv, search->box->lower[i]);
        csv_number(csv, search->box->upper[i]);
        csv_number(csv, scenario->design_space.lower[i]);
        csv_number(csv, scenario->design_space.upper[i]);
        g_string_append_c(csv, '\n');
    }
}

static void history_rows(GString *csv, uint32_t index, const struct run_data_search *search)
{
    for (guint i = 0; i < search->steps->len; i++) {
        const struct run_step *step = &g_array_index(search->steps, struct run_step, i);
        g_string_append_printf(csv, "%" PRIu32 ",%s,%" PRIu32 ",%" PRIu32 ",%" PRIu32, index,
                               step->phase, step->step, step->samples, step->good);
        csv_number(csv, step->growth);
        csv_number(csv, step->log_volume);
        g_string_append_c(csv, '\n');
    }
}

static enum status write_csv(const struct run_data *data, const char *directory, const char *name,
                             const char *header,
                             void (*rows)(GString *, uint32_t, const struct run_data_search *),
                             struct error *error)
{
    GString *csv = g_string_new(header);
    for (uint32_t i = 0; i < data->run.search_count; i++)
        rows(csv, i, &data->searches[i]);
    enum status status = write_file(directory, name, csv->str, csv->len, error);
    g_string_free(csv, TRUE);
    return status;
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
        json_array_append_new(variables, object);
    }
    return variables;
}

static json_t *json_purity(const struct journal_search *record)
{
    if (!record->finished || record->purity_samples == 0)
        return json_null();
    return json_pack("{s:o, s:o, s:o, s:o}", "samples", json_unsigned(record->purity_samples),
                     "bad", json_unsigned(record->purity_bad), "estimate",
                     json_number(record->purity_estimate), "lower95",
                     json_number(record->purity_lower95));
}

static json_t *json_search(const struct run_data_search *search)
{
    const struct journal_search *record = &search->record;
    char hex[DIGEST_HEX_SIZE];
    json_t *object = json_pack(
        "{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:I, s:f}", "name", search->name, "status",
        search->status, "seed", json_unsigned(record->seed), "variables", json_variables(search),
        "log_volume", search->box != NULL ? json_number(search->log_volume) : json_null(), "purity",
        json_purity(record), "evaluations", json_unsigned(search->evaluations), "steps",
        (json_int_t)search->steps->len, "wall_s", (double)search->wall_ns * 1e-9);
    if (record->finished)
        json_object_set_new(object, "non_finite", json_unsigned(record->non_finite));
    if (record->blocking_constraint[0] != '\0')
        json_object_set_new(object, "blocking_constraint",
                            json_string(record->blocking_constraint));
    json_object_set_new(object, "digest",
                        record->finished ? json_string(digest_hex(&record->digest, hex))
                                         : json_null());
    return object;
}

static enum status write_json(const struct run_data *data, const char *directory,
                              struct error *error)
{
    json_t *searches = json_array();
    for (uint32_t i = 0; i < data->run.search_count; i++)
        json_array_append_new(searches, json_search(&data->searches[i]));
    json_t *root = json_pack("{s:s, s:s, s:o}", "name", data->run.name, "version",
                             data->run.version, "searches", searches);
    assert(root != NULL); // all text is UTF-8 and all numbers are finite: run_data_read() saw to it
    char *text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    char *line = g_strconcat(text, "\n", NULL);
    enum status status = write_file(directory, "result.json", line, strlen(line), error);
    g_free(line);
    free(text);
    json_decref(root);
    return status;
}

enum status report_write(const char *directory, struct error *error)
{
    struct run_data data;
    enum status status = run_data_read(&data, directory, error);
    if (status == STATUS_OK)
        status = write_csv(&data, directory, "corridors.csv",
                           "search,spring,direction,deformation_m,lower_N,upper_N,design_lower_N,"
                           "design_upper_N\n",
                           corridor_rows, error);
    if (status == STATUS_OK)
        status =
            write_csv(&data, directory, "history.csv",
                      "search,phase,step,samples,good,growth,log_volume\n", history_rows, error);
    if (status == STATUS_OK)
        status = write_json(&data, directory, error);
    run_data_fini(&data);
    return status;
}
