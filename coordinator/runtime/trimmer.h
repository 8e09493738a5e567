// Trims the boxes of many searches beside the event loop. Trimming a step of a few hundred samples
// costs about as much as simulating it, so on the loop alone a sweep would be limited by one core,
// whatever workers there are.
//
//     loop: trimmer_take() --> threads: run_trim() --> loop: handler, once for all that are ready
//
// What a thread does is a function of its search alone, so its timing changes no result; only the
// loop touches journal, schedule and network.
#ifndef SOBOX_COORDINATOR_RUNTIME_TRIMMER_H
#define SOBOX_COORDINATOR_RUNTIME_TRIMMER_H

#include "coordinator/runtime/run.h"

#include <glib.h>

struct trimmer;

// Told on the default main context which searches (struct run_search *) are trimmed.
typedef void trimmer_handler(void *user, GPtrArray *searches);

// Starts the threads (at least 1; fewer than asked for where the system refuses more).
// Errors: STATUS_FAILED (no thread, no descriptor).
enum status trimmer_create(struct trimmer **trimmer, int threads, trimmer_handler *handler,
                           void *user, struct error *error) MUST_USE;

// Waits for what the threads have in hand; nobody is told of it. NULL is fine.
void trimmer_free(struct trimmer *trimmer);

// Gives a search to the threads; until the handler is told of it nobody else may touch it. The
// number of searches that are open bounds the queue.
void trimmer_take(struct trimmer *trimmer, struct run_search *search);

// Searches waiting and in work for each thread.
double trimmer_load(const struct trimmer *trimmer);

#endif
