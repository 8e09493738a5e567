// The two clocks. Durations and deadlines use the monotonic one; dates for people the other.
// Only the runtime folders read a clock: everything else is told the time.
#ifndef SOBOX_COMMON_BASE_CLOCK_H
#define SOBOX_COMMON_BASE_CLOCK_H

#include <stdint.h>

#define CLOCK_SECOND_NS INT64_C(1000000000)
#define CLOCK_MILLISECOND_NS INT64_C(1000000)

// Nanoseconds since an arbitrary moment; never goes back.
int64_t clock_monotonic_ns(void);

// Nanoseconds since 1970-01-01T00:00:00Z.
int64_t clock_calendar_ns(void);

#endif
