// Whether a sealed message is new, or one that was recorded and is played again. A key alone does
// not tell: what was sealed with it an hour ago opens as well now. No clocks need to agree for
// this.
//
// Each wire draws a random challenge. A sender is *proven* to a receiver once the receiver has
// heard its own challenge come back in one of the sender's sealed messages: that message, and
// whatever has a greater number, was made after the receiver began to listen. From then on each
// number is taken once. Until then messages are held, and the sender asked (hail_t):
//
//      receiver                                            sender
//         |  <------------- message 41 --------------------   |   unknown sender: held
//         |  ------- hail: my challenge is C, prove it ---->  |
//         |  <------ hail 42: here is C --------------------  |   proven from 42 on; 41 is dropped
//         |  <------------- status 43, restated ------------  |   taken
//
// It costs one round trip a pair, a tenth of a millisecond, at the first message. What was sent
// between the proof and its arrival may come first, on another port: such messages were held with a
// greater number and are handed on then. What has no greater number was perhaps sent before the
// receiver began, so it is dropped; the sender says its state again instead.
//
// A sender that does not answer is a recording, or does not hear this machine. What it sent is
// refused after FRESH_PATIENCE_NS.
//
// Pure but for the random challenge: time comes in as an argument. Memory is bounded: when the
// oldest proven sender has to go, the challenge is drawn anew, so that its recorded proof is void.
#ifndef SOBOX_COMMON_WIRE_FRESH_H
#define SOBOX_COMMON_WIRE_FRESH_H

#include "common/wire/seal.h"
#include "common/wire/wire.h"

enum {
    FRESH_CHALLENGE_SIZE = 16,  // [bytes]
    FRESH_PROVEN_MAX = 4096,    // senders; 1 KB each
    FRESH_WAITING_MAX = 512,    // senders asked; the one unheard longest makes room
    FRESH_HELD_MAX = 256,       // messages held of one sender
    FRESH_HELD_BYTES = 1 << 20, // [bytes] held of all
    // Numbers behind the greatest of a kind within which late ones are taken. A jitter of 10 ms at
    // 80,000 messages a second needs 800.
    FRESH_WINDOW = 960,
};

// The sender is asked again when it is heard so much later and has not answered. [ns]
#define FRESH_ASK_NS INT64_C(100000000)
// So long a message is held. [ns]
#define FRESH_PATIENCE_NS INT64_C(2000000000)

enum fresh_result {
    FRESH_NEW,      // of a proven sender, heard for the first time
    FRESH_OLD,      // heard before, or sent before the sender was proven, or far too late
    FRESH_UNPROVEN, // its sender is not proven: hold it
};

// A message that was held: decrypted, as encoded.
struct fresh_message {
    struct seal_origin origin;
    enum wire_kind kind;
    int64_t held_ns;
    size_t size;
    uint8_t bytes[]; // (size)
};

struct fresh;

struct fresh *fresh_create(void);
void fresh_free(struct fresh *fresh); // NULL is fine

// This receiver's challenge (FRESH_CHALLENGE_SIZE bytes). It may change with fresh_prove().
const uint8_t *fresh_challenge(const struct fresh *fresh);

// Judges an opened message of `kind`, and marks its number as heard when it is FRESH_NEW.
enum fresh_result fresh_hear(struct fresh *fresh, enum wire_kind kind,
                             const struct seal_origin *origin);

// Keeps a copy of a FRESH_UNPROVEN message. Returns whether its sender is to be asked now.
bool fresh_hold(struct fresh *fresh, enum wire_kind kind, const struct seal_origin *origin,
                const uint8_t *bytes, size_t size, int64_t now_ns);

// The message `origin` has brought the challenge back: its sender is proven from there on. Its held
// messages become available to fresh_release().
void fresh_prove(struct fresh *fresh, const struct seal_origin *origin);

// The next message that was held and whose sender has been proven, for the caller to judge with
// fresh_hear() and to release with g_free(); NULL when there is none.
struct fresh_message *fresh_release(struct fresh *fresh);

// Refuses what has been held too long.
void fresh_expire(struct fresh *fresh, int64_t now_ns);

// Messages refused so far because their sender was never proven.
uint64_t fresh_refused(const struct fresh *fresh);

#endif
