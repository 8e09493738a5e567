// Which Host header a request may carry. A web page of somebody else can make a browser ask this
// server by giving its own name this machine's address (DNS rebinding), and then counts as the same
// site. It cannot change the Host header, which carries that name: so only numbers and the names of
// this machine are answered.
#ifndef SOBOX_MONITOR_HTTP_HOST_H
#define SOBOX_MONITOR_HTTP_HOST_H

#include "common/base/error.h"

#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>

// Where to listen, as the user says it: "127.0.0.1:8765", "[::1]:8765", "localhost:8765", "8765"
// (on loopback), "0.0.0.0:8765". Port 0 lets the system choose.
struct host_address {
    union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } socket;
    bool loopback; // only this machine reaches it
};

// Errors: STATUS_INVALID with what would be right.
enum status host_parse(struct host_address *address, const char *text,
                       struct error *error) MUST_USE;

// Whether a Host header ("NAME", "NAME:PORT") is a number of any machine, "localhost", or `machine`
// (this machine's name), also with a domain behind it. NULL and "" are not.
bool host_is_ours(const char *header, const char *machine);

#endif
