// What happens in a storm, a line each, when asked for with --trace; and the end of the program
// when something happens that must not.
#ifndef SOBOX_TESTS_CLUSTER_TRACE_H
#define SOBOX_TESTS_CLUSTER_TRACE_H

#include <stdbool.h>
#include <stdint.h>

// From now on it is storm `seed`; says whether lines are wanted.
void trace_start(uint64_t seed, bool wanted);

// A line: time, who, what.
void trace_line(int64_t now_ns, const char *who, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Ends the program with the seed and the reason, and how to watch it again.
_Noreturn void trace_fail(int64_t now_ns, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// A fact about the cluster, checked in every build: fails with its own text.
#define TRACE_CHECK(now_ns, fact)                                                 \
    do {                                                                          \
        if (!(fact))                                                              \
            trace_fail(now_ns, "expected %s (%s:%d)", #fact, __FILE__, __LINE__); \
    } while (0)

#endif
