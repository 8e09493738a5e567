// How many samples the next batch of a step gets: by time, by message size, and by this worker's
// share of the step.
//
// - By time: what takes the worker roster_target_ns(), but a vector of samples for each of its
//   threads.
// - By message size: batch_samples_max.
// - By share: where fewer steps are open than there are workers, a step is split by the workers'
//   rates, so that all work on it and end together. A part is worth its messages:
//
//       parts of a step        k                    least sum at k = sqrt(work / message),
//       messages, on one loop  k x message          a part is worth sqrt(work x message)
//       work, side by side     work / k
//
//   With n searches n steps share the loop, and parts n times as long are right, up to where the
//   loop has a batch for every worker in half of its time: roster_turn_ns(). At least it is
//   CUT_WORTH_NS.
// A share above the greatest batch is cut into equal batches. Counts are multiples of CUT_LANES,
// and a small rest goes with the last batch.
#ifndef SOBOX_COORDINATOR_SCHEDULE_CUT_H
#define SOBOX_COORDINATOR_SCHEDULE_CUT_H

#include "coordinator/schedule/backlog.h"
#include "coordinator/schedule/roster.h"

enum {
    CUT_LANES = 8,          // samples in a vector of doubles (AVX-512), and verdict bits in a byte
    CUT_UNKNOWN_COUNT = 64, // greatest batch as long as nobody knows what a sample takes: a block
                            // of the model, so that a slow model is found out early
    CUT_WORTH_NS = 25000,   // a round trip over loopback takes 24 us: half of it is the
                            // coordinator's, and a batch should cost a worker more than that
};

// The count for `worker`, 1 .. the samples of `step` that are not cut. `open_count` steps have
// samples to cut, this one included, and `search_count` searches want steps sampled now and then.
uint32_t cut_count(const struct schedule_settings *settings, const struct roster *roster,
                   const struct roster_worker *worker, const struct backlog_step *step,
                   uint32_t open_count, uint32_t search_count);

#endif
