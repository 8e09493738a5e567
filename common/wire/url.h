// The URL of a wire: memq://, udpm://ADDRESS:PORT?ttl=N&recv_buf_size=BYTES, or
// tcpq://ADDRESS:PORT, where a hub is.
//
// LCM takes more than works: it reads a missing port as port 0, an unknown option as a warning, a
// leading zero as an octal number, and the name of a hub's host as this host. So the URL is read
// here, strictly, and LCM gets one that is written anew for each of the wire's ports.
#ifndef SOBOX_COMMON_WIRE_URL_H
#define SOBOX_COMMON_WIRE_URL_H

#include "common/base/error.h"

#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    URL_TTL_DEFAULT = 0, // messages stay on this machine
    // [bytes] Holds some 3,000 messages of 1 KB while the reader is busy; the kernel's default
    // holds 92 of them. The kernel grants at most net.core.rmem_max, and doubles what it grants.
    URL_RECEIVE_BUFFER_DEFAULT = 4000000,
    URL_PORT_MAX = 65533, // the two ports after it are used too
    URL_LCM_SIZE = 96,    // [bytes] of a URL as url_lcm() writes it
};

struct url {
    bool memq;                     // memq://: inside the process; nothing below counts
    bool tcpq;                     // tcpq://: through a hub; only address and port count
    char address[INET_ADDRSTRLEN]; // of the multicast group or the hub, dotted
    uint16_t port;                 // the first of the wire's ports, 1 .. URL_PORT_MAX; or the hub's
    uint8_t ttl;                   // routers a message may cross; 0 keeps it on this machine
    int32_t receive_buffer;        // asked of the kernel [bytes]
};

// Reads `text`. Options left out get the defaults above.
// Errors: STATUS_INVALID with what would be right.
enum status url_parse(struct url *url, const char *text, struct error *error) MUST_USE;

// Whether messages can leave this machine.
bool url_leaves_machine(const struct url *url);

// Writes the URL for LCM of the port `index` places after the first; returns `text`. It asks for a
// receive buffer that no kernel grants: LCM's warning of that is where guard.h puts its filter on
// the socket, and sets the buffer to what this URL asks for.
const char *url_lcm(const struct url *url, unsigned index, char text[URL_LCM_SIZE]);

// Socket address of that port of the group, or of the hub (index 0).
struct sockaddr_in url_socket_address(const struct url *url, unsigned index);

#endif
