// Worker processes on this machine, started and ended by the coordinator (--workers N). They are
// started before LCM is opened, because LCM does not survive a fork, and end with the coordinator,
// even when it is killed.
#ifndef SOBOX_COORDINATOR_RUNTIME_CHILDREN_H
#define SOBOX_COORDINATOR_RUNTIME_CHILDREN_H

#include "common/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct children_settings {
    uint32_t count;       // processes
    const char *url;      // they listen on
    const char *key_file; // whose key they read for themselves; NULL: none
    int threads;          // of each; 0: the machine's processors divided among them, at least 1
    uint32_t mtu;         // [bytes]
    bool verbose;
};

struct children;

// Told when a child has ended; `alive` are left. Called from the main loop.
typedef void children_watcher(void *user, uint32_t alive);

// Starts the processes: the sobox-worker beside this program, else the one on the PATH.
// Errors: STATUS_FAILED (not found, or the system refuses another process).
enum status children_start(struct children **children, const struct children_settings *settings,
                           struct error *error) MUST_USE;

// Calls `watcher` from now on.
void children_watch(struct children *children, children_watcher *watcher, void *user);

uint32_t children_alive(const struct children *children);

// Asks them to end, waits at most two seconds, kills what is left, and releases everything. NULL is
// fine.
void children_stop(struct children *children);

// A multicast URL for this machine alone (ttl=0) whose three ports nobody listens on now, so that
// two runs beside each other do not hear each other. The caller frees it with g_free().
char *children_private_url(void);

#endif
