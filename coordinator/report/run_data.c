#include "coordinator/report/run_data.h"

#include "common/sampling/sampling.h"
#include "common/scenario/scenario_read.h"
#include "coordinator/search/search.h"

#include <assert.h>
#include <inttypes.h>
#include <string.h>

bool run_data_found_nothing(const struct run_data_search *search)
{
    return strcmp(search->record.status, "no_good_design") == 0; // as protocol_status_name() has it
}

// Variables stand spring by spring, the x points before the y points (scenario.h).
uint32_t run_data_variable(const struct run_data_search *search, uint32_t spring,
                           enum scenario_direction direction, uint32_t point)
{
    const struct scenario *scenario = &search->scenario;
    assert(spring < scenario->spring_count);
    assert(point < scenario->springs[spring].point_count);
    uint32_t index = 0;
    for (uint32_t i = 0; i < spring; i++)
        index += SCENARIO_DIRECTION_COUNT * scenario->springs[i].point_count;
    index += direction * scenario->springs[spring].point_count + point;
    assert(scenario->variables[index].spring == spring);
    assert(scenario->variables[index].direction == direction);
    assert(scenario->variables[index].point == point);
    return index;
}

static enum status take_verdicts(struct run_data_search *search, const struct journal_step *step,
                                 struct error *error)
{
    if (step->detail == VERDICT_DETAIL_SHARE)
        return STATUS_OK;
    search->judged += step->samples;
    for (uint32_t i = 0; i < step->samples; i++) {
        const struct verdict *verdict = &step->verdicts[i];
        if (verdict->violation == VERDICT_GOOD)
            continue;
        if (verdict->constraint >= search->scenario.constraint_count)
            return error_set(error, STATUS_IO,
                             "step %" PRIu32 " violates a constraint that the "
                             "scenario does not have",
                             step->step);
        search->bad++;
        search->worst[verdict->constraint]++;
        if (search->least_constraint == UINT32_MAX ||
            verdict->violation < search->least_violation) {
            search->least_constraint = verdict->constraint;
            search->least_violation = verdict->violation;
        }
    }
    return STATUS_OK;
}

// A certificate says how pure the box is of which the bounds are explained.
static void take_certificate(struct run_data_search *search, const struct journal_step *step)
{
    g_clear_pointer(&search->certificate, g_free);
    search->certificate_samples = 0;
    if (step->detail != VERDICT_DETAIL_FULL)
        return;
    search->certificate = g_memdup2(step->verdicts, step->samples * sizeof *step->verdicts);
    search->certificate_samples = step->samples;
}

// The corridors are what was certified last.
static void begin_explanation(struct run_data_search *search, const struct box *corridors)
{
    explain_init(&search->explain, &search->scenario, corridors);
    const struct journal_search *record = &search->record;
    if (record->holders != NULL && record->gain_count == search->scenario.constraint_count)
        explain_take_known(&search->explain, record->holders, record->gains);
    else if (search->certificate != NULL)
        explain_take_inside(&search->explain, search->certificate, search->certificate_samples);
}

static enum status take_outside(struct run_data_search *search, const struct journal_step *step,
                                struct error *error)
{
    const struct sampling sampling = {.seed = search->record.seed,
                                      .step = step->step,
                                      .samples = step->samples,
                                      .method = SAMPLING_METHOD_UNIFORM};
    if (search->explain.scenario == NULL && search->last_box.count > 0)
        begin_explanation(search, &search->last_box);
    if (search->explain.scenario == NULL || step->detail != VERDICT_DETAIL_FULL ||
        !explain_take(&search->explain, &sampling, step->box, step->verdicts))
        return error_set(error, STATUS_IO,
                         "step %" PRIu32 " was not sampled just outside a bound of its box",
                         step->step);
    return STATUS_OK;
}

// Whether the step looked at designs of another kind than points, at the box that was certified.
static bool take_kind(struct run_data_search *search, const struct journal_step *step)
{
    if (!step->sampling_known || !sampling_of_curves(step->sampling))
        return false;
    for (int kind = 0; kind < DESIGN_KIND_COUNT; kind++) {
        if (protocol_kind_method((enum design_kind)kind) != step->sampling)
            continue;
        // A kind that decides may have been looked at before, at a box that did not pass.
        struct certificate *certificate = &search->kinds[kind];
        if (search->scenario.search.promise == PROMISE_POINTS)
            certificate_look_once(certificate, step->samples, step->samples - step->good);
        else if (certificate->looks < CERTIFICATE_LOOKS)
            certificate_look(certificate, step->samples, step->samples - step->good);
    }
    return true;
}

enum { SPACE_SAMPLES_MIN = 20 }; // fewer, as a reference looked at alone, say nothing of the whole

static void take_space(struct run_data_search *search, const struct journal_step *step)
{
    if (search->space_samples > 0 || step->samples < SPACE_SAMPLES_MIN ||
        !box_equal(step->box, &search->scenario.design_space))
        return;
    search->space_samples = step->samples;
    search->space_good = step->good;
}

static enum status take_step(void *user, const struct journal_step *step, struct error *error)
{
    struct run_data_search *search = user;
    if (step->box->count != search->scenario.design_space.count)
        return error_set(error, STATUS_IO,
                         "step %" PRIu32 " has %" PRIu32 " variables, its scenario %" PRIu32,
                         step->step, step->box->count, search->scenario.design_space.count);
    struct run_step row = {.step = step->step,
                           .samples = step->samples,
                           .good = step->good,
                           .growth = step->growth,
                           .log_volume = step->log_volume};
    g_strlcpy(row.phase, step->phase, sizeof row.phase);
    g_array_append_val(search->steps, row);
    search->evaluations += step->samples;
    if (strcmp(step->phase, protocol_phase_name(SEARCH_PHASE_EXPLAIN)) == 0)
        return take_outside(search, step, error);
    if (take_kind(search, step))
        return STATUS_OK;
    const bool attack = step->sampling_known && step->sampling == SAMPLING_METHOD_MOVES;
    if (!attack)
        take_space(search, step);
    if (strcmp(step->phase, protocol_phase_name(SEARCH_PHASE_CERTIFY)) == 0 && !attack)
        take_certificate(search, step);
    if (search->last_box.count == 0)
        box_init(&search->last_box, step->box->count);
    box_assign(&search->last_box, step->box);
    return take_verdicts(search, step, error);
}

// What log-volumes are measured in: the design space, without the width of variables that are held
// to one value.
static double free_log_volume(const struct run_data_search *search)
{
    const struct scenario_hold *hold = &search->scenario.search.hold;
    struct box space;
    box_init(&space, search->scenario.design_space.count);
    box_assign(&space, &search->scenario.design_space);
    for (uint32_t v = 0; v < space.count; v++) {
        if (hold->lower != NULL && hold->upper != NULL && hold->lower[v] == hold->upper[v])
            space.lower[v] = space.upper[v] = hold->lower[v];
    }
    const double log_volume = box_log_volume(search->box, &space);
    box_fini(&space);
    return log_volume;
}

// What is shown of a search that has its result, and of one that has not.
static enum status conclude(struct run_data_search *search, const struct journal_run *run,
                            struct error *error)
{
    const struct journal_search *record = &search->record;
    search->name = record->name[0] != '\0' ? record->name : search->scenario.name;
    if (record->finished) {
        search->status = record->status;
        search->wall_ns = record->wall_ns;
        search->log_volume = record->log_volume;
        search->evaluations = record->evaluations;
        if (run_data_found_nothing(search))
            return STATUS_OK;
        if (record->box.count != search->scenario.design_space.count)
            return error_set(error, STATUS_IO,
                             "its result has %" PRIu32 " variables, its scenario %" PRIu32,
                             record->box.count, search->scenario.design_space.count);
        search->box = &record->box;
        if (search->explain.scenario == NULL)
            begin_explanation(search, search->box);
        return STATUS_OK;
    }
    search->status = protocol_run_state_name(run->state);
    search->wall_ns = run->elapsed_ns;
    if (run->search_count > 1) {
        search->wall_ns = 0;                       // what the other cases took is not this one's
        if (strcmp(record->status, "failed") == 0) // as journal_fail_search() has it
            search->status = record->status;
        else if (search->steps->len == 0)
            search->status = "waiting";
    }
    if (search->last_box.count > 0) {
        search->box = &search->last_box;
        search->log_volume = free_log_volume(search);
    }
    return STATUS_OK;
}

static enum status load(const struct run_data *data, uint32_t index, struct run_data_search *search,
                        struct error *error)
{
    struct journal *journal = data->journal;
    search->steps = g_array_new(FALSE, TRUE, sizeof(struct run_step));
    search->least_constraint = UINT32_MAX;
    enum status status = journal_read_search(journal, index, &search->record, error);
    if (status == STATUS_OK)
        status = journal_read_values(journal, index, &search->values, error);
    if (status != STATUS_OK)
        return status;
    if (g_strv_length(search->values) != g_strv_length(data->axes))
        return error_set(error, STATUS_IO, "it has not a value for each axis");
    status = scenario_read_text(&search->scenario, "scenario", search->record.text,
                                search->record.text_size, NULL, 0, error);
    // Its text says no promise, and the default was another one then.
    if (status == STATUS_OK && journal_is_of_points(journal))
        search->scenario.search.promise = PROMISE_POINTS;
    if (status == STATUS_OK)
        status = journal_read_steps(journal, index, take_step, search, error);
    if (status == STATUS_OK)
        status = conclude(search, &data->run, error);
    g_clear_pointer(&search->certificate, g_free);
    if (status == STATUS_OK && search->explain.scenario != NULL)
        explain_conclude(&search->explain);
    return status;
}

enum status run_data_load(const struct run_data *data, uint32_t index,
                          struct run_data_search *search, struct error *error)
{
    struct error reason = {0}; // the caller may not want to know, but contexts are added to it
    *search = (struct run_data_search){0};
    if (load(data, index, search, &reason) == STATUS_OK)
        return STATUS_OK;
    run_data_release(search);
    error_wrap(&reason, "search %" PRIu32, index);
    if (strstr(reason.text, "run.db") == NULL)
        error_wrap(&reason, "%s/run.db", data->directory);
    return error_set(error, STATUS_IO, "%s", reason.text);
}

void run_data_find_reach(struct run_data_search *search)
{
    search->reach = (struct reach){0};
    if (search->box != NULL)
        reach_find(&search->reach, &search->scenario, search->box, search->record.seed);
}

void run_data_release(struct run_data_search *search)
{
    journal_search_fini(&search->record);
    scenario_fini(&search->scenario);
    box_fini(&search->last_box);
    explain_fini(&search->explain);
    g_free(search->certificate);
    g_strfreev(search->values);
    if (search->steps != NULL)
        g_array_unref(search->steps);
    *search = (struct run_data_search){0};
}

enum status run_data_open(struct run_data *data, const char *directory, struct error *error)
{
    *data = (struct run_data){.directory = g_strdup(directory)};
    enum status status = journal_open(&data->journal, directory, JOURNAL_READ, error);
    if (status == STATUS_OK)
        status = journal_read_run(data->journal, &data->run, error);
    if (status == STATUS_OK)
        status = journal_read_axes(data->journal, &data->axes, error);
    if (status != STATUS_OK)
        run_data_fini(data);
    return status;
}

enum status run_data_read(struct run_data *data, const char *directory, struct error *error)
{
    enum status status = run_data_open(data, directory, error);
    if (status != STATUS_OK)
        return status;
    data->searches = g_new0(struct run_data_search, data->run.search_count);
    for (uint32_t i = 0; i < data->run.search_count && status == STATUS_OK; i++)
        status = run_data_load(data, i, &data->searches[i], error);
    if (status != STATUS_OK)
        run_data_fini(data);
    return status;
}

bool run_data_is_sweep(const struct run_data *data)
{
    return data->axes[0] != NULL || data->run.search_count > 1;
}

void run_data_fini(struct run_data *data)
{
    for (uint32_t i = 0; data->searches != NULL && i < data->run.search_count; i++)
        run_data_release(&data->searches[i]);
    g_free(data->searches);
    g_strfreev(data->axes);
    journal_close(data->journal);
    g_free(data->directory);
    *data = (struct run_data){0};
}
