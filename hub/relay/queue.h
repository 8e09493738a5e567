// What waits to be written to one client: frames, each kept once for all the clients that it goes
// to, and given up by the last. When a queue is full the newest message is lost, whole: a client
// sees gaps, never pieces.
#ifndef SOBOX_HUB_RELAY_QUEUE_H
#define SOBOX_HUB_RELAY_QUEUE_H

#include "hub/relay/parcel.h"

#include <glib.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/uio.h>

struct queue {
    GQueue parcels;  // of struct parcel
    size_t size;     // [bytes] in them, those written already included
    size_t written;  // [bytes] of the first
    size_t size_max; // [bytes]
};

void queue_init(struct queue *queue, size_t size_max);
void queue_fini(struct queue *queue);

// Takes a hold on the parcel; false when it finds no room. An empty queue has room for any.
bool queue_push(struct queue *queue, struct parcel *parcel);

// What to write next, at most `max` pieces; returns how many there are.
size_t queue_peek(struct queue *queue, struct iovec *pieces, size_t max);

// So many bytes of it were written.
void queue_pop(struct queue *queue, size_t size);

#endif
