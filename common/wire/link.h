// A client of a hub: the wire's side of tcpq://ADDRESS:PORT.
//
//             connect             hello sent            hello came
//     WAITING ------> CONNECTING -----------> GREETING ------------> UP
//        ^                |                       |                   |
//        +----------------+-----------------------+-------------------+
//            refused, no answer in time, connection lost, not a hub
//
// LCM's own client is not used: it blocks in connect, in the middle of a message and in front of a
// hub that has stopped; sends five small packets a message, which Nagle's rule holds back for 40
// ms; and has no limit to what it reserves for a message that is announced. This one speaks the
// same protocol (frame.h), never blocks, and comes back by itself when the hub does.
//
// Delivery is best effort, as by multicast: what finds no room or no hub is lost, and said to be.
#ifndef SOBOX_COMMON_WIRE_LINK_H
#define SOBOX_COMMON_WIRE_LINK_H

#include "common/base/error.h"

#include <netinet/in.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    LINK_OPEN_WAIT_MS = 1000,  // a program that begins waits so long for a hub that answers [ms]
    LINK_GREETING_MS = 5000,   // a hub that has not said hello by then is given up [ms]
    LINK_RETRY_MIN_MS = 50,    // between two attempts: doubled each time [ms]
    LINK_RETRY_MAX_MS = 1000,  // up to this: so soon the cluster is together after a restart [ms]
    LINK_OUTPUT_MAX = 4000000, // [bytes] that wait for a hub that is slow, as a receive buffer's
    LINK_INPUT_SIZE = 262144,  // [bytes] read at once; holds any message of the wire
};

// A message arrived on `channel`; all is borrowed until it returns. It may send.
typedef void link_handler(void *user, const char *channel, const uint8_t *data, size_t size);

struct link;

// Opens a link and begins to connect. Errors: STATUS_NETWORK (no descriptors left).
enum status link_open(struct link **link, const struct sockaddr_in *address, link_handler *handler,
                      void *user, struct error *error) MUST_USE;

// Waits until the hub is there, or is known not to be, or has not answered for `ms`. A hub that is
// not there is no error: the link goes on trying by itself, with a note to the person.
void link_wait(struct link *link, int ms);

// Closes it. NULL is fine.
void link_close(struct link *link);

// Subscribes to the channel of exactly this name, now and whenever the hub comes back. `channel` is
// borrowed for the life of the link.
void link_subscribe(struct link *link, const char *channel);

// Sends a message; false when there is no hub or too much waits for it already.
bool link_send(struct link *link, const char *channel, const uint8_t *data, size_t size);

// Readable when link_dispatch() has something to do. The same for the life of the link.
int link_descriptor(const struct link *link);

// Does what there is to do, handing on at most `limit` messages, and returns how many it did.
size_t link_dispatch(struct link *link, size_t limit);

// Gives the connection up and tries anew: for who hears nothing although it is up.
void link_reopen(struct link *link);

// Whether the hub is there.
bool link_is_up(const struct link *link);

// What a connection of LCM's protocol needs on either side: no waiting for a packet to fill, and an
// end within half a minute when the other machine has gone without a word.
void link_tune(int socket);

#endif
