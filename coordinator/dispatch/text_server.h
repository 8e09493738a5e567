// The texts that workers may ask for by their digest: scenarios, and boxes too large to travel with
// each batch. What one worker asked for, all hear: those who asked at about the same time are
// served by one sending, so a text is not sent again before it could have been sent at
// TEXT_SERVER_BYTE_NS.
//
// That time grows with the text, because it bounds what a crowd of workers that asks for the same
// scenario can ask of the network, and is short for a small box, because a worker that gets its
// first batch of a box a moment after the others had it sent has not kept that text: a fixed time
// of 20 ms let whole steps pass before such a worker could begin.
#ifndef SOBOX_COORDINATOR_DISPATCH_TEXT_SERVER_H
#define SOBOX_COORDINATOR_DISPATCH_TEXT_SERVER_H

#include "common/numeric/digest.h"

#include <stddef.h>
#include <stdint.h>

enum { TEXT_SERVER_BYTE_NS = 200 }; // [ns/byte] of one text over and over: 5 MB/s

struct text_server;

struct text_server *text_server_create(void);
void text_server_free(struct text_server *server);

// Offers a text, of which a copy is kept. The same digest may be offered several times and is then
// to be withdrawn as often. (It is a copy because whoever offers the same text, as the searches of
// a sweep do with the box of their common design space, may end in any order.)
void text_server_offer(struct text_server *server, const struct digest *digest, const void *bytes,
                       size_t size);
void text_server_withdraw(struct text_server *server, const struct digest *digest);

// The text with this digest, if it is to be sent now from `offset` on: NULL when there is none,
// when `offset` is beyond its end, or when it was sent from there less than its size times
// TEXT_SERVER_BYTE_NS ago.
const uint8_t *text_server_ask(struct text_server *server, const struct digest *digest,
                               size_t offset, int64_t now_ns, size_t *size);

#endif
