// The words of the protocol: what the numbers in the messages (lcmtypes/) mean, how great they may
// be, and what they are called where people or files read them. Coordinator, worker and monitor
// share these; nobody restates them. The header is plain C without LCM, so that folders which know
// no network (search, schedule, sampling) use the same enumerations as the messages.
//
// The values travel and the names are written to run.db and history.csv. So values keep their
// numbers and names keep their spelling; whoever changes either raises WIRE_PROTOCOL or
// JOURNAL_SCHEMA.
#ifndef SOBOX_COMMON_PROTOCOL_PROTOCOL_H
#define SOBOX_COMMON_PROTOCOL_PROTOCOL_H

#include <stdbool.h>
#include <stdint.h>

enum {
    PROTOCOL_BATCH_SAMPLES_MAX = 65536, // samples, or designs, of one batch: its verdicts in full
                                        // fit 200 KB of memory at either end
    PROTOCOL_TEXT_SIZE_MAX = 1 << 20,   // [bytes] of a scenario or box that travels in pieces
    PROTOCOL_VARIABLE_MAX = 4096,       // variables of one search
    PROTOCOL_SCENARIO_MAX = 8192,       // scenarios that a worker keeps: all open searches of its
                                        // coordinator, and some of another one
    PROTOCOL_AXIS_MAX = 64,             // values that tell the cases of a sweep apart
};

// How a run stands (run_status_t, and the run in run.db).
enum run_state {
    RUN_STATE_RUNNING,
    RUN_STATE_WAITING, // for workers; a journal knows it as running
    RUN_STATE_DONE,
    RUN_STATE_INTERRUPTED, // ended by the user, or with searches left; can be resumed
    RUN_STATE_FAILED,
};

// How a search stands in its run (search_status_t).
enum search_standing {
    SEARCH_STANDING_WAITING,
    SEARCH_STANDING_OPEN,
    SEARCH_STANDING_DONE,
    SEARCH_STANDING_FAILED, // could not be carried out
};

// What a search does (search_status_t, step_status_t).
enum search_phase {
    SEARCH_PHASE_SEEK,
    SEARCH_PHASE_EXPLORE,
    SEARCH_PHASE_CONSOLIDATE,
    SEARCH_PHASE_CERTIFY,
    SEARCH_PHASE_EXPLAIN,
    SEARCH_PHASE_DONE,
};

// What came of a search (search_status_t).
enum search_status {
    SEARCH_STATUS_RUNNING,
    SEARCH_STATUS_DONE,           // a box was found and certified: lower95 >= target_purity
    SEARCH_STATUS_PURITY_MISSED,  // a box was found; its certificate stays below target_purity
    SEARCH_STATUS_NO_GOOD_DESIGN, // no good sample anywhere
};

// How the samples of a step are drawn (sample_batch_t, step_status_t). The first three draw every
// variable on its own, the next three the levels at which whole curves stand in their corridors,
// and the last one is told which designs to move.
enum sampling_method {
    SAMPLING_METHOD_UNIFORM,
    SAMPLING_METHOD_LATIN_HYPERCUBE,
    SAMPLING_METHOD_SOBOL,
    SAMPLING_METHOD_CURVES,   // every curve at a level of its own
    SAMPLING_METHOD_LEVELS,   // one level for all curves of a direction
    SAMPLING_METHOD_EXTREMES, // every curve at its lower bound, its upper bound or a level
    SAMPLING_METHOD_MOVES,    // given attacks and their neighbours (common/sampling/moves.h)
};

// The kinds of designs that a box is judged by.
enum design_kind {
    DESIGN_KIND_POINTS,   // every variable uniform in its interval, independently
    DESIGN_KIND_CURVES,   // every curve at one level of its corridor, its own
    DESIGN_KIND_LEVELS,   // one level for all curves of a direction
    DESIGN_KIND_EXTREMES, // every curve at its lower bound, its upper bound, or one level
};

// Which designs of a box must be good (design.md section 4).
enum promise {
    PROMISE_POINTS, // the wanted share of independent points
    PROMISE_CURVES, // that share of each kind of designs
    PROMISE_EVERY,  // and no bad design that an adversarial search finds
};

// How many values each of these has: apart from them, so that no switch need name a count.
enum {
    RUN_STATE_COUNT = RUN_STATE_FAILED + 1,
    SEARCH_STANDING_COUNT = SEARCH_STANDING_FAILED + 1,
    SEARCH_PHASE_COUNT = SEARCH_PHASE_DONE + 1,
    SEARCH_STATUS_COUNT = SEARCH_STATUS_NO_GOOD_DESIGN + 1,
    DESIGN_KIND_COUNT = DESIGN_KIND_EXTREMES + 1,
    PROMISE_COUNT = PROMISE_EVERY + 1,
    SAMPLING_METHOD_COUNT = SAMPLING_METHOD_MOVES + 1,
};

// What identifies a batch everywhere (batch_t). An outcome carries the identity of its batch, and
// what a batch gives depends on nothing but its identity, scenario, box and seed.
struct batch_identity {
    uint32_t search;  // index in the run
    uint32_t step;    // of the search
    uint32_t batch;   // of the step
    uint32_t attempt; // 0 at first, one more at each time it is handed out again
    uint32_t first;   // sample
    uint32_t count;   // samples, 1 .. PROTOCOL_BATCH_SAMPLES_MAX
};

// Whether a run in this state is over.
bool protocol_run_ended(enum run_state state);

// The names, for instance "running", "explore", "purity_missed".
const char *protocol_run_state_name(enum run_state state);
const char *protocol_phase_name(enum search_phase phase);
const char *protocol_status_name(enum search_status status);

const char *protocol_kind_name(enum design_kind kind); // "points", "curves", ...

const char *protocol_promise_name(enum promise promise); // "points", "curves", "every"

// How independent designs of a kind are drawn.
enum sampling_method protocol_kind_method(enum design_kind kind);

// The values of these names. False, with the value untouched, where the name is none.
bool protocol_run_state_of(const char *name, enum run_state *state);
bool protocol_phase_of(const char *name, enum search_phase *phase);
bool protocol_status_of(const char *name, enum search_status *status);

#endif
