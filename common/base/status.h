// What a function that deals with the world returns: STATUS_OK or the kind of thing that went
// wrong. The sentence for a person travels beside it in a struct error (error.h).
#ifndef SOBOX_COMMON_BASE_STATUS_H
#define SOBOX_COMMON_BASE_STATUS_H

// Name and short text of every status; the enum and status_text() are made from this one list.
#define STATUS_LIST(X)                        \
    X(STATUS_OK, "done")                      \
    X(STATUS_INVALID, "the input is invalid") \
    X(STATUS_IO, "reading or writing failed") \
    X(STATUS_NETWORK, "the network failed")   \
    X(STATUS_REFUSED, "refused")              \
    X(STATUS_INTERRUPTED, "interrupted")      \
    X(STATUS_FAILED, "failed")

enum status {
#define STATUS_ENUM(name, text) name,
    STATUS_LIST(STATUS_ENUM)
#undef STATUS_ENUM
};

// Marks a function whose result must be looked at.
#define MUST_USE __attribute__((warn_unused_result))

// Exit statuses of every sobox program (design: "Programs and files").
enum exit_status {
    EXIT_STATUS_DONE = 0,
    EXIT_STATUS_FAILED = 1,         // failed while running
    EXIT_STATUS_INVALID = 2,        // usage or invalid input
    EXIT_STATUS_NO_GOOD_DESIGN = 3, // finished, but no good design was found
    EXIT_STATUS_INTERRUPTED = 130,  // interrupted; can be resumed
};

// The short text of a status, for instance "reading or writing failed".
const char *status_text(enum status status);

// The exit status with which a program ends after this status.
enum exit_status status_exit(enum status status);

#endif
