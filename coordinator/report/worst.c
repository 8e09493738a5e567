#include "coordinator/report/worst.h"

#include "coordinator/report/holding.h"
#include "worker/batch/batch.h"

#include <math.h>

void worst_find(struct worst *worst, const struct run_data_search *search)
{
    const struct scenario *scenario = &search->scenario;
    *worst = (struct worst){.margin = INFINITY};
    if (search->record.worst.count == 0)
        return;
    struct model *model = model_create(scenario);
    struct batch_scratch scratch = {0};
    g_autofree double *outcomes = g_new(double, model_outcome_count(model));
    batch_evaluate_designs(model, search->record.worst.lower, 1, &scratch, outcomes);
    for (uint32_t c = 0; c < scenario->constraint_count; c++) {
        const double margin = batch_margin(scenario, c, outcomes, 1);
        if (margin >= worst->margin)
            continue;
        *worst = (struct worst){.known = true,
                                .constraint = c,
                                .value = outcomes[scenario->constraints[c].outcome],
                                .margin = margin};
    }
    batch_scratch_fini(&scratch);
    model_free(model);
}

static const char *kept_words(const struct run_data_search *search, const struct worst *worst)
{
    if (worst->margin < 0)
        return "bad";
    return search->scenario.search.promise == PROMISE_EVERY ? "good, as all that were found"
                                                            : "good";
}

void worst_print(const struct run_data_search *search, bool normalise, FILE *out)
{
    struct worst worst;
    worst_find(&worst, search);
    if (!worst.known)
        return;
    const uint32_t outcome = search->scenario.constraints[worst.constraint].outcome;
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    char *words = holding_constraint(&search->scenario, worst.constraint, normalise);
    if (normalise)
        fprintf(out, "worst found  %s inside its limit by %.4g of it: %s\n", words, worst.margin,
                kept_words(search, &worst));
    else
        fprintf(out, "worst found  %s %.4g where %s is wanted: %s\n",
                scenario_outcome_name(&search->scenario, outcome, name), worst.value, words,
                kept_words(search, &worst));
    g_free(words);
}

json_t *worst_json(const struct run_data_search *search)
{
    struct worst worst;
    worst_find(&worst, search);
    if (!worst.known)
        return json_null();
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    const struct scenario *scenario = &search->scenario;
    json_t *design = json_object();
    for (uint32_t v = 0; v < scenario->design_space.count; v++)
        json_object_set_new(design, scenario->variables[v].name,
                            json_real(search->record.worst.lower[v]));
    return json_pack(
        "{s:s, s:o, s:o, s:o}", "constraint",
        scenario_outcome_name(scenario, scenario->constraints[worst.constraint].outcome, name),
        "value", isfinite(worst.value) ? json_real(worst.value) : json_null(), "margin",
        isfinite(worst.margin) ? json_real(worst.margin) : json_null(), "design", design);
}

static void write_springs(const struct run_data_search *search, FILE *csv)
{
    const struct scenario *scenario = &search->scenario;
    const double *values = search->record.worst.lower;
    fputs("spring,branch,deformation_m,force_x_N,force_y_N\n", csv);
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const struct scenario_spring *spring = &scenario->springs[i];
        for (uint32_t k = 0; k < spring->point_count; k++)
            fprintf(csv, "%s,load,%.17g,%.17g,%.17g\n", spring->name, spring->deformation[k],
                    values[run_data_variable(search, i, SCENARIO_DIRECTION_X, k)],
                    values[run_data_variable(search, i, SCENARIO_DIRECTION_Y, k)]);
    }
}

void worst_write(const struct run_data_search *search, FILE *csv)
{
    const struct scenario *scenario = &search->scenario;
    if (search->record.worst.count == 0)
        return;
    if (scenario->spring_count > 0) {
        write_springs(search, csv);
        return;
    }
    for (uint32_t v = 0; v < scenario->design_space.count; v++)
        fprintf(csv, "%s%s", v > 0 ? "," : "", scenario->variables[v].name);
    for (uint32_t v = 0; v < scenario->design_space.count; v++)
        fprintf(csv, "%c%.17g", v > 0 ? ',' : '\n', search->record.worst.lower[v]);
    fputc('\n', csv);
}
