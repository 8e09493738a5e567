// Files that are whole or absent: read at once, and written beside their place, then renamed into
// it.
//
// What is no regular file is written to as it is: a rename would put a file where a device was, and
// whoever says /dev/stdout or a pipe wants what is behind it. Behind a symbolic link the file that
// it leads to is replaced, and the link stays.
#ifndef SOBOX_COMMON_BASE_WHOLE_FILE_H
#define SOBOX_COMMON_BASE_WHOLE_FILE_H

#include "common/base/error.h"

#include <stddef.h>
#include <stdio.h>

// Reads a file, but at most `size_max` + 1 bytes of it: the one byte more tells a file that is too
// long, even one that never ends. The text is released with g_free(). Errors: NULL, with `error`
// filled (STATUS_INVALID): to the user a file that cannot be read is wrong input like any other.
char *whole_file_read(const char *path, size_t size_max, size_t *size, struct error *error);

// Writes `size` bytes as the file `path`, replacing one that is there. Errors: STATUS_IO.
enum status whole_file_write(const char *path, const void *bytes, size_t size,
                             struct error *error) MUST_USE;

// A file that is written piece by piece.
struct whole_file {
    FILE *file; // to be written to, NULL before begin and after end
    char *path;
    char *beside; // what is written until it is whole; NULL: the path itself
};

// Errors: STATUS_IO; the struct is zeroed then.
enum status whole_file_begin(struct whole_file *whole, const char *path,
                             struct error *error) MUST_USE;

// Puts the file in its place if `status` is STATUS_OK and all was written; else removes it. Returns
// `status`, or STATUS_IO. A zeroed struct is fine.
enum status whole_file_end(struct whole_file *whole, enum status status,
                           struct error *error) MUST_USE;

#endif
