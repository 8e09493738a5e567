// Which other machines are heard on the ports of a multicast group, and hear this one: for a person
// who sets up a network (survey.h). Workers and coordinators are heard on the status port anyway;
// one that looks at the same time, too, answers on all ports in both directions:
//
//     this machine  --- I am 7 --------------------> 10.77.0.2
//                   <-- I am 9, I heard 7 ----------            so it hears this one
//
// The calls are packets on the channel of LCM's own self test, which LCM programs ignore.
#ifndef SOBOX_COMMON_WIRE_NEIGHBOURS_H
#define SOBOX_COMMON_WIRE_NEIGHBOURS_H

#include "common/base/error.h"
#include "common/wire/key.h"
#include "common/wire/url.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    NEIGHBOURS_MAX = 64,
    NEIGHBOURS_PORTS = 3,
    NEIGHBOURS_CALL_MS = 100, // between two calls [ms]
    NEIGHBOURS_CALLS_SURE =
        8, // of who was heard so often it is known whether it hears this machine
};

struct neighbour {
    struct in_addr address;
    uint32_t nonce;               // that it calls with; 0: it does not call
    unsigned calls;               // heard on any port
    bool hears_us;                // one of its calls said so
    bool heard[NEIGHBOURS_PORTS]; // on this port
    bool worker, coordinator;     // such a program is there
    bool sealed;                  // and seals its messages
    bool opened;                  // with our key
    bool clear;                   // it does not seal them
};

struct neighbours {
    struct neighbour list[NEIGHBOURS_MAX];
    size_t count;
};

// Calls and listens for `milliseconds`. Other programs on this machine are not counted.
// Errors: STATUS_NETWORK as probe_port().
enum status neighbours_look(struct neighbours *neighbours, const struct url *url,
                            const struct key *key, int milliseconds, struct error *error) MUST_USE;

// Takes one packet that came from `from` on port `index`; `nonce` is our own. For neighbours_look()
// and its tests: pure.
void neighbours_take(struct neighbours *neighbours, struct in_addr from, unsigned index,
                     const uint8_t *packet, size_t size, uint32_t nonce, const struct key *key);

// Writes a call that names who was heard; returns its size.
enum { NEIGHBOURS_CALL_SIZE = 8 + 14 + 12 + 4 + 8 * 4 };
size_t neighbours_call(const struct neighbours *neighbours, uint32_t nonce,
                       uint8_t packet[NEIGHBOURS_CALL_SIZE]);

#endif
