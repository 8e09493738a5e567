// The computing threads: they take parts of the jobs that wait, first come first, and give each job
// back when its last part is done. The message thread owns an engine and calls everything here;
// only what stands between the two queues runs elsewhere.
//
//     message thread              threads of a team (niced), each:
//     engine_submit() --> jobs --> part --> batch_evaluate_part() --> last of its job?
//     engine_collect() <- results <------------ verdict_pack() <----------+
//                                       an eventfd wakes the main loop
//
// A part is some samples of a job. A batch of 400 samples would keep seven cores busy with the
// model's blocks of 64; here nobody waits for a batch to end before the next is begun, and where
// few samples wait they are cut finer, so that all cores have a part of them. How a job is cut
// changes no bit of its verdicts. A job of given designs goes the same way; its result is the
// outcomes themselves.
#ifndef SOBOX_WORKER_RUNTIME_ENGINE_H
#define SOBOX_WORKER_RUNTIME_ENGINE_H

#include "common/base/error.h"
#include "worker/batch/intake.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// One batch on its way through the engine. The caller fills in `work`.
struct engine_job {
    struct intake_work work;

    // The result.
    uint32_t non_finite; // samples with a non-finite outcome
    int64_t service_ns;  // of the engine's time: what its threads spent on it, divided by how many
                         // they are. Jobs that overlap are not counted twice
    uint8_t *packed;     // the verdicts, as verdict_pack() writes them; owned
    size_t packed_size;  // [bytes]
    // Instead of verdicts, of a batch of given designs:
    double *outcomes;     // (outcome_count) design by design; owned
    size_t outcome_count; // designs x outcomes of the model

    // Until then the engine's.
    struct verdict *verdicts; // (samples)
    uint32_t claimed;         // samples that threads have taken
    uint32_t done;            // samples evaluated
    int64_t busy_ns;          // spent on them, all threads together
};

struct engine;

// Starts `threads` (1 ..) OpenMP threads, all at this process's priority plus `priority`.
// Errors: STATUS_FAILED (no thread, no descriptor).
enum status engine_create(struct engine **engine, int threads, int priority,
                          struct error *error) MUST_USE;

// Finishes the jobs that were begun, drops those after them, ends the threads. engine_collect() may
// still be called. Idempotent.
void engine_stop(struct engine *engine);

// Stops it if need be and releases everything. NULL is fine.
void engine_free(struct engine *engine);

// Hands a job over; never blocks. The intake bounds how many there are.
void engine_submit(struct engine *engine, struct engine_job *job);

// Whether the threads want another job: what waits for them would last them for less than the
// message thread may take to look again. What they do not want yet, others may still overtake.
bool engine_hungry(struct engine *engine);

// The next finished job, in the order in which they were finished, for the caller to release with
// engine_job_free(); NULL when there is none.
struct engine_job *engine_collect(struct engine *engine);

void engine_job_free(struct engine_job *job);

// Readable when engine_collect() may have something: for the main loop, which calls
// engine_acknowledge() before it collects.
int engine_descriptor(const struct engine *engine);
void engine_acknowledge(struct engine *engine);

#endif
