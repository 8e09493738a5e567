// LCM's own protocol over TCP (tcpq://), as its clients and sobox-hub speak it: how a stream of
// bytes falls into frames. Pure: it looks at nothing but its arguments.
//
//     client -> hub                              hub -> client
//     hello    0x287617fb version                hello    0x287617fa version
//     publish  1 size CHANNEL size DATA          publish  1 size CHANNEL size DATA
//     subscribe    2 size PATTERN
//     unsubscribe  3 size PATTERN
//
// Every number has 32 bits and is big-endian; nothing ends in NUL. A pattern is a channel's name or
// a regular expression that the whole name must match. The hub does not answer a subscription.
#ifndef SOBOX_COMMON_WIRE_FRAME_H
#define SOBOX_COMMON_WIRE_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    FRAME_HELLO_SIZE = 8,                    // [bytes]
    FRAME_CHANNEL_MAX = 63,                  // [bytes] LCM's own limit for the name of a channel
    FRAME_PATTERN_MAX = 255,                 // [bytes] of a subscription; LCM states none
    FRAME_HEAD_MAX = 12 + FRAME_CHANNEL_MAX, // [bytes] of a publish frame before its data
};

enum frame_side { FRAME_CLIENT, FRAME_HUB };

enum frame_type { FRAME_PUBLISH = 1, FRAME_SUBSCRIBE = 2, FRAME_UNSUBSCRIBE = 3 };

// What a frame says; the pointers lead into the bytes that were read.
struct frame {
    enum frame_type type;
    const char *name;    // of the channel, or the pattern; no NUL at its end
    size_t name_size;    // [bytes] 1 .. FRAME_CHANNEL_MAX or FRAME_PATTERN_MAX
    const uint8_t *data; // of FRAME_PUBLISH
    size_t data_size;    // [bytes]
    size_t size;         // of the whole frame [bytes]; with FRAME_CUT: at least so many are needed
};

enum frame_result {
    FRAME_WHOLE, // the frame is filled in
    FRAME_CUT,   // it goes on behind the bytes that are there
    FRAME_LARGE, // more data than allowed: name and size are filled in, and that many bytes to skip
    FRAME_WRONG, // no such frame: nothing that follows can be understood
};

// How each side begins.
void frame_hello(enum frame_side side, uint8_t bytes[FRAME_HELLO_SIZE]);

// Whether that side begins like this. LCM's clients do not look at the version, nor is it looked at
// here: there has been one.
bool frame_is_hello(enum frame_side side, const uint8_t bytes[FRAME_HELLO_SIZE]);

// Reads the frame at the front of `size` bytes from `side`. `data_max` is the most data that a
// message may have [bytes]. A name with a NUL in it is wrong, and so is a subscription of a hub.
enum frame_result frame_read(enum frame_side side, const uint8_t *bytes, size_t size,
                             size_t data_max, struct frame *frame);

// Writes what stands before the data of a publish frame, or a whole frame of another type, where
// `data_size` is not looked at; returns its size. `bytes` has room for 12 bytes and the name.
size_t frame_head(uint8_t *bytes, enum frame_type type, const char *name, size_t name_size,
                  size_t data_size);

#endif
