// The sockets of a hub: accepts clients, hands their bytes to the relay and writes what it has for
// them. One thread, never blocked: a socket that takes no more is left alone until it does.
#ifndef SOBOX_HUB_SERVER_SERVER_H
#define SOBOX_HUB_SERVER_SERVER_H

#include "common/base/error.h"
#include "hub/relay/relay.h"

#include <netinet/in.h>

struct server;

// Listens at `address` and serves whoever comes, once it is dispatched. `settings` are copied;
// fewer clients are let in than they allow where the process may not open as many files, with a
// note. Errors: STATUS_NETWORK (the address is in use, or not this machine's, or needs another
// user).
enum status server_open(struct server **server, const struct sockaddr_in *address,
                        const struct relay_settings *settings, struct error *error) MUST_USE;

// Closes all connections. NULL is fine.
void server_close(struct server *server);

// Where it listens, with the port that the kernel chose for port 0.
struct sockaddr_in server_address(const struct server *server);

// Readable when server_dispatch() has something to do.
int server_descriptor(const struct server *server);

// Does what there is to do now, and returns.
void server_dispatch(struct server *server);

// Cuts off who oversteps a time limit and tells of who loses messages; to be called once a second.
void server_second(struct server *server);

size_t server_clients(const struct server *server);
struct relay_counters server_counters(const struct server *server);

#endif
