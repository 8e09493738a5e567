// Threads beside the event loop: they do what a job asks for, and the loop is told which are done.
// Trimming a step of a few hundred samples costs about as much as simulating it, and reading or
// writing a row of numbers more than simulating its design, so on the loop alone a run would be
// limited by one core, whatever workers there are.
//
//     loop: pool_take() --> threads: work() --> loop: done(), once for all that are ready
//
// A job belongs to the threads until the loop is told of it, and what a thread does is a function
// of its job alone, so its timing changes no result; only the loop touches files, schedule and
// network.
#ifndef SOBOX_COORDINATOR_RUNTIME_POOL_H
#define SOBOX_COORDINATOR_RUNTIME_POOL_H

#include "common/base/error.h"

#include <glib.h>

struct pool;

typedef void pool_work(void *job);

// Told on the default main context which jobs are done.
typedef void pool_done(void *user, GPtrArray *jobs);

// Starts the threads (at least 1; fewer than asked for where the system refuses more).
// Errors: STATUS_FAILED (no thread, no descriptor).
enum status pool_create(struct pool **pool, int threads, pool_work *work, pool_done *done,
                        void *user, struct error *error) MUST_USE;

// Waits for what the threads have in hand; nobody is told of it. NULL is fine.
void pool_free(struct pool *pool);

// Gives a job to the threads. Jobs are begun in the order in which they were given.
// Their user bounds how many there are.
void pool_take(struct pool *pool, void *job);

// Jobs waiting and in work for each thread.
double pool_load(const struct pool *pool);

#endif
