// What a hub does with the bytes of its clients: reads their frames (common/wire/frame.h), and puts
// each message into the queues of those who have subscribed to its channel, the sender included.
//
//     bytes from a client -> hello? -> frame -> SUBSCRIBE    -> its patterns
//                                             -> PUBLISH -> seal right? -> queues of the
//                                             subscribers
//
// It knows no socket and no clock: hub/server gives it bytes and the time and takes bytes from it.
// Clients are strangers until proven otherwise, so everything that one can make it keep is bounded:
//
//   a client says no hello             it is cut off after RELAY_HELLO_NS
//   begins a message and never ends    after RELAY_FRAME_NS
//   announces a huge message           the message is skipped as it comes, nothing is kept
//   reads slowly or not at all         its queue fills, further messages to it are lost and counted
//   subscribes to everything           RELAY_PATTERNS_MAX
//   says what is no frame              it is cut off
//   opens many connections             clients_max; newcomers replace the least proven
//   (relay_victim)
#ifndef SOBOX_HUB_RELAY_RELAY_H
#define SOBOX_HUB_RELAY_RELAY_H

#include "common/wire/key.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/uio.h>

#define RELAY_HELLO_NS INT64_C(5000000000)
#define RELAY_FRAME_NS INT64_C(30000000000)

enum {
    RELAY_PATTERNS_MAX = 64, // subscriptions of a client; a sobox program has ten at most
    RELAY_ROUTES_MAX = 256,  // channels of which it is remembered who wants them
    RELAY_NAME_SIZE = 32,    // [bytes] of a client's name, "192.168.1.10:41234"
};

struct relay_settings {
    uint32_t clients_max; // at once
    size_t message_max;   // [bytes] of a message's data
    size_t queue_max;     // [bytes] that wait for one client
    size_t memory_max;    // [bytes] that wait for all, each message counted once
    // Only messages sealed with it are passed on. Borrowed. NULL: all are.
    const struct key *key;
};

struct relay_counters {
    uint64_t joined;    // clients that came
    uint64_t received;  // messages whole
    uint64_t delivered; // put into queues
    uint64_t lost;      // not put into queues for want of room
    uint64_t refused;   // not passed on: no right seal
    uint64_t large;     // not passed on: too large
};

struct relay;
struct relay_client;

struct relay_settings relay_settings_default(void);

// `settings` are copied.
struct relay *relay_create(const struct relay_settings *settings);
void relay_free(struct relay *relay); // with all its clients; NULL is fine

// A client has connected; `user` belongs to the caller, `name` is copied. NULL when there are
// clients_max: then one must leave first.
struct relay_client *relay_join(struct relay *relay, const char *name, void *user, int64_t now_ns);

// The client is gone; it is freed.
void relay_leave(struct relay *relay, struct relay_client *client);

// Whom a newcomer may replace when all places are taken: the one that waited longest to say hello,
// else, with a key, the one that is there longest of those who never sent a sealed message, when
// they had RELAY_HELLO_NS for it. NULL when all have earned their place.
struct relay_client *relay_victim(struct relay *relay, int64_t now_ns);

// Some client that has overstepped a time limit, or NULL.
struct relay_client *relay_overdue(struct relay *relay, int64_t now_ns);

// Takes bytes that came from the client. False when it must be cut off; `why` is then a sentence.
bool relay_take(struct relay *relay, struct relay_client *client, const uint8_t *bytes, size_t size,
                int64_t now_ns, const char **why);

// The next client whose queue was empty when something was put into it, or NULL: each is named
// once.
struct relay_client *relay_next_to_write(struct relay *relay);

// What to write to the client next, at most `max` pieces, and that so much of it was written.
size_t relay_peek(struct relay_client *client, struct iovec *pieces, size_t max);
void relay_pop(struct relay_client *client, size_t size);

void *relay_user(const struct relay_client *client);
const char *relay_name(const struct relay_client *client);

// Messages to this client that were lost. Asking sets it to 0.
uint64_t relay_lost(struct relay_client *client);

// Calls `each` for every client; `each` may not let it leave.
void relay_each(struct relay *relay, void (*each)(struct relay_client *client, void *user),
                void *user);

size_t relay_count(const struct relay *relay); // of clients
struct relay_counters relay_counters(const struct relay *relay);

#endif
