// The moment at which the main loop calls the schedule though nothing has arrived.
//
// With every outcome that moment moves a little further away, so the kernel's timer is left alone
// until it rings: a deadline that has moved meanwhile is waited for anew. A batch then costs no
// system call, and a lease's time one empty turn of the loop. GLib's own timers count in
// milliseconds, in which two steps of a cheap model are done.
#ifndef SOBOX_COORDINATOR_RUNTIME_DEADLINE_H
#define SOBOX_COORDINATOR_RUNTIME_DEADLINE_H

#include <stdint.h>

struct deadline;

// Called on the main loop at the deadline or later, once for each; it may set the next.
typedef void deadline_handler(void *user);

// No deadline is set. Errors: NULL when no descriptor is left.
struct deadline *deadline_create(deadline_handler *handler, void *user);
void deadline_free(struct deadline *deadline);

// The next one, in monotonic time, in place of the one before; INT64_MAX: none.
void deadline_set(struct deadline *deadline, int64_t time_ns);

#endif
