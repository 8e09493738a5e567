#include "worker/batch/batch.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum { SCRATCH_ALIGNMENT = 64 }; // [bytes] a cache line, and a whole vector of AVX-512

// Makes room for a block of the model.
static void scratch_fit(struct batch_scratch *scratch, const struct model *model)
{
    const size_t values = (size_t)model_variable_count(model) * MODEL_BLOCK;
    const size_t outcomes = (size_t)model_outcome_count(model) * MODEL_BLOCK;
    if (values + outcomes > scratch->room) {
        free(scratch->values);
        scratch->room = values + outcomes;
        scratch->values = aligned_alloc(SCRATCH_ALIGNMENT, scratch->room * sizeof *scratch->values);
        if (scratch->values == NULL)
            abort();
    }
    scratch->outcomes = scratch->values + values;
}

void batch_scratch_fini(struct batch_scratch *scratch)
{
    free(scratch->values);
    *scratch = (struct batch_scratch){0};
}

// How far a value lies outside the constraint, in the constraint's own scale; not above 0 inside.
static double constraint_relative(const struct scenario_constraint *constraint, double value)
{
    if (value >= constraint->min && value <= constraint->max)
        return 0; // most values are: no division for them
    double below = (constraint->min - value) / constraint->scale;
    double above = (value - constraint->max) / constraint->scale;
    return below > above ? below : above;
}

// A design whose simulation broke down in any outcome is not to be trusted in the others.
static bool outcomes_finite(const double *outcomes, uint32_t count, size_t stride)
{
    double nothing = 0; // x - x is 0 for every finite x, else NaN
    for (uint32_t i = 0; i < count; i++)
        nothing += outcomes[i * stride] - outcomes[i * stride];
    return nothing == 0;
}

// The constraint whose own outcome is not finite, or the first one where none's is.
static uint8_t constraint_broken(const struct scenario *scenario, const double *outcomes,
                                 size_t stride)
{
    for (uint32_t i = 0; i < scenario->constraint_count; i++) {
        if (!isfinite(outcomes[scenario->constraints[i].outcome * stride]))
            return (uint8_t)i;
    }
    return 0;
}

struct verdict batch_verdict(const struct scenario *scenario, const double *outcomes, size_t stride)
{
    if (!outcomes_finite(outcomes, scenario_outcome_count(scenario), stride))
        return (struct verdict){
            .violation = VERDICT_NON_FINITE,
            .constraint = constraint_broken(scenario, outcomes, stride),
        };
    struct verdict worst = {.violation = VERDICT_GOOD};
    for (uint32_t i = 0; i < scenario->constraint_count; i++) {
        const struct scenario_constraint *constraint = &scenario->constraints[i];
        double relative = constraint_relative(constraint, outcomes[constraint->outcome * stride]);
        uint16_t violation = verdict_violation(relative);
        if (violation > worst.violation)
            worst = (struct verdict){.violation = violation, .constraint = (uint8_t)i};
    }
    return worst;
}

double batch_margin(const struct scenario *scenario, uint32_t constraint, const double *outcomes,
                    size_t stride)
{
    if (!outcomes_finite(outcomes, scenario_outcome_count(scenario), stride))
        return -INFINITY;
    const struct scenario_constraint *bound = &scenario->constraints[constraint];
    const double value = outcomes[bound->outcome * stride];
    const double above_min = (value - bound->min) / bound->scale;
    const double below_max = (bound->max - value) / bound->scale;
    return above_min < below_max ? above_min : below_max;
}

uint32_t batch_violated(const struct scenario *scenario, const double *outcomes, uint32_t *violated)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < scenario->constraint_count; i++) {
        const struct scenario_constraint *constraint = &scenario->constraints[i];
        const double value = outcomes[constraint->outcome];
        bool named = value >= constraint->min && value <= constraint->max; // then there is no need
        for (uint32_t known = 0; known < count && !named; known++)
            named = violated[known] == constraint->outcome;
        if (!named)
            violated[count++] = constraint->outcome;
    }
    return count;
}

// NaN where a sample has an outcome that is not finite, else 0.
static void sum_nothing(const double *outcomes, uint32_t outcome_count, uint32_t count,
                        double *nothing)
{
    for (uint32_t i = 0; i < count; i++)
        nothing[i] = 0;
    for (uint32_t outcome = 0; outcome < outcome_count; outcome++) {
        const double *row = outcomes + (size_t)outcome * MODEL_BLOCK;
        for (uint32_t i = 0; i < count; i++)
            nothing[i] += row[i] - row[i];
    }
}

// batch_verdict() of a whole block, outcome by outcome as they stand in memory. Returns how many
// samples had a non-finite outcome.
static uint32_t judge_block(const struct scenario *scenario, uint32_t outcome_count,
                            const double *outcomes, uint32_t count, struct verdict *verdicts)
{
    for (uint32_t i = 0; i < count; i++)
        verdicts[i] = (struct verdict){.violation = VERDICT_GOOD};
    for (uint32_t c = 0; c < scenario->constraint_count; c++) {
        const struct scenario_constraint *constraint = &scenario->constraints[c];
        const double *row = outcomes + (size_t)constraint->outcome * MODEL_BLOCK;
        for (uint32_t i = 0; i < count; i++) {
            double relative = constraint_relative(constraint, row[i]);
            if (relative <= 0)
                continue;
            uint16_t violation = verdict_violation(relative);
            if (violation > verdicts[i].violation)
                verdicts[i] = (struct verdict){.violation = violation, .constraint = (uint8_t)c};
        }
    }
    double nothing[MODEL_BLOCK];
    sum_nothing(outcomes, outcome_count, count, nothing);
    uint32_t non_finite = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (nothing[i] == 0)
            continue;
        verdicts[i] = batch_verdict(scenario, outcomes + i, MODEL_BLOCK);
        non_finite++;
    }
    return non_finite;
}

// The margins of a block: of the constraint that each sample of an adversarial step is asked for,
// else the least of all constraints.
static void measure_block(const struct scenario *scenario, const struct sampling *sampling,
                          uint32_t per_attack, uint32_t first, uint32_t count,
                          const double *outcomes, struct verdict *verdicts)
{
    for (uint32_t i = 0; i < count; i++) {
        if (sampling->method == SAMPLING_METHOD_MOVES) {
            const uint8_t target = moves_target(sampling, per_attack, first + i);
            verdicts[i].margin = (float)batch_margin(scenario, target, outcomes + i, MODEL_BLOCK);
            continue;
        }
        verdicts[i].margin = INFINITY;
        for (uint32_t c = 0; c < scenario->constraint_count; c++) {
            const float margin = (float)batch_margin(scenario, c, outcomes + i, MODEL_BLOCK);
            verdicts[i].margin = margin < verdicts[i].margin ? margin : verdicts[i].margin;
        }
    }
}

// Samples first .. first + count - 1 of the step; returns how many had a non-finite outcome.
static uint32_t evaluate_block(const struct scenario *scenario, const struct model *model,
                               const struct box *box, const struct batch *batch, uint32_t first,
                               uint32_t count, const struct batch_scratch *scratch,
                               struct verdict *verdicts)
{
    struct sampling of_scenario = batch->sampling;
    of_scenario.curves = &scenario->curves;
    sampling_fill(&of_scenario, box, first, count, scratch->values, MODEL_BLOCK);
    model_evaluate_judged(model, count, scratch->values, scratch->outcomes);
    const uint32_t non_finite =
        judge_block(scenario, model_outcome_count(model), scratch->outcomes, count, verdicts);
    if (batch->detail == VERDICT_DETAIL_MARGIN)
        measure_block(scenario, &of_scenario, moves_count(&scenario->curves, box), first, count,
                      scratch->outcomes, verdicts);
    return non_finite;
}

uint32_t batch_evaluate_part(const struct scenario *scenario, const struct model *model,
                             const struct box *box, const struct batch *batch, uint32_t begin,
                             uint32_t count, struct batch_scratch *scratch,
                             struct verdict *verdicts)
{
    assert(count > 0);
    assert(begin <= batch->count && count <= batch->count - begin);
    scratch_fit(scratch, model);
    uint32_t non_finite = 0;
    for (uint32_t done = 0; done < count; done += MODEL_BLOCK) {
        const uint32_t left = count - done;
        non_finite += evaluate_block(scenario, model, box, batch, batch->first + begin + done,
                                     left < MODEL_BLOCK ? left : MODEL_BLOCK, scratch,
                                     verdicts + begin + done);
    }
    return non_finite;
}

uint32_t batch_evaluate(const struct scenario *scenario, const struct model *model,
                        const struct box *box, const struct batch *batch, int threads,
                        struct verdict *verdicts)
{
    assert(batch->count > 0);
    assert(threads > 0);
    assert(box->count == model_variable_count(model));
    const uint32_t blocks = (batch->count - 1) / MODEL_BLOCK + 1;
    uint32_t non_finite = 0;

    // The team always has `threads` threads or is not called at all: libgomp ends threads that a
    // smaller team leaves over and starts them again for the next, which costs more than a block.
#pragma omp parallel num_threads(threads) if (threads > 1 && blocks > 1)
    {
        struct batch_scratch scratch = {0};
#pragma omp for schedule(dynamic, 1) reduction(+ : non_finite)
        for (uint32_t block = 0; block < blocks; block++) {
            uint32_t begin = block * MODEL_BLOCK;
            uint32_t left = batch->count - begin;
            non_finite +=
                batch_evaluate_part(scenario, model, box, batch, begin,
                                    left < MODEL_BLOCK ? left : MODEL_BLOCK, &scratch, verdicts);
        }
        batch_scratch_fini(&scratch);
    }
    return non_finite;
}

// A design stands in a row of its own, a lane of a block in a column.
static void designs_block(const struct model *model, const double *values, uint32_t count,
                          const struct batch_scratch *scratch, double *outcomes)
{
    const uint32_t variable_count = model_variable_count(model);
    const uint32_t outcome_count = model_outcome_count(model);
    for (uint32_t variable = 0; variable < variable_count; variable++)
        for (uint32_t i = 0; i < count; i++)
            scratch->values[variable * (size_t)MODEL_BLOCK + i] =
                values[i * (size_t)variable_count + variable];
    model_evaluate(model, count, scratch->values, scratch->outcomes);
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t outcome = 0; outcome < outcome_count; outcome++)
            outcomes[i * (size_t)outcome_count + outcome] =
                scratch->outcomes[outcome * (size_t)MODEL_BLOCK + i];
}

void batch_evaluate_designs(const struct model *model, const double *values, uint32_t count,
                            struct batch_scratch *scratch, double *outcomes)
{
    assert(count > 0);
    const size_t variable_count = model_variable_count(model);
    const size_t outcome_count = model_outcome_count(model);
    scratch_fit(scratch, model);
    for (size_t done = 0; done < count; done += MODEL_BLOCK) {
        const uint32_t left = count - (uint32_t)done;
        designs_block(model, values + done * variable_count,
                      left < MODEL_BLOCK ? left : MODEL_BLOCK, scratch,
                      outcomes + done * outcome_count);
    }
}
