// What stands between the network and LCM's own socket.
//
// LCM 1.3.1 can be crashed by one fragment (LC03) packet, hands on a packet without end of channel
// name with a size of 4 GB, and keeps every channel name it ever saw. None of that needs a patch:
// LCM's receiving socket is a descriptor of this process like any other, so a kernel filter put on
// it lets through only what LCM handles well: whole messages (LC02) on a channel of this port, of a
// size that such a message can have.
//
// Between the moment LCM opens its socket and the filter's (some milliseconds, LCM's self test)
// only the self test's channel is subscribed; sobox's channels are subscribed when the filter
// stands and what came before it is gone.
#ifndef SOBOX_COMMON_WIRE_GUARD_H
#define SOBOX_COMMON_WIRE_GUARD_H

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

// Puts the filter of the wire's port `index` (check.h) on the socket and waits, briefly, until what
// was received before is read. False when the kernel refuses.
bool guard_attach(int socket, unsigned index);

// Datagrams that the kernel dropped at this socket, for want of buffer or by the filter; wraps.
uint32_t guard_dropped(int socket);

// The socket's receive buffer [bytes]. Raised to `wanted` where the process may exceed the
// system's limit (net.core.rmem_max).
uint32_t guard_buffer(int socket, int32_t wanted);

#endif
