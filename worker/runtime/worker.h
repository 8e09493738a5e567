// A worker: hears batches on a wire, evaluates them on all its cores, answers with verdicts. It
// runs on the caller's GLib main context, as a program of its own (sobox-worker) or inside a
// coordinator (memq://). The message thread only moves messages; a team of OpenMP threads
// evaluates batches at a lower priority, so that a busy worker still answers at once.
#ifndef SOBOX_WORKER_RUNTIME_WORKER_H
#define SOBOX_WORKER_RUNTIME_WORKER_H

#include "common/base/error.h"
#include "common/wire/wire.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    WORKER_THREADS_MAX = 1024,
    WORKER_PRIORITY_DEFAULT = 10, // far enough below the message threads to keep them prompt
    WORKER_PRIORITY_MAX = 19,
};

struct worker_settings {
    int threads;  // OpenMP threads, 0 .. WORKER_THREADS_MAX; 0: as many as this process may use
    int priority; // nice value added for the computing threads, 0 .. WORKER_PRIORITY_MAX
    bool reopen;  // open the wire anew when it has been deaf for long (not over memq://)
    bool notes;   // tell the person at the terminal which runs come and go
};

struct worker_counters {
    uint64_t batches;
    uint64_t samples;
    int64_t busy_ns;
    uint32_t queue;
    uint32_t coordinators; // heard within the last seconds
};

struct worker;

// All cores, WORKER_PRIORITY_DEFAULT, no reopening, no notes: right for inside a coordinator.
struct worker_settings worker_settings_default(void);

// Starts a worker on `wire`, which outlives it: subscribes, attaches the wire to the default main
// context, starts the computing threads, announces itself, and again once a second. `sender` is the
// number the wire was opened with. Takes WIRE_SAMPLE_BATCH, WIRE_TEXT and WIRE_RUN_STATUS of the
// wire, with `reopen` WIRE_WORKER_STATUS too. Not to be called from a wire's handler.
// Errors: STATUS_NETWORK (subscription failed), STATUS_FAILED (no thread).
enum status worker_start(struct worker **worker, struct wire *wire, uint64_t sender,
                         const struct worker_settings *settings, struct error *error) MUST_USE;

// Finishes the batches in work, says that it leaves, and releases everything. NULL is fine. Not to
// be called from a wire's handler.
void worker_stop(struct worker *worker);

// How many OpenMP threads it has.
int worker_threads(const struct worker *worker);

void worker_counters(const struct worker *worker, struct worker_counters *counters);

#endif
