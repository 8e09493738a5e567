// A file, or what comes through a pipe, in pieces of whole lines: as much as is worked on at once,
// however long it is. Where the pieces end depends on the bytes alone, never on how they arrived,
// so that a piece is the same when the file is read again.
//
//     source_open() -> source_header() -> source_fill(), source_piece(), source_fill(), ...
#ifndef SOBOX_COORDINATOR_EVALUATION_SOURCE_H
#define SOBOX_COORDINATOR_EVALUATION_SOURCE_H

#include "common/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    SOURCE_PIECE_SIZE = 1 << 20,  // [bytes] a piece is not longer, nor may a line be
    SOURCE_PIECE_LINES = 1 << 14, // nor has it more lines
};

struct source;

// Whole lines, the first of which is `line`.
struct source_piece {
    char *text;    // (size) not terminated; to be freed with g_free()
    size_t size;   // [bytes] > 0
    uint64_t line; // from 1
    uint64_t end;  // bytes of the source up to the end of the piece
};

// Opens the file, or standard input for "-". Errors: STATUS_INVALID (no such file).
enum status source_open(struct source **source, const char *path, struct error *error) MUST_USE;
void source_close(struct source *source);

// What stands for it in messages: the path, or "standard input".
const char *source_name(const struct source *source);

// Reads up to the end of the first line that is neither blank nor a comment (#), which becomes the
// piece; lines in front of it count, but are left out. Blocks until it is there. A byte order mark
// is skipped. Errors: STATUS_INVALID (there is none; it is too long), STATUS_IO.
enum status source_header(struct source *source, struct source_piece *header,
                          struct error *error) MUST_USE;

// Reads what is there, once: blocks only when nothing is, so wait for the descriptor before.
// Errors: STATUS_IO.
enum status source_fill(struct source *source, struct error *error) MUST_USE;
int source_descriptor(const struct source *source);

// Gives the next piece if it is there; else text is NULL: fill again, or, when it has ended,
// nothing more comes. Errors: STATUS_INVALID (a line is too long).
enum status source_piece(struct source *source, struct source_piece *piece,
                         struct error *error) MUST_USE;

// Whether all has been given.
bool source_ended(const struct source *source);

// Bytes of the whole file; 0 where that is not known, as of a pipe.
uint64_t source_size(const struct source *source);

#endif
