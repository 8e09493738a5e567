// A text put together from the pieces in which it travels: any order, any cut, some twice, some
// lost. It trusts nothing that it is given and takes no more memory than the text is long, plus a
// list of the parts it has.
//
//      0        1400      2800      4200       size
//      |########|         |#########|          |
//               ^ text_missing(): what to ask for next
#ifndef SOBOX_WORKER_BATCH_TEXT_H
#define SOBOX_WORKER_BATCH_TEXT_H

#include <stdint.h>

enum {
    // Parts that are apart from each other, at most: a text of 1 MiB in pieces of one Ethernet
    // frame
    // of which every second one was lost has 400. A piece that would make more is ignored.
    TEXT_PART_MAX = 512,
};

struct text_part {
    uint32_t begin; // first byte
    uint32_t end;   // one past the last
};

struct text {
    uint8_t *bytes;          // (size) NULL before the first piece
    uint32_t size;           // of the whole text [bytes]
    struct text_part *parts; // (part_count) ascending, not touching each other
    uint32_t part_count;
};

enum text_progress {
    TEXT_NOTHING, // the piece brought nothing new
    TEXT_MORE,    // it did; others are missing
    TEXT_GAP,     // it was new and the last one of the text; earlier ones are missing
    TEXT_WHOLE,   // nothing is missing
};

// Forgets all pieces and releases their memory. A zeroed struct is an empty text.
void text_clear(struct text *text);

// Takes in bytes offset .. offset + size - 1 of a text of `total` bytes: 0 < size,
// offset + size <= total. A `total` that differs from that of the pieces before starts anew: one of
// the two is wrong, and only the digest of the whole will tell which.
enum text_progress text_piece(struct text *text, uint32_t total, uint32_t offset,
                              const uint8_t *piece, uint32_t size);

// The first byte that is missing.
uint32_t text_missing(const struct text *text);

#endif
