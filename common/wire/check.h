// From received bytes to a message that can be trusted to be well-formed, or the reason why not.
// Pure: it looks at nothing but its arguments.
//
//     0        8                32                 size - 16 - array      size - 16    size
//     +--------+----------------+------------------+----------------------+------------+
//     | finger | header: proto- | fixed fields ... | array: count x unit  | tag        |
//     | print  | col, sequence, |      last: count |                      |            |
//     |        | sender, run    |                  |                      |            |
//     +--------+----------------+------------------+----------------------+------------+
//
// Every message is laid out like this (fixed-size fields, then one count and one array, or no
// array), so size and count can be held against each other before a generated decoder sees the
// bytes: the decoders of LCM believe the count and can be crashed by it.
#ifndef SOBOX_COMMON_WIRE_CHECK_H
#define SOBOX_COMMON_WIRE_CHECK_H

#include "common/wire/codec.h"
#include "common/wire/tag.h"

// What came of a check; all but CHECK_GOOD and CHECK_FOREIGN are reasons to reject.
#define CHECK_LIST(X)                                         \
    X(CHECK_GOOD, "good")                                     \
    X(CHECK_FOREIGN, "of another protocol version")           \
    X(CHECK_SIZE, "a size that its channel does not have")    \
    X(CHECK_TYPE, "another type than its channel's")          \
    X(CHECK_TAG, "a tag that is not its own")                 \
    X(CHECK_COUNT, "a count that its size does not bear out") \
    X(CHECK_FIELD, "a field out of its range")

enum {
    // [bytes] A message of another protocol version has at least fingerprint, header and tag; one
    // without an array is small in every version.
    CHECK_FOREIGN_SIZE_MIN = 8 + 24 + TAG_SIZE,
    CHECK_FOREIGN_SIZE_MAX = 4096,
};

enum check_result {
#define CHECK_ENUM(name, text) name,
    CHECK_LIST(CHECK_ENUM)
#undef CHECK_ENUM
};

// The layout of a kind.
struct check_kind {
    const char *channel;
    unsigned port;     // 0 batches, 1 outcomes, 2 status
    size_t fixed_size; // [bytes] fingerprint, header and fixed fields, the count among them
    size_t unit;       // [bytes] of one element of the array; 0: no array
    int32_t count_max; // elements
};

const struct check_kind *check_kind(enum wire_kind kind);

// The greatest and the least size of a message of the kind, with its tag. [bytes]
size_t check_size_max(enum wire_kind kind);
size_t check_size_min(enum wire_kind kind);

// Checks the `size` bytes received in clear on the kind's channel in this order: size, protocol,
// fingerprint, tag, count, then decodes and checks every field. CHECK_GOOD fills `message`, which
// the caller releases with codec_release(); everything else leaves nothing to release. For
// CHECK_FOREIGN (the tag is right, so it is no damage, but the protocol is another)
// `message->header` is filled.
enum check_result check_packet(enum wire_kind kind, const uint8_t *bytes, size_t size,
                               union codec_message *message);

// The same for an encoded message without its tag, whose origin is proven otherwise: what was in a
// sealed envelope (seal.h). A key proves who made a message, not that it is well-formed.
enum check_result check_encoded(enum wire_kind kind, const uint8_t *bytes, size_t size,
                                union codec_message *message);

// Whether every field of `message` (the type of `kind`) but protocol and sequence has a value that
// its .lcm file allows. Used on both sides: what is not valid is not sent either.
bool check_fields(enum wire_kind kind, const void *message);

const char *check_result_text(enum check_result result);

#endif
