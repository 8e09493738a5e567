// The coordinator: carries a run's steps to the workers on a wire and their verdicts back. It is
// the thin shell around the pure search and schedule: only here time is read and messages are sent,
// all of it on one GLib main loop.
#ifndef SOBOX_COORDINATOR_RUNTIME_COORDINATOR_H
#define SOBOX_COORDINATOR_RUNTIME_COORDINATOR_H

#include "common/base/error.h"
#include "common/wire/wire.h"
#include "coordinator/runtime/children.h"
#include "coordinator/runtime/run.h"

#include <stdint.h>

struct coordinator_settings {
    const char *url;           // as users may give it to sobox-worker, for messages
    struct children *children; // local worker processes, or NULL
    bool open;                 // other workers may join: waiting for one makes sense
    int threads;               // that trim the searches of a sweep
};

// Works on `run` until every search chosen for this session is done or has failed, a signal
// (SIGINT, SIGTERM) ends it, or it fails. Of many searches as many are open at once as keep the
// workers and the trimming threads busy; the rest wait. The wire's
// subscriptions and the main loop are the coordinator's. The journal's state is written before it
// returns. Errors: STATUS_INTERRUPTED, STATUS_IO (journal), STATUS_NETWORK, STATUS_FAILED (no
// worker left).
enum status coordinator_run(struct run *run, struct wire *wire,
                            const struct coordinator_settings *settings,
                            struct error *error) MUST_USE;

#endif
