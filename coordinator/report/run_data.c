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
    if (search->last_box.count > 0) {
        search->box = &search->last_box;
        search->log_volume = box_log_volume(search->box, &search->scenario.design_space);
    }
    return STATUS_OK;
}

static enum status read_search(struct run_data_search *search, struct journal *journal,
                               uint32_t index, const struct journal_run *run, struct error *error)
{
    search->steps = g_array_new(FALSE, TRUE, sizeof(struct run_step));
    enum status status = journal_read_search(journal, index, &search->record, error);
    if (status != STATUS_OK)
        return status;
    status = scenario_read_text(&search->scenario, "scenario", search->record.text,
                                search->record.text_size, NULL, 0, error);
    if (status == STATUS_OK)
        status = journal_read_steps(journal, index, take_step, search, error);
    if (status == STATUS_OK)
        status = conclude(search, run, error);
    if (status != STATUS_OK)
        error_wrap(error, "search %" PRIu32, index);
    return status != STATUS_OK ? STATUS_IO : STATUS_OK;
}

enum status run_data_read(struct run_data *data, const char *directory, struct error *error)
{
    *data = (struct run_data){0};
    struct error reason = {0}; // the caller may not want to know, but contexts are added to it
    struct journal *journal;
    enum status status = journal_open(&journal, directory, JOURNAL_READ, &reason);
    if (status == STATUS_OK)
        status = journal_read_run(journal, &data->run, &reason);
    if (status == STATUS_OK) {
        data->searches = g_new0(struct run_data_search, data->run.search_count);
        for (uint32_t i = 0; i < data->run.search_count && status == STATUS_OK; i++)
            status = read_search(&data->searches[i], journal, i, &data->run, &reason);
        if (status != STATUS_OK && strstr(reason.text, "run.db") == NULL)
            error_wrap(&reason, "%s/run.db", directory);
    }
    journal_close(journal);
    if (status != STATUS_OK) {
        error_set(error, status, "%s", reason.text);
        run_data_fini(data);
    }
    return status;
}

void run_data_fini(struct run_data *data)
{
    for (uint32_t i = 0; data->searches != NULL && i < data->run.search_count; i++) {
        struct run_data_search *search = &data->searches[i];
        journal_search_fini(&search->record);
        scenario_fini(&search->scenario);
        box_fini(&search->last_box);
        if (search->steps != NULL)
            g_array_unref(search->steps);
    }
    g_free(data->searches);
    *data = (struct run_data){0};
}
