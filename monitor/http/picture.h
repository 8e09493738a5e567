// The feed as JSON for a browser: first everything, then what changed since. Each reader has a
// cursor, so a slow one skips what is out of date and costs nobody anything.
//
// One event is an object; every member but "now" may be missing, which means "as before":
//
//   now        seconds on the monitor's clock; every *_at below is on the same clock
//   reset      true: forget everything known so far, this event is complete
//   monitor    {version, instance, source}: with reset only
//   runs       [{id, name, state, searches, searches_done, workers, workers_refused, samples,
//              batches, released, duplicates, rejected, lost, rate, elapsed_s, left_s, heard_at}]
//   searches   [{run, search, phase, status, step, step_count, evaluations, good_share, log_volume,
//              purity_lower95, heard_at}]
//   workers    [{id, name, threads, queue, batches, samples, rate, busy, lost, dropped, left,
//              heard_at}]
//   problems   [{kind, run, text}]: the whole list
//   own        {received, lost, dropped, rejected}
//   chosen     what the reader has chosen to see in detail:
//     run, search
//     state    as an element of searches
//     scenario {name, model, variables: [{name, lower, upper, spring, direction, deformation_m}],
//              springs: [name]}: once; null while not known
//     bounds   {lower, upper}: of the current box, in the order of the variables
//     steps    {from, points: [[step, phase, good_share, log_volume]]}: replaces all from `from` on
//     pace     {from, points: [[elapsed_s, rate, lost_share, released]]}, likewise
//     samples  {changed, steps: [[step, phase]]}: of which steps there are samples (xray.h); asked
//              for by themselves, because which variables are looked at is the reader's own choice
//     cases    {axes: ["case", path, ..], cases: [[search, name, value, ..]]}: of a sweep, those
//              that are new to the reader
//
// Numbers are those of the messages (SI); those beyond any measure are null; 64-bit numbers that
// name something are hexadecimal text, because a browser's numbers are doubles.
#ifndef SOBOX_MONITOR_HTTP_PICTURE_H
#define SOBOX_MONITOR_HTTP_PICTURE_H

#include "monitor/feed/feed.h"
#include "monitor/texts/texts.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

// What is shown, and who shows it. All borrowed.
struct picture_view {
    const struct feed *feed;
    struct texts *texts;
    const char *source;   // the network's URL or the run folder
    const char *instance; // random, new at every start of the monitor
    int64_t start_ns;     // zero of the clock of the events
    // Called when a reader has chosen a search whose scenario is not known.
    void (*want)(void *user, uint64_t run, const struct digest *scenario);
    // Called when a reader has chosen a search: its samples are wanted. NULL: they come by
    // themselves.
    void (*want_samples)(void *user, uint64_t run, uint32_t search);
    void *user;
};

struct picture_course {
    uint32_t rewrites;
    guint sent;
};

// How far a reader is. Zeroed: it knows nothing.
struct picture_cursor {
    bool has_run, has_search; // what it has chosen
    uint64_t run;
    uint32_t search;

    bool started;
    uint64_t removed;
    uint64_t version;        // of the feed when it was last told all
    int64_t tables_ns;       // when it was last told of runs, searches and workers
    int64_t told_ns;         // when it was last told anything
    uint64_t chosen_version; // of the chosen search or run when last told
    bool scenario_told;
    uint64_t album_version, cases_version; // when it was last told of samples and of cases
    struct picture_course steps, pace;
};

// Lists change for readers at most so often, what is chosen so often. [ns]
#define PICTURE_TABLES_NS INT64_C(1000000000)
#define PICTURE_CHOSEN_NS INT64_C(180000000)

// Whether there is something to tell the reader now: news, or that there is none.
bool picture_due(const struct picture_view *view, const struct picture_cursor *cursor,
                 int64_t now_ns);

// Tells the reader: appends the event as one line of JSON and moves the cursor.
void picture_event(const struct picture_view *view, struct picture_cursor *cursor, int64_t now_ns,
                   GString *out);

#endif
