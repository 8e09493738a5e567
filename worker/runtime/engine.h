// The computing thread: takes jobs in order, evaluates them with its team of OpenMP threads, gives
// them back in order. The message thread owns an engine and calls everything here; only what stands
// between the two queues runs elsewhere.
//
//     message thread                  computing thread (niced)
//     engine_submit() --> jobs ----> batch_evaluate() + verdict_pack()
//     engine_collect() <- results <------+      an eventfd wakes the main loop
//
// A job of given designs goes the same way; its result is the outcomes themselves.
#ifndef SOBOX_WORKER_RUNTIME_ENGINE_H
#define SOBOX_WORKER_RUNTIME_ENGINE_H

#include "common/base/error.h"
#include "worker/batch/intake.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// One batch on its way through the engine. The caller fills in `work`; the rest is the result.
struct engine_job {
    struct intake_work work;
    uint32_t non_finite; // samples with a non-finite outcome
    int64_t service_ns;  // the evaluation took
    uint8_t *packed;     // the verdicts, as verdict_pack() writes them; owned
    size_t packed_size;  // [bytes]
    // Instead of verdicts, of a batch of given designs:
    double *outcomes;     // (outcome_count) design by design; owned
    size_t outcome_count; // designs x outcomes of the model
};

struct engine;

// Starts the computing thread with `threads` (1 ..) OpenMP threads, all at this process's priority
// plus `priority`.
// Errors: STATUS_FAILED (no thread, no descriptor).
enum status engine_create(struct engine **engine, int threads, int priority,
                          struct error *error) MUST_USE;

// Finishes the job in work, drops those after it, ends the thread. engine_collect() may still be
// called. Idempotent.
void engine_stop(struct engine *engine);

// Stops it if need be and releases everything. NULL is fine.
void engine_free(struct engine *engine);

// Hands a job over; never blocks. The intake bounds how many there are.
void engine_submit(struct engine *engine, struct engine_job *job);

// The next finished job, for the caller to release with engine_job_free(); NULL when there is none.
struct engine_job *engine_collect(struct engine *engine);

void engine_job_free(struct engine_job *job);

// Readable when engine_collect() may have something: for the main loop, which calls
// engine_acknowledge() before it collects.
int engine_descriptor(const struct engine *engine);
void engine_acknowledge(struct engine *engine);

#endif
