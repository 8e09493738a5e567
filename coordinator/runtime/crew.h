// The workers on a wire as one who has work for them sees them: it says which samples are to be
// evaluated, is asked to send the batches that the schedule makes of them, and is told what counts.
// Leases, texts that workers ask for, deadlines, and the ways in which all of it may end are the
// crew's. Searches and tables of designs have one each.
//
//     crew_step() --> schedule --> send() --> ... worker ... --> crew_outcome() --> count()
//                                                                   ... the last --> finished()
#ifndef SOBOX_COORDINATOR_RUNTIME_CREW_H
#define SOBOX_COORDINATOR_RUNTIME_CREW_H

#include "common/numeric/digest.h"
#include "common/wire/wire.h"
#include "coordinator/runtime/coordinator.h"
#include "coordinator/runtime/texts.h"
#include "coordinator/schedule/schedule.h"

struct crew;

// What the crew asks of its user, on the main loop.
struct crew_calls {
    // Publish this batch, leased to this worker. A message that LCM cannot send is one that was
    // lost: the lease brings the batch back.
    void (*send)(void *user, uint64_t worker, const struct batch_identity *batch);
    // The outcome being given to crew_outcome() counts.
    void (*count)(void *user, const struct batch_identity *batch);
    // All samples of this step have been counted. Not called from within crew_step().
    void (*finished)(void *user, uint32_t search, uint32_t step);
    // Once a second, for whoever watches: how it goes, and whether there is nobody to work.
    void (*status)(void *user, const struct schedule_counters *counters, bool waiting);
    // A worker has announced itself, and may have room for more. NULL: it is nothing to the user.
    void (*room)(void *user);
};

// `run` is the number under which workers ask for texts. Everything is borrowed until crew_free().
// Errors: STATUS_NETWORK.
enum status crew_create(struct crew **crew, struct wire *wire, uint64_t run,
                        const struct coordinator_settings *settings,
                        const struct schedule_settings *schedule, const struct crew_calls *calls,
                        void *user, struct error *error) MUST_USE;
void crew_free(struct crew *crew);

// The texts that workers may ask for, for the user to offer.
struct texts *crew_texts(struct crew *crew);

// Samples that are to be evaluated; with this detail of verdicts.
void crew_step(struct crew *crew, uint32_t search, uint32_t step, uint32_t samples,
               enum verdict_detail detail);

// An outcome has been heard and is well-formed: `worker` is its sender.
void crew_outcome(struct crew *crew, uint64_t worker, const struct batch_identity *batch,
                  uint32_t queue, int64_t service_ns);

void crew_counters(const struct crew *crew, struct schedule_counters *counters);

// Runs the main loop until crew_stop(), a signal (STATUS_INTERRUPTED) or the end of all local
// workers (STATUS_FAILED); `directory` is the run folder with which it can be continued. Returns
// how it ended.
enum status crew_run(struct crew *crew, const char *directory, struct error *error) MUST_USE;

// Ends the main loop. The first status stands.
void crew_stop(struct crew *crew, enum status status);

#endif
