#include "coordinator/report/run_data.h"

#include "common/scenario/scenario_read.h"

#include <assert.h>
#include <inttypes.h>
#include <string.h>

bool run_data_found_nothing(const struct run_data_search *search)
{
    return strcmp(search->record.status, "no_good_design") == 0; // as search_status_name() has it
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
    if (step->detail != VERDICT_DETAIL_FULL)
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
    }
    return STATUS_OK;
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
    if (search->last_box.count == 0)
        box_init(&search->last_box, step->box->count);
    box_assign(&search->last_box, step->box);
    return take_verdicts(search, step, error);
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
        return STATUS_OK;
    }
    search->status = journal_state_name(run->state);
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
        search->log_volume = box_log_volume(search->box, &search->scenario.design_space);
    }
    return STATUS_OK;
}

static enum status load(const struct run_data *data, uint32_t index, struct run_data_search *search,
                        struct error *error)
{
    struct journal *journal = data->journal;
    search->steps = g_array_new(FALSE, TRUE, sizeof(struct run_step));
    enum status status = journal_read_search(journal, index, &search->record, error);
    if (status == STATUS_OK)
        status = journal_read_values(journal, index, &search->values, error);
    if (status != STATUS_OK)
        return status;
    if (g_strv_length(search->values) != g_strv_length(data->axes))
        return error_set(error, STATUS_IO, "it has not a value for each axis");
    status = scenario_read_text(&search->scenario, "scenario", search->record.text,
                                search->record.text_size, NULL, 0, error);
    if (status == STATUS_OK)
        status = journal_read_steps(journal, index, take_step, search, error);
    if (status == STATUS_OK)
        status = conclude(search, &data->run, error);
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

void run_data_release(struct run_data_search *search)
{
    journal_search_fini(&search->record);
    scenario_fini(&search->scenario);
    box_fini(&search->last_box);
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
