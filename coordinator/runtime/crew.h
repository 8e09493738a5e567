// The workers on a wire as one who has work for them sees them: it says which samples are to be
// evaluated, is asked to send the batches that the schedule makes of them, and is told what counts.
// Leases, texts that workers ask for, deadlines, the status of the run and the ways in which all of
// it may end are the crew's.
//
//     crew_step() --> schedule --> send() --> ... worker ... --> crew_outcome() --> count()
//                                                                   ... the last --> finished()
#ifndef SOBOX_COORDINATOR_RUNTIME_CREW_H
#define SOBOX_COORDINATOR_RUNTIME_CREW_H

#include "common/numeric/digest.h"
#include "common/wire/wire.h"
#include "coordinator/runtime/coordinator.h"
#include "coordinator/schedule/schedule.h"

struct crew;

// What the crew asks of its user, on the main loop.
struct crew_calls {
    // Publish this batch, leased to this worker. A message that LCM cannot send is one that was
    // lost: the lease brings the batch back.
    void (*send)(void *user, uint64_t worker, const struct schedule_batch *batch);
    // The outcome being given to crew_outcome() counts.
    void (*count)(void *user, const struct schedule_batch *batch);
    // All samples of this step have been counted. Not called from within crew_step().
    void (*finished)(void *user, uint32_t search, uint32_t step);
};

// `name` and `run` are told to workers and monitors. Everything is borrowed until crew_free().
// Errors: STATUS_NETWORK.
enum status crew_create(struct crew **crew, struct wire *wire, const char *name, uint64_t run,
                        const struct coordinator_settings *settings,
                        const struct schedule_settings *schedule, const struct crew_calls *calls,
                        void *user, struct error *error) MUST_USE;
void crew_free(struct crew *crew);

// A text that workers may ask for, as texts_add() has it.
void crew_offer(struct crew *crew, const struct digest *digest, const void *bytes, size_t size);

// Samples that are to be evaluated.
void crew_step(struct crew *crew, uint32_t search, uint32_t step, uint32_t samples);

// An outcome has been heard and is well-formed: `worker` is its sender.
void crew_outcome(struct crew *crew, uint64_t worker, const struct schedule_batch *batch,
                  uint32_t queue, int64_t service_ns);

void crew_counters(const struct crew *crew, struct schedule_counters *counters);

// Runs the main loop until crew_stop(), a signal (STATUS_INTERRUPTED) or the end of all local
// workers (STATUS_FAILED), for which `reason` says how to continue. Returns how it ended.
enum status crew_run(struct crew *crew, const char *reason, struct error *error) MUST_USE;

// Ends the main loop. The first status stands.
void crew_stop(struct crew *crew, enum status status);

#endif
