// The progress line: where the run is, how fast it goes, who works on it; of a sweep how many
// searches are done, running and waiting, and how long they will take.
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

// "123", "12.3 k", "4.56 M". Returns `text`.
const char *progress_number(double value, char text[16]);

// "12 s", "34 min", "5.6 h", "7.8 days". Returns `text`.
const char *progress_duration(double seconds, char text[32]);

// Ends the line so that what follows starts on a fresh one.
void progress_end(struct progress *progress);

#endif
