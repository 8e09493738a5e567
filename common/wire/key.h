// The key that the programs of one network share, and the file it is kept in:
//
//     sobox-key 1 (secret: whoever has it can take part)
//     5f0c...64 hexadecimal digits
//
// Two short lines of text, so that it can be copied by any means that keeps a secret. Only its
// owner may read the file (mode 0600). In memory the key lies on locked pages of its own that are
// left out of core dumps and wiped when it goes.
#ifndef SOBOX_COMMON_WIRE_KEY_H
#define SOBOX_COMMON_WIRE_KEY_H

#include "common/base/error.h"

#include <stdint.h>

enum {
    KEY_SIZE = 32,      // [bytes]
    KEY_NAME_SIZE = 10, // [bytes] of a name with its NUL: "1f3a-90bc"
};

struct key {
    uint8_t bytes[KEY_SIZE];
};

// Draws a key and writes it to a new file with mode 0600. Libsodium must have been initialised
// (sodium_init).
// Errors: STATUS_INVALID (a file is there already: it is never overwritten), STATUS_IO.
enum status key_write_new(const char *path, struct error *error) MUST_USE;

// Reads a key file; the caller releases the key with key_free(). A link is followed, and the file
// it leads to judged. Initialises libsodium. Errors: STATUS_INVALID with what would be right (no
// such file, not a regular one, readable by others, somebody else's, not a key), STATUS_FAILED (no
// memory for secrets).
enum status key_read(struct key **key, const char *path, struct error *error) MUST_USE;

// Wipes and releases it. NULL is fine.
void key_free(struct key *key);

// A key of these bytes, for tests and for those who have it from elsewhere. NULL without memory.
struct key *key_create(const uint8_t bytes[KEY_SIZE]);

// A short name by which people can see whether two programs have the same key; it tells nothing
// else about it. Returns `text`.
const char *key_name(const struct key *key, char text[KEY_NAME_SIZE]);

#endif
