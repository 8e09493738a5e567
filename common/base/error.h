// A message for a person, handed down by the caller and filled where something goes wrong. It says
// where, what, and what would be right; outer layers add their context in front:
//
//     front.yaml:14:9: vehicle.mass: expected more than 0 kg, found -3
#ifndef SOBOX_COMMON_BASE_ERROR_H
#define SOBOX_COMMON_BASE_ERROR_H

#include "common/base/status.h"

enum { ERROR_TEXT_SIZE = 1024 }; // [bytes] longer messages are cut, never overrun

struct error {
    enum status status; // STATUS_OK while nothing went wrong
    char text[ERROR_TEXT_SIZE];
};

// Fills the error, replacing what it held, and returns `status`, so that a function can end with
// `return error_set(error, STATUS_IO, "%s: %s", path, strerror(errno));`. `error` may be NULL.
enum status error_set(struct error *error, enum status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Puts "context: " in front of the message that is there. Returns the error's status.
enum status error_wrap(struct error *error, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
