// The progress line: where the run is, how fast it goes, who works on it.
#ifndef SOBOX_COORDINATOR_RUNTIME_PROGRESS_H
#define SOBOX_COORDINATOR_RUNTIME_PROGRESS_H

#include "coordinator/runtime/run.h"
#include "coordinator/schedule/schedule.h"

// What was shown last, for rates. Zeroed at the start.
struct progress {
    int64_t shown_ns;
    uint64_t shown_samples;
};

void progress_show(struct progress *progress, const struct run *run,
                   const struct schedule_counters *counters, int64_t now_ns);

// Ends the line so that what follows starts on a fresh one.
void progress_end(struct progress *progress);

#endif
