#include "coordinator/evaluation/outcomes.h"

#include "common/table/decimal.h"
#include "worker/batch/batch.h"

#include <inttypes.h>
#include <string.h>

static enum status take_name(struct outcomes_layout *layout, const char *name, struct error *error)
{
    const struct scenario *scenario = layout->scenario;
    const uint32_t outcome = scenario_outcome_find(scenario, name);
    char first[SCENARIO_OUTCOME_NAME_SIZE];
    if (outcome == scenario_outcome_count(scenario))
        return error_set(
            error, STATUS_INVALID,
            "--outcomes %.100s: expected names of outcomes, as %s, separated by commas", name,
            scenario_outcome_name(scenario, 0, first));
    for (uint32_t i = 0; i < layout->count; i++)
        if (layout->outcomes[i] == outcome)
            return error_set(error, STATUS_INVALID, "--outcomes %.100s: expected it once", name);
    layout->outcomes[layout->count++] = outcome;
    return STATUS_OK;
}

enum status outcomes_layout_read(struct outcomes_layout *layout, const struct scenario *scenario,
                                 const char *names, struct error *error)
{
    const uint32_t all = scenario_outcome_count(scenario);
    *layout = (struct outcomes_layout){.scenario = scenario, .outcomes = g_new(uint32_t, all)};
    if (names == NULL) {
        while (layout->count < all) {
            layout->outcomes[layout->count] = layout->count;
            layout->count++;
        }
        return STATUS_OK;
    }
    g_auto(GStrv) list = g_strsplit(names, ",", -1);
    enum status status = STATUS_OK;
    for (char **name = list; *name != NULL && status == STATUS_OK; name++)
        status = take_name(layout, g_strstrip(*name), error);
    if (status == STATUS_OK && layout->count == 0)
        status = take_name(layout, "", error);
    if (status != STATUS_OK)
        outcomes_layout_fini(layout);
    return status;
}

void outcomes_layout_fini(struct outcomes_layout *layout)
{
    g_free(layout->outcomes);
    *layout = (struct outcomes_layout){0};
}

void outcomes_header(const struct outcomes_layout *layout, GString *text)
{
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    g_string_append(text, "id");
    for (uint32_t i = 0; i < layout->count; i++) {
        g_string_append_c(text, ',');
        g_string_append(text, scenario_outcome_name(layout->scenario, layout->outcomes[i], name));
    }
    g_string_append(text, ",good,violated\n");
}

static void append_id(const struct designs *designs, uint32_t design, uint64_t number,
                      GString *text)
{
    if (designs->ids != NULL)
        g_string_append_len(text, designs->ids[design], designs->id_sizes[design]);
    else
        g_string_append_printf(text, "%" PRIu64, number);
}

static void append_violated(const struct scenario *scenario, const double *values, GString *text)
{
    uint32_t violated[SCENARIO_CONSTRAINT_MAX];
    const uint32_t count = batch_violated(scenario, values, violated);
    for (uint32_t i = 0; i < count; i++) {
        char name[SCENARIO_OUTCOME_NAME_SIZE];
        if (i > 0)
            g_string_append_c(text, ';');
        g_string_append(text, scenario_outcome_name(scenario, violated[i], name));
    }
}

void outcomes_rows(const struct outcomes_layout *layout, const struct designs *designs,
                   uint64_t first, const double *values, GString *text, struct outcomes_sums *sums)
{
    const struct scenario *scenario = layout->scenario;
    const uint32_t outcome_count = scenario_outcome_count(scenario);
    for (uint32_t design = 0; design < designs->count; design++, values += outcome_count) {
        char number[DECIMAL_SIZE];
        append_id(designs, design, first + design, text);
        for (uint32_t i = 0; i < layout->count; i++) {
            g_string_append_c(text, ',');
            const size_t size = decimal_write(values[layout->outcomes[i]], number);
            g_string_append_len(text, number, (gssize)size);
        }
        const struct verdict verdict = batch_verdict(scenario, values, 1);
        const bool good = verdict.violation == VERDICT_GOOD;
        sums->good += good;
        sums->non_finite += verdict.violation == VERDICT_NON_FINITE;
        g_string_append(text, good ? ",1," : ",0,");
        if (!good)
            append_violated(scenario, values, text);
        g_string_append_c(text, '\n');
    }
}
