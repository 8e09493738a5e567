// Listening to a network: what is heard goes into a feed, scenarios that are wanted are asked for.
//
// A monitor listens on the status port alone. Texts travel on the port of the batches, where every
// listener costs the coordinator's machine something, so the monitor listens there only while it
// asks for one: some milliseconds a run.
#ifndef SOBOX_MONITOR_WATCH_WATCH_H
#define SOBOX_MONITOR_WATCH_WATCH_H

#include "common/base/error.h"
#include "common/wire/key.h"
#include "monitor/feed/feed.h"
#include "monitor/texts/texts.h"

struct watch;

// Listens on the default main context from now on. `feed`, `texts` and `key` (NULL: none) are
// borrowed until watch_stop().
// Errors: those of wire_open() and wire_subscribe().
enum status watch_start(struct watch **watch, const char *url, const struct key *key,
                        struct feed *feed, struct texts *texts, struct error *error) MUST_USE;

// NULL is fine.
void watch_stop(struct watch *watch);

// Asks for the scenario of a run's search if it is not known.
void watch_want(struct watch *watch, uint64_t run, const struct digest *scenario);

// Tells the feed how well the monitor hears. Once a second or so.
void watch_count(struct watch *watch, int64_t now_ns);

#endif
