// The dispatcher on a wire and a main loop: the clock, the messages, the timer and the signals that
// it does not know itself. Searches and tables of designs have one each.
//
//     dispatch_loop_step() --> dispatcher --> send() --> ... worker ... the user hears an outcome
//     --> dispatch_loop_outcome() --> dispatcher --> count() ... the last one --> finished()
#ifndef SOBOX_COORDINATOR_RUNTIME_DISPATCH_LOOP_H
#define SOBOX_COORDINATOR_RUNTIME_DISPATCH_LOOP_H

#include "common/wire/wire.h"
#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/runtime/coordinator.h"

struct dispatch_loop;

// What the loop asks of its user. send(), count() and finished() are the dispatcher's, with its
// rules (dispatcher.h).
struct dispatch_loop_calls {
    void (*send)(void *user, uint64_t worker, const struct batch_identity *batch);
    void (*count)(void *user, const struct batch_identity *batch);
    void (*finished)(void *user, uint32_t search, uint32_t step);
    // Once a second, for those who watch: how the work goes, and whether no worker is there.
    void (*status)(void *user, const struct schedule_counters *counters, bool waiting);
    // A worker has announced itself, and may have room for more. NULL: the user does not care.
    void (*room)(void *user);
};

// `run` is the number under which workers ask for texts. Everything is borrowed until
// dispatch_loop_free(), but `schedule` is copied.
// Errors: STATUS_NETWORK.
enum status dispatch_loop_create(struct dispatch_loop **loop, struct wire *wire, uint64_t run,
                                 const struct coordinator_settings *settings,
                                 const struct schedule_settings *schedule,
                                 const struct dispatch_loop_calls *calls, void *user,
                                 struct error *error) MUST_USE;
void dispatch_loop_free(struct dispatch_loop *loop); // NULL is fine

// The texts that workers may ask for; the user offers and withdraws them.
struct text_server *dispatch_loop_texts(struct dispatch_loop *loop);

// Samples that are to be evaluated; `detail` as the schedule has it.
void dispatch_loop_step(struct dispatch_loop *loop, uint32_t search, uint32_t step,
                        uint32_t samples, enum verdict_detail detail);

// The user has heard an outcome and found it well-formed: `worker` is its sender.
void dispatch_loop_outcome(struct dispatch_loop *loop, uint64_t worker,
                           const struct batch_identity *batch, uint32_t queue, int64_t service_ns);

void dispatch_loop_counters(const struct dispatch_loop *loop, struct schedule_counters *counters);

// Runs the main loop until dispatch_loop_stop(), a signal (STATUS_INTERRUPTED) or the end of all
// local workers (STATUS_FAILED); `directory` is the run folder with which the run can be continued.
// Returns how it ended.
enum status dispatch_loop_run(struct dispatch_loop *loop, const char *directory,
                              struct error *error) MUST_USE;

// Ends the main loop. The first status stands.
void dispatch_loop_stop(struct dispatch_loop *loop, enum status status);

#endif
