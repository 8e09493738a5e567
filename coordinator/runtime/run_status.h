// How a run as a whole goes, told to whoever watches (run_status_t). A run of searches and an
// evaluation of designs tell the same, so the message is built here for both.
#ifndef SOBOX_COORDINATOR_RUNTIME_RUN_STATUS_H
#define SOBOX_COORDINATOR_RUNTIME_RUN_STATUS_H

#include "common/numeric/digest.h"
#include "common/protocol/protocol.h"
#include "common/wire/wire.h"
#include "coordinator/schedule/schedule.h"

#include <stdint.h>

struct run_status {
    uint64_t run;
    const char *name;                 // of the scenario or sweep
    const struct digest *fingerprint; // of the coordinator's kernel
    enum run_state state;
    uint32_t searches; // of an evaluation: 1
    uint32_t searches_done;
    int64_t elapsed_ns; // over all sessions
};

// Publishes it with the schedule's counters and the wire's own. Lost: the next one follows.
void run_status_publish(struct wire *wire, const struct run_status *status,
                        const struct schedule_counters *counters);

// How the run stands that ended with this status. A session may end well and leave searches for
// another.
enum run_state run_status_after(enum status status, bool all_done);

#endif
