// What the coordinator tells those who watch: monitors, lcm-spy, lcm-logger. Nobody answers and
// nothing of the run depends on it, so all of it is bounded in time, whatever there is to tell:
//
//     run_status_t     once a second
//     search_status_t  of the open searches in turn, at most 32 a tick; of those that
//                      are done or have failed a few a tick, again and again
//     step_status_t    the latest samples, at most a few messages a tick over all searches
//     cases_t          of a sweep: what its cases are called, some twenty a message, at most one a
//                      tick
//
// A tick is 100 ms.
#ifndef SOBOX_COORDINATOR_RUNTIME_TELL_H
#define SOBOX_COORDINATOR_RUNTIME_TELL_H

#include "common/protocol/protocol.h"
#include "common/wire/wire.h"
#include "coordinator/runtime/run.h"
#include "coordinator/schedule/schedule.h"

#include <stdint.h>

enum { TELL_TICK_MS = 100 };

struct tell;

// `run` and `wire` are borrowed until tell_free(); `fingerprint` is of the coordinator's kernel.
struct tell *tell_create(const struct run *run, struct wire *wire,
                         const struct digest *fingerprint);
void tell_free(struct tell *tell); // NULL is fine

// How the run as a whole goes.
void tell_run(struct tell *tell, enum run_state state, const struct schedule_counters *counters);

// A tick passed: tells of searches and cases whose turn it is.
void tell_tick(struct tell *tell);

// The step of an open search was recorded, and the next is not asked for yet. It is told of when
// the last one told is long enough ago or a phase ends, and there is room.
void tell_step(struct tell *tell, struct run_search *search, int64_t now_ns);

// An open search is done: tells how it ended, with its whole box.
void tell_end(struct tell *tell, struct run_search *search);

#endif
