// The dispatcher stands between those who want samples evaluated and the workers that evaluate
// them. It hands what happens to the schedule, carries out what the schedule answers, and answers
// workers that ask for a text. A search, a table of designs, a simulated cluster and a benchmark
// use the same one: it knows no clock and no network, so time comes in with each event and messages
// leave through calls.
//
//     a step is wanted    --> +------------+ --> send(): a batch to a worker
//     a worker announced  --> | dispatcher | --> count(): the outcome at hand counts
//     an outcome arrived  --> |  schedule  | --> finished(): all samples of a step are counted
//     time has passed     --> |  texts     | --> note(): what a person should know
//     a text is asked for --> +------------+ --> piece(): a part of that text
//
// The caller wakes it with SCHEDULE_EVENT_TICK at dispatcher_wake_ns().
#ifndef SOBOX_COORDINATOR_DISPATCH_DISPATCHER_H
#define SOBOX_COORDINATOR_DISPATCH_DISPATCHER_H

#include "common/numeric/digest.h"
#include "coordinator/dispatch/text_server.h"
#include "coordinator/schedule/schedule.h"

#include <stddef.h>
#include <stdint.h>

struct dispatcher;

// A part of a text on its way to every worker.
struct text_piece {
    struct digest digest; // of the whole text
    size_t total;         // size of the whole text [bytes]
    size_t offset;        // where the piece begins [bytes]
    const uint8_t *bytes; // (size) borrowed until the call returns
    size_t size;          // of the piece [bytes]
};

// What the dispatcher asks of its user. Only finished() may call the dispatcher again, because the
// others are called while the effects of one event are being carried out.
struct dispatcher_calls {
    // Publish this batch, leased to this worker. A message that cannot be sent is a message that
    // was lost: the lease brings the batch back.
    void (*send)(void *user, uint64_t worker, const struct batch_identity *batch);
    // The outcome with which dispatcher_take() was called counts.
    void (*count)(void *user, const struct batch_identity *batch);
    // All samples of this step have been counted. Called last, after every other effect.
    void (*finished)(void *user, uint32_t search, uint32_t step);
    // Publish this part of a text, for all workers.
    void (*piece)(void *user, const struct text_piece *piece);
    // A notice in plain words.
    void (*note)(void *user, const char *note);
};

// `piece_size` is what one message carries of a text [bytes]. `calls` and `user` are borrowed until
// dispatcher_free(); `settings` are copied.
struct dispatcher *dispatcher_create(const struct schedule_settings *settings, size_t piece_size,
                                     const struct dispatcher_calls *calls, void *user);
void dispatcher_free(struct dispatcher *dispatcher); // NULL is fine

// Something has happened, at event->now_ns: the schedule hears of it and its answer is carried out.
void dispatcher_take(struct dispatcher *dispatcher, const struct schedule_event *event);

// A worker asks for a text from `offset` on. It is answered with some pieces, and asks on from
// there; a text that is not offered, or was sent a moment ago, is not answered.
void dispatcher_request(struct dispatcher *dispatcher, const struct digest *digest, size_t offset,
                        int64_t now_ns);

// The texts that workers may ask for; the user offers and withdraws them.
struct text_server *dispatcher_texts(struct dispatcher *dispatcher);

// When SCHEDULE_EVENT_TICK is due; INT64_MAX when nothing is.
int64_t dispatcher_wake_ns(const struct dispatcher *dispatcher);

void dispatcher_counters(const struct dispatcher *dispatcher, struct schedule_counters *counters);

#endif
