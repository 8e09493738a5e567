// Tries what LCM is about to do, with sockets of its own, because LCM says little about what went
// wrong and waits ten seconds for a packet that a firewall has dropped.
#ifndef SOBOX_COMMON_WIRE_PROBE_H
#define SOBOX_COMMON_WIRE_PROBE_H

#include "common/wire/url.h"

enum {
    PROBE_RESEND_MS = 50, // a probe that does not come back is sent again after this long [ms]
    PROBE_SENDS = 20,     // then the group is deaf: one second
};

// Whether multicast to the group has a route.
// Errors: STATUS_NETWORK with the remedy.
enum status probe_route(const struct url *url, struct error *error) MUST_USE;

// Whether port `index` of the group can be shared and a packet sent to it comes back. The packet
// does not leave this machine; LCM programs on the port ignore it.
// Errors: STATUS_NETWORK with what stands in the way and the remedy.
enum status probe_port(const struct url *url, unsigned index, struct error *error) MUST_USE;

// Opens a socket of ours that shares port `index` of the group, hears it, and sends to it with this
// time to live. The caller closes `*joined`, which is -1 when it could not be opened.
// Errors: STATUS_NETWORK.
enum status probe_join(int *joined, const struct url *url, unsigned index, int ttl,
                       struct error *error) MUST_USE;

#endif
