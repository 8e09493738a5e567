// Whether a sealed message is new, or one that was recorded and is played again. A key alone does
// not tell: what was sealed with it an hour ago opens as well now. No clocks need to agree for
// this.
//
// Each wire draws a random challenge. A sender is *proven* to a receiver once the receiver has
// heard its own challenge come back in one of the sender's sealed messages. The question says how
// old the challenge is; the sender looks up by its own clock which of its messages are younger, and
// answers with the number below them, the floor. From then on each greater number is taken once.
// Until then messages are held, and the sender is asked (hail_t):
//
//      receiver                                             sender
//         |  <-------------- message 41 --------------------   |   unknown sender: held
//         |  -- hail: my challenge, 3 s old, is C: prove it ->  |
//         |  <- hail 42: C; what is above 38 is younger ------  |   proven: 41 is handed on
//         |  <-------------- message 43 --------------------   |   taken
//
// It costs one round trip a pair, some hundredth of a millisecond, at the first message. Rule: what
// is handed on comes from a sender that is there, was sent after its receiver began to listen (or
// within DOOR_SLACK_NS before), and is handed on once. A question or an answer that comes late only
// makes it stricter.
//
// A sender that does not answer is a recording, or does not hear this machine. It is asked again
// until what it sent has been held for FRESH_PATIENCE_NS and is refused.
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

// A sender whose messages are held is asked again after so long. [ns]
#define FRESH_ASK_NS INT64_C(50000000)
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

struct fresh *fresh_create(int64_t now_ns);
void fresh_free(struct fresh *fresh); // NULL is fine

// This receiver's challenge (FRESH_CHALLENGE_SIZE bytes). It may change with fresh_prove().
const uint8_t *fresh_challenge(const struct fresh *fresh);

// How old it is. [ns]
int64_t fresh_age_ns(const struct fresh *fresh, int64_t now_ns);

// Judges an opened message of `kind`, and marks its number as heard when it is FRESH_NEW.
enum fresh_result fresh_hear(struct fresh *fresh, enum wire_kind kind,
                             const struct seal_origin *origin);

// Keeps a copy of a FRESH_UNPROVEN message until its sender is proven, and refuses what has been
// held too long.
void fresh_hold(struct fresh *fresh, enum wire_kind kind, const struct seal_origin *origin,
                const uint8_t *bytes, size_t size, int64_t now_ns);

// The next sender to be asked for a proof, marked as asked now; 0 when there is none. Call it until
// it says so, after fresh_hold() and at fresh_wake_ns().
uint64_t fresh_ask(struct fresh *fresh, int64_t now_ns);

// When somebody is to be asked again or something refused; INT64_MAX while nothing is held.
int64_t fresh_wake_ns(const struct fresh *fresh);

// The message `origin`, a WIRE_HAIL, has brought the challenge back and says that numbers up to
// `floor` are older: its sender is proven. Its held messages become available to fresh_release().
void fresh_prove(struct fresh *fresh, const struct seal_origin *origin, uint64_t floor,
                 int64_t now_ns);

// The next message that was held and whose sender has been proven, for the caller to judge with
// fresh_hear() and to release with g_free(); NULL when there is none.
struct fresh_message *fresh_release(struct fresh *fresh);

// Refuses what has been held too long.
void fresh_expire(struct fresh *fresh, int64_t now_ns);

// Messages refused so far because their sender was never proven.
uint64_t fresh_refused(const struct fresh *fresh);

#endif
