// What stands between the network and LCM's own socket.
//
// LCM 1.3.1 can be crashed by one fragment (LC03) packet, hands on a packet without end of channel
// name with a size of 4 GB, and keeps every channel name it ever saw. None of that needs a patch:
// LCM's receiving socket is a descriptor of this process like any other, so a kernel filter put on
// it lets through only what LCM handles well: whole messages (LC02) on a channel of this port, of a
// size that such a message can have.
//
// LCM opens the socket, binds it and starts to read in one call, and in between it must be stopped:
// one packet at the wrong moment is enough. The one place where it calls back is a GLib warning
// that the receive buffer is smaller than asked. So it is asked for more than any kernel grants
// (url.h), and the guard stands in as the log handler: socket open, not yet bound.
#ifndef SOBOX_COMMON_WIRE_GUARD_H
#define SOBOX_COMMON_WIRE_GUARD_H

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

// LCM uses select(): a descriptor above this aborts the process.
enum { GUARD_DESCRIPTORS = 1024 };

// Which descriptors are open.
struct guard_descriptors {
    uint64_t open[GUARD_DESCRIPTORS / 64];
};

void guard_look(struct guard_descriptors *descriptors);

// Whether LCM can still open what it needs below GUARD_DESCRIPTORS.
bool guard_room(void);

// Marks what was opened since `before` close-on-exec, so that programs started later do not
// inherit it. Returns the datagram socket among it that is bound to `port`, or -1.
int guard_claim(const struct guard_descriptors *before, uint16_t port);

// A guard on its way to LCM's socket.
struct guard {
    unsigned index;                  // of the wire's port
    uint16_t port;                   // that LCM will bind
    int32_t buffer;                  // receive buffer wanted [bytes]
    int socket;                      // that the filter stands on; -1: none yet
    struct guard_descriptors before; // open when the guard was armed
    GThread *thread;                 // that LCM is called from
    GLogFunc log_handler;            // GLib's, as it was
    GLogLevelFlags log_fatal;        // same
};

// Call it, let LCM open its socket (lcm_get_fileno), then call guard_disarm().
void guard_arm(struct guard *guard, unsigned index, uint16_t port, int32_t buffer);

// Returns LCM's receiving socket, with the filter of the wire's port `index` (check.h) on it and
// close-on-exec like all that LCM has opened meanwhile; -1 when there is no such socket, or the
// kernel refuses the filter. Should LCM not have called back, the filter is put on now, and
// what was received before is waited for, briefly; until then only the channel of LCM's self test
// is subscribed to.
int guard_disarm(struct guard *guard);

// Datagrams that the kernel dropped at this socket, for want of buffer or by the filter; wraps.
uint32_t guard_dropped(int socket);

// The receive buffer that the kernel granted the socket [bytes].
uint32_t guard_buffer(int socket);

#endif
