// Who works on what: the steps that searches want sampled, cut into batches, leased to workers, and
// counted once. A pure step machine: an event comes in with its time, effects go out as a list that
// the runtime carries out in order. It knows no clock and no network.
//
//            +---------+  lease   +--------+  outcome   +---------+
//   step --> | waiting | -------> | leased | ---------> | counted |
//            +---------+          +--------+            +---------+
//                 ^    lapsed, worker  |  ^  |  late: a copy to
//                 |    gone or silent  |  |  |  an idle worker
//                 +--------------------+  +--+
//
// An outcome counts once, whoever sends it and however late: what a batch gives depends on nothing
// but its identity.
#ifndef SOBOX_COORDINATOR_SCHEDULE_SCHEDULE_H
#define SOBOX_COORDINATOR_SCHEDULE_SCHEDULE_H

#include "common/numeric/verdict.h"
#include "common/protocol/protocol.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct schedule_settings {
    uint32_t batch_samples_max[VERDICT_DETAIL_COUNT]; // samples of a batch, by message size
    int64_t batch_target_ns; // how long a batch should take a worker [ns]: a few milliseconds
    int64_t silence_ns;      // a worker not heard for so long is gone, of hundreds [ns]
    int64_t lease_new_ns;    // least lease of a worker hardly known [ns]
    int64_t lease_min_ns;    // least and greatest lease [ns]
    int64_t lease_max_ns;
    int64_t message_ns;  // what a batch and its outcome take the coordinator's one loop [ns]
    uint32_t window_max; // batches in flight at one worker, at most
};

struct schedule_settings schedule_settings_default(void);

enum schedule_event_kind {
    SCHEDULE_EVENT_TICK,    // time has passed
    SCHEDULE_EVENT_STEP,    // a search wants a step sampled
    SCHEDULE_EVENT_CANCEL,  // a search no longer wants its step
    SCHEDULE_EVENT_WORKER,  // a worker announced itself
    SCHEDULE_EVENT_OUTCOME, // an outcome arrived, already checked and unpackable
};

struct schedule_event {
    enum schedule_event_kind kind;
    int64_t now_ns; // monotonic; never goes back
    union {
        struct {
            uint32_t search;
            uint32_t step;
            uint32_t samples;
            enum verdict_detail detail; // how much of each verdict comes back: less fits more
            double sample_ns; // guess of the evaluation time of a sample on one core; 0: none
        } step;
        struct {
            uint32_t search;
        } cancel;
        struct {
            uint64_t id; // its sender number
            uint32_t threads;
            uint32_t queue;
            bool acceptable; // fingerprint and version are the coordinator's
            bool leaving;
            char name[96]; // host and process, for notices
        } worker;
        struct {
            uint64_t worker; // sender number
            struct batch_identity batch;
            uint32_t queue;     // still waiting there
            int64_t service_ns; // its evaluation took
        } outcome;
    };
};

enum schedule_effect_kind {
    SCHEDULE_EFFECT_SEND,  // publish this batch, leased to this worker
    SCHEDULE_EFFECT_COUNT, // the event's outcome counts: store its verdicts
    SCHEDULE_EFFECT_STEP,  // all samples of this step are counted
    SCHEDULE_EFFECT_NOTE,  // something a person should know, in plain words
};

struct schedule_effect {
    enum schedule_effect_kind kind;
    union {
        struct {
            uint64_t worker;
            struct batch_identity batch;
        } send;
        struct {
            struct batch_identity batch;
        } count;
        struct {
            uint32_t search;
            uint32_t step;
        } step;
        char note[256];
    };
};

// A growing list of effects, reused from event to event.
struct schedule_effects {
    struct schedule_effect *items; // (count)
    size_t count;
    size_t capacity;
    int64_t wake_ns; // when the next tick is due; INT64_MAX when nothing is
};

struct schedule_counters {
    uint32_t workers; // that may hold leases
    uint32_t workers_refused;
    uint32_t batches_waiting;
    uint32_t batches_leased;
    uint64_t batches_counted;
    uint64_t samples_counted;
    uint64_t released;   // leases that lapsed or lost their worker
    uint64_t copies;     // late batches handed to a second worker
    uint64_t duplicates; // outcomes of batches already counted
    uint64_t unknown;    // outcomes of batches that never were or are long gone
    int64_t service_ns;  // evaluation time of counted batches
};

struct schedule;

struct schedule *schedule_create(const struct schedule_settings *settings);
void schedule_free(struct schedule *schedule);

// Takes one event and appends what is to be done to `effects` (which it empties first).
void schedule_step(struct schedule *schedule, const struct schedule_event *event,
                   struct schedule_effects *effects);

void schedule_effects_fini(struct schedule_effects *effects);

void schedule_counters(const struct schedule *schedule, struct schedule_counters *counters);

#endif
