// The worker's side of the protocol as a pure step machine: batches that arrive for it, the
// scenario texts and boxes they need, what to evaluate next. It knows no clock, network or thread:
// the runtime tells it what arrived and when, and carries out what it answers.
//
//   batch heard -> known scenario and box?  yes -> queued -> taken -> outcome sent
//                                           no  -> text requested -> text complete -> queued
//
// A batch of given designs brings them along and needs no box.
//
// The queue is bounded: a batch that finds it full is dropped, and its lease lapses. So are the
// number and the size of the texts kept: the one unused for longest goes first, and is asked for
// again by the next batch that needs it. A text that nobody sends, however often it is asked for,
// is given up with the batches that wait for it: their coordinator is gone.
//
// A request is answered with all pieces from its offset on. So a missing piece is noticed when the
// last one arrives, and asked for at once; only the loss of the last one costs an interval.
#ifndef SOBOX_WORKER_BATCH_INTAKE_H
#define SOBOX_WORKER_BATCH_INTAKE_H

#include "common/base/error.h"
#include "common/numeric/digest.h"
#include "common/protocol/protocol.h"
#include "worker/batch/batch.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct intake;

enum {
    INTAKE_QUEUE_MAX = 1024, // batches waiting or taken; thousands would only grow stale
    // Scenarios kept, prepared or asked for: more than one coordinator has searches open, and some
    // for another. A prepared one of thesis size takes 20 KB.
    INTAKE_SCENARIO_MAX = PROTOCOL_SCENARIO_MAX,
    // Texts of those prepared [bytes]: what is made of one takes some 25 times its size.
    INTAKE_SCENARIO_SIZE_MAX = 16 << 20,
    INTAKE_BOX_MAX = 1024, // boxes kept or asked for; not less than the queue is long
    // Of designs that wait or are taken [bytes]: hundreds of batches of the greatest messages.
    INTAKE_DESIGN_SIZE_MAX = 32 << 20,
    INTAKE_ASK_MAX = 12, // requests without an answer, then a text is given up: about 9 s
};

// A text is asked for again after the first interval, then after twice as long each time.
#define INTAKE_INTERVAL_MIN_NS INT64_C(50000000)
#define INTAKE_INTERVAL_MAX_NS INT64_C(1000000000)

// A batch as it came over the wire, already checked field by field.
struct intake_batch {
    uint64_t run;
    uint64_t coordinator; // sender to answer
    struct batch_identity identity;
    struct digest scenario;
    struct digest box;
    struct sampling sampling; // of the whole step
    enum verdict_detail detail;
    uint32_t variables;  // of the box
    const uint8_t *text; // (text_size) of the box (common/sampling/box_text.h); borrowed
    uint32_t text_size;  // [bytes] 0: it comes by request
    // Of a batch of given designs: identity.count x variables. It has no box, no text, no
    // sampling, and no detail. NULL: the batch is one of samples. Borrowed.
    const double *designs;
    uint32_t design_value_count;
};

// A batch ready to be evaluated. Pointers, also those to designs, are borrowed until intake_done().
struct intake_work {
    struct intake_batch batch; // text NULL
    const struct scenario *scenario;
    const struct model *model;
    const struct box *box; // NULL: batch.designs are to be evaluated
};

// The samples that a batch of samples asks for.
struct batch intake_samples(const struct intake_batch *batch);

// A request for a text, to be published now.
struct intake_request {
    uint64_t run;
    struct digest digest;
    uint32_t offset; // first byte missing
};

struct intake *intake_create(void);
void intake_free(struct intake *intake);

// Takes a batch in. One that waits or is taken already (same coordinator, run, search, step, batch
// and samples) is not queued twice; the number of its last attempt goes into the outcome.
// Returns STATUS_OK also when it is not queued for that reason.
// Errors: STATUS_REFUSED (dropped for want of room: the queue is full, or as many scenarios as may
// be kept are in use, or too many designs wait), STATUS_INVALID (dropped: its text is not that of
// `box`, or no box, or the box has not one interval for each variable of the scenario, or its
// sampling needs attacks and has none for all its samples; its designs are not finite or have
// another number of values).
enum status intake_batch(struct intake *intake, const struct intake_batch *batch, int64_t now_ns,
                         struct error *error) MUST_USE;

// Takes a piece of a text in: 0 < size, offset + size <= total. Pieces nobody waits for are
// ignored, and so are sizes that no text can have. Errors: STATUS_INVALID (batches were dropped:
// the text is not the one promised, or a scenario that cannot be read, or a box that is none or
// does not fit its scenario).
enum status intake_text(struct intake *intake, const struct digest *digest, uint32_t total_size,
                        uint32_t offset, const uint8_t *piece, uint32_t size, int64_t now_ns,
                        struct error *error) MUST_USE;

// Fills in the next text to ask for, and marks it asked at `now_ns`. False when there is none to
// ask for now. Call it until it says so.
bool intake_request(struct intake *intake, int64_t now_ns, struct intake_request *request);

// When intake_request() may next have something; INT64_MAX when no text is missing.
int64_t intake_wake_ns(const struct intake *intake);

// Takes the next batch that is ready, coordinators in turn, the oldest of each first; false when
// none is. Several may be taken.
bool intake_take(struct intake *intake, struct intake_work *work);

// The batch has been evaluated: its scenario and box may go when they are no longer needed.
void intake_done(struct intake *intake, const struct intake_work *work);

// Batches waiting or taken, those that wait for a text included.
uint32_t intake_queue(const struct intake *intake);

#endif
