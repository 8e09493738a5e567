// Losses, told from the gaps in the senders' sequence numbers.
//
// Every sender numbers its messages of each kind 0, 1, 2, ... wrapping at 2^32. What lies between
// the greatest number heard and the first is expected; what of it has not come is lost. A message
// that comes late, within the last SEQUENCE_WINDOW numbers, takes its loss back; one that comes
// twice counts once; a sender's first message starts its count, wherever its numbers stand.
#ifndef SOBOX_COMMON_WIRE_SEQUENCE_H
#define SOBOX_COMMON_WIRE_SEQUENCE_H

#include "common/wire/wire.h"

enum {
    SEQUENCE_SENDERS_MAX = 4096, // remembered; the one silent longest is forgotten for a new one
    SEQUENCE_WINDOW = 64,        // numbers behind the greatest within which a late one is known
    // A leap beyond this is no loss but a sender that numbers otherwise: counting starts anew.
    SEQUENCE_LEAP_MAX = 1 << 24,
};

struct sequence;

struct sequence *sequence_create(void);
void sequence_free(struct sequence *sequence); // NULL is fine

// A message was heard.
void sequence_hear(struct sequence *sequence, uint64_t sender, enum wire_kind kind,
                   uint32_t number);

// Messages lost so far, over all senders and kinds, those of forgotten senders among them.
uint64_t sequence_lost(const struct sequence *sequence);

// Senders remembered, at most SEQUENCE_SENDERS_MAX.
size_t sequence_senders(const struct sequence *sequence);

#endif
