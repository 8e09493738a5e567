// A run as its journal tells it, in place of a network: what the journal holds is turned into the
// status messages that the coordinator would have sent, step by step, and goes into the feed by the
// same door. A run that goes on is read again as its journal grows.
//
// A journal knows nothing of workers, losses and the time of each step: those stay empty.
#ifndef SOBOX_MONITOR_RECORD_RECORD_H
#define SOBOX_MONITOR_RECORD_RECORD_H

#include "common/base/error.h"
#include "monitor/feed/feed.h"
#include "monitor/texts/texts.h"

#include <stdbool.h>
#include <stdint.h>

struct record;

// A record of the run folder. `feed` and `texts` are borrowed until record_close().
struct record *record_open(const char *folder, struct feed *feed, struct texts *texts);
void record_close(struct record *record); // NULL is fine

// Tells the feed what is new in the journal.
// Errors: those of journal_open() and its readers.
enum status record_read(struct record *record, int64_t now_ns, struct error *error) MUST_USE;

// Tells the feed of the samples of a search that somebody looks at, as far as they are new. They
// are read when they are wanted: a sweep has more than anybody wants to keep. Errors: likewise.
enum status record_read_samples(struct record *record, uint32_t search, int64_t now_ns,
                                struct error *error) MUST_USE;

// Whether the run was still going on when it was last read.
bool record_goes_on(const struct record *record);

#endif
