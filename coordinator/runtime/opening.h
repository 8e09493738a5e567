// When another search of a sweep is opened. Open searches cost memory and waiting ones none, so as
// few are open as keep every worker busy, and those follow from what is seen:
//
//     samples wait to be handed out   every worker has all it may hold: no more are needed
//     none wait                       somebody is idle or soon will be: one more
//     the trimming threads lag        more searches would only wait there
//     the memory is spent             what is open may grow into it
//
// With slow models and many workers that is thousands of searches, with fast ones a few dozen.
#ifndef SOBOX_COORDINATOR_RUNTIME_OPENING_H
#define SOBOX_COORDINATOR_RUNTIME_OPENING_H

#include "common/scenario/scenario.h"
#include "coordinator/schedule/schedule.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    // Searches open at once. Each has a scenario of its own, and a worker that is to know more of
    // them than it keeps (PROTOCOL_SCENARIO_MAX) would fetch one for every batch: another
    // coordinator
    // with the same workers may have as many.
    OPENING_MAX = 4000,
    // Searches that may be open whatever memory they take: with fewer a step of one could not be
    // sampled while another is trimmed.
    OPENING_LEAST = 4,
    // Steps waiting for or in the hands of each trimming thread: one more than it works on.
    OPENING_TRIMS_MAX = 2,
};

// What is open.
struct opening {
    uint64_t memory_size;   // that open searches may take [bytes]
    uint64_t open_size;     // that they will have taken at their ends [bytes], see opening_size()
    uint64_t greatest_size; // the greatest of any so far
    uint32_t open_count;
};

// Nothing is open; a quarter of the machine's memory may be taken.
struct opening opening_default(void);

// What a search of the scenario takes at its end, about [bytes]: the bad samples it knows.
uint64_t opening_size(const struct scenario *scenario);

// A search was opened, or closed.
void opening_open(struct opening *opening, const struct scenario *scenario);
void opening_close(struct opening *opening, const struct scenario *scenario);

// Whether another one should be opened. `trims` are waiting or in work for each trimming thread.
bool opening_wanted(const struct opening *opening, const struct schedule_counters *counters,
                    double trims);

#endif
