// The unit of work: samples first .. first + count - 1 of one step of one search. Evaluating a
// batch is a pure function of scenario, box and these numbers: any worker, any thread count, the
// same bits. So is evaluating designs that somebody made elsewhere.
#ifndef SOBOX_WORKER_BATCH_BATCH_H
#define SOBOX_WORKER_BATCH_BATCH_H

#include "common/numeric/verdict.h"
#include "common/sampling/sampling.h"
#include "worker/models/model.h"

struct batch {
    struct sampling sampling;
    uint32_t first;
    uint32_t count;
    enum verdict_detail detail; // margins are worked out where they are asked for
};

// Room in which one thread computes, for models of any size one after the other. A zeroed struct is
// one that has none yet.
struct batch_scratch {
    double *values;   // (variables x MODEL_BLOCK) rows of lanes, then
    double *outcomes; // (outcomes x MODEL_BLOCK)
    size_t room;      // of both [doubles]
};

void batch_scratch_fini(struct batch_scratch *scratch);

// Evaluates samples begin .. begin + count - 1 of the batch (counted from its own first one), count
// above 0, in the thread that owns `scratch`: the parts of a batch may be evaluated in any order,
// by any threads, in parts of any size, and give the same bits. `verdicts` is that of the whole
// batch. Returns how many of the part had a non-finite outcome.
uint32_t batch_evaluate_part(const struct scenario *scenario, const struct model *model,
                             const struct box *box, const struct batch *batch, uint32_t begin,
                             uint32_t count, struct batch_scratch *scratch,
                             struct verdict *verdicts);

// How far inside a constraint the outcomes of a design lie (outcomes[outcome * stride], all that
// the model has), in the constraint's own scale: below 0 outside, -infinity where any outcome is
// not finite.
double batch_margin(const struct scenario *scenario, uint32_t constraint, const double *outcomes,
                    size_t stride);

// Samples the box, runs the model and holds the outcomes against the scenario's constraints, on
// `threads` (1 ..) OpenMP threads. `model` was made from `scenario`, `box` has its variables,
// batch->count > 0. Fills `verdicts` (batch->count).
// Returns how many samples had a non-finite outcome.
uint32_t batch_evaluate(const struct scenario *scenario, const struct model *model,
                        const struct box *box, const struct batch *batch, int threads,
                        struct verdict *verdicts);

// The outcomes of given designs, in the thread that owns `scratch`: values[design * variables +
// variable] are those of `count` (1 ..) designs, outcomes[design * outcomes + outcome] receives all
// that the model has. A design gives the same bits wherever it stands, among whatever others, and
// the same as by sampling.
void batch_evaluate_designs(const struct model *model, const double *values, uint32_t count,
                            struct batch_scratch *scratch, double *outcomes);

// The verdict on one design from its outcomes (outcomes[outcome * stride], all that the scenario's
// model has): good, or the constraint it violates most, the first of equals. A design with any
// non-finite outcome is VERDICT_NON_FINITE, held against the first constraint that such an outcome
// concerns, else against constraint 0.
struct verdict batch_verdict(const struct scenario *scenario, const double *outcomes,
                             size_t stride);

// The outcomes of one design (outcomes[outcome], all that the model has) whose constraints are not
// met, each once, in the order of the constraints. Fills `violated`, which has room for one a
// constraint, and returns how many there are.
uint32_t batch_violated(const struct scenario *scenario, const double *outcomes,
                        uint32_t *violated);

#endif
