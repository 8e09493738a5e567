// What a monitor knows: the runs, searches and workers it has heard of, from the status messages
// alone. Pure: messages and time come in, the picture is read out (problem.h says what is wrong in
// it). It only listens, so any number of monitors may come and go without a run noticing.
//
// Everything is bounded, and a message costs the same however much is known: entries are found by
// key (table.h), courses over time thin themselves out (history.h).
//
// Messages may be lost, doubled and late. One that is older than what is shown is dropped; who
// reads the feed never sees a run turn back, but where its coordinator was started anew.
#ifndef SOBOX_MONITOR_FEED_FEED_H
#define SOBOX_MONITOR_FEED_FEED_H

#include "common/numeric/digest.h"
#include "common/protocol/protocol.h"
#include "monitor/feed/album.h"
#include "monitor/feed/cases.h"
#include "monitor/feed/history.h"
#include "monitor/feed/table.h"

#include "sobox_cases_t.h"
#include "sobox_run_status_t.h"
#include "sobox_search_status_t.h"
#include "sobox_step_status_t.h"
#include "sobox_worker_status_t.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    FEED_RUN_MAX = 64,
    FEED_SEARCH_MAX = 16384, // of all runs
    FEED_WORKER_MAX = 4096,
    FEED_STEP_MAX = 512, // points of a search's course: with all searches at most 200 MB
    FEED_PACE_MAX = 600, // points of a run's course: ten minutes second by second
    FEED_ALBUM_MAX = 64, // searches whose samples are kept: those heard of last, at most 128 MB
};

// Who has not been heard for so long is silent: three status messages missed, where there are not
// so many workers that they speak less often (common/base/pace.h). [ns]
#define FEED_SILENCE_NS INT64_C(3000000000)
// A silent worker is forgotten after this time, one that said good-bye after the shorter. [ns]
#define FEED_FORGET_NS INT64_C(600000000000)
#define FEED_LEFT_NS INT64_C(30000000000)

// Which message an entry shows, so that older ones are known as such.
struct feed_origin {
    uint64_t sender, sender_before; // 0: none
    uint32_t sequence;
};

// Counts of the last ten seconds or so: they fade instead of ending, so that nothing jumps.
struct feed_recent {
    double received, lost, released;
};

struct feed_worker {
    struct table_entry entry; // key: its sender number
    uint64_t changed;         // feed->version when it was last heard
    char name[96];            // host/process
    struct digest fingerprint;
    uint32_t threads;
    uint32_t queue; // batches waiting and in work
    uint64_t batches, samples;
    double rate;          // samples a second, between its last two messages
    double busy;          // share of that time spent evaluating, 0 .. 1
    uint64_t lost;        // messages it knows it missed
    uint64_t dropped;     // datagrams its kernel dropped
    uint32_t buffer_size; // receive buffer its kernel granted [bytes]
    bool left;            // it said that it ends
    int64_t heard_ns;
    int64_t silence_ns;         // not heard for so long it is silent; thousands speak less often
    int64_t busy_ns, uptime_ns; // as it last said
    uint32_t idle;              // messages in a row that show it with nothing to do
    struct feed_recent recent;
    struct feed_origin origin;
};

// A point of a search's course.
struct feed_step {
    uint32_t step;
    enum search_phase phase;
    double good_share;
    double log_volume;
};

struct feed_search {
    struct table_entry entry; // keys: run and index
    uint64_t changed;
    uint64_t run;
    uint32_t index;
    struct digest scenario;
    enum search_standing standing;
    enum search_phase phase;
    enum search_status status;
    uint32_t step, step_count;
    uint64_t evaluations;
    double good_share;
    double log_volume;
    double purity_lower95; // 0 until certified
    GArray *bounds;        // double: lower, then upper; empty until all of the box is heard
    GArray *parts;         // the same of a box that comes in parts, NaN where none has come
    struct album *album;   // its samples; NULL: none are kept
    GQueue *albums;        // feed->albums,
    GList album_link;      // and its place there
    uint64_t album_changed;
    struct feed_origin album_origin;
    int64_t album_heard_ns;
    struct history steps; // struct feed_step, one a step heard of
    int64_t heard_ns;
    struct feed_origin origin;
};

// A point of a run's course.
struct feed_pace {
    double elapsed_s;
    double rate;       // samples a second
    double lost_share; // of the coordinator's messages, lately
    double released;   // batches handed out again, so far
};

struct feed_run {
    struct table_entry entry; // key: its number
    uint64_t changed;
    uint64_t id;
    char name[64];
    struct digest fingerprint; // of the coordinator's kernel
    enum run_state state;
    uint32_t searches, searches_done;
    uint32_t workers, workers_refused;
    uint64_t samples, batches, released, duplicates, rejected, lost;
    double rate; // samples a second, between its last two messages
    int64_t elapsed_ns, service_ns;
    int64_t heard_ns;
    struct history pace; // struct feed_pace, one a message
    struct cases names;  // of the cases of a sweep
    struct feed_recent recent;
    struct feed_origin origin;
};

// How well the monitor itself hears; all 0 where it hears nothing by nature.
struct feed_own {
    uint64_t received, rejected, foreign, unopened, lost, dropped;
    uint32_t buffer_size; // [bytes]
};

// Read-only to all but the functions below.
struct feed {
    struct table runs;     // struct feed_run
    struct table searches; // struct feed_search
    struct table workers;  // struct feed_worker
    GQueue albums;         // searches with samples; longest unheard first
    struct feed_own own;
    struct feed_recent own_recent;
    int64_t own_ns;
    uint64_t version; // grows with each change of the above
};

void feed_init(struct feed *feed);
void feed_fini(struct feed *feed);

// A message was heard at `now_ns` (monotonic). Nothing of it is kept but copies.
void feed_run_heard(struct feed *feed, const sobox_run_status_t *message, int64_t now_ns);
void feed_search_heard(struct feed *feed, const sobox_search_status_t *message, int64_t now_ns);
void feed_step_heard(struct feed *feed, const sobox_step_status_t *message, int64_t now_ns);
void feed_cases_heard(struct feed *feed, const sobox_cases_t *message, int64_t now_ns);
void feed_worker_heard(struct feed *feed, const sobox_worker_status_t *message, int64_t now_ns);

// The same from a run's journal, which tells each thing once and in order: there is no header and
// no doubling. `message` without its arrays, `box` in their place.
void feed_run_read(struct feed *feed, uint64_t run, const sobox_run_status_t *message,
                   int64_t now_ns);
void feed_search_read(struct feed *feed, uint64_t run, const sobox_search_status_t *message,
                      const struct box *box, int64_t now_ns);
// Takes `picture` over.
void feed_step_read(struct feed *feed, uint64_t run, uint32_t search, struct album_picture *picture,
                    int64_t now_ns);
// A row of cases_put().
void feed_case_read(struct feed *feed, uint64_t run, int32_t index, char *const *texts);

// How well this monitor hears, once a second or so.
void feed_own_counted(struct feed *feed, const struct feed_own *own, int64_t now_ns);

// Time passed: workers that are gone are forgotten.
void feed_tick(struct feed *feed, int64_t now_ns);

// The run or the search of a run, or NULL.
const struct feed_run *feed_run_find(const struct feed *feed, uint64_t run);
const struct feed_search *feed_search_find(const struct feed *feed, uint64_t run, uint32_t index);

// The i-th entry, in the order of first hearing.
const struct feed_run *feed_run_at(const struct feed *feed, guint i);
const struct feed_search *feed_search_at(const struct feed *feed, guint i);
const struct feed_worker *feed_worker_at(const struct feed *feed, guint i);

// Whether the run's coordinator should still be talking.
bool feed_run_active(const struct feed_run *run);

// Seconds that are left by the pace so far; negative where nothing can be said. [s]
double feed_run_left_s(const struct feed *feed, const struct feed_run *run);

// Of what was sent lately, the share that was lost, 0 .. 1.
double feed_recent_lost_share(const struct feed_recent *recent);

// The search's status in a word: that of its result, "running", "waiting" or "failed".
const char *feed_search_word(const struct feed_search *search);

// The name of a search's case, or NULL where it has none or none is heard.
const char *feed_case_name(const struct feed *feed, uint64_t run, uint32_t search);

#endif
