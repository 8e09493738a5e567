// A run: the searches of one command, and the journal that keeps them. It is made anew from a
// scenario or a sweep, or taken up again from a run folder; from then on all go the same way.
//
//     run_create(), run_create_sweep() or run_resume()
//     for each search: run_open()
//                      run_next() -> sample the step somewhere -> run_trim() -> run_record()
//                      -> run_next() ... -> run_close()
//     run_end()
//
//            run_open             run_next: done, run_close
//     waiting -------> open ------------------------------> done
//        |              |
//        |              +-- cannot go on --> failed, tried again by --resume
//        +-- not chosen: stays for --resume
//
// A search that waits costs a few bytes: its scenario lies in the journal, and all its memory is
// taken when it is opened and released when it is closed. A case of a sweep gives the same digest
// as its scenario run alone.
#ifndef SOBOX_COORDINATOR_RUNTIME_RUN_H
#define SOBOX_COORDINATOR_RUNTIME_RUN_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"
#include "common/scenario/sweep.h"
#include "coordinator/journal/journal.h"
#include "coordinator/search/search.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

// An open search and the step it wants sampled.
struct run_search {
    uint32_t index; // in the run
    struct scenario scenario;
    struct search *search;
    struct search_request request; // meaningful while `active`
    bool active;                   // a step is being sampled
    struct box sampled;            // that step's box
    GByteArray *text;              // as it travels (common/sampling/box_text.h)
    struct digest box;             // digest of that text: the box's name on the network
    struct verdict *verdicts;      // (request.sampling.samples) filled in as outcomes arrive
    int64_t started_ns;            // monotonic, of this session
    uint32_t told_variable; // whose bounds are told first next time; this and the next of tell.h
    int64_t told_ns;        // monotonic, when its samples were last told of
};

struct run {
    char *directory;
    bool folder_made; // by its creation, so run_abandon() may remove it
    struct journal *journal;
    struct journal_run record; // as the journal has it
    struct run_search **open;  // (record.search_count) NULL unless it is open
    uint8_t *standings;        // (record.search_count) enum search_standing
    uint8_t *chosen;           // (record.search_count) 1: to be carried out in this session
    uint32_t chosen_count;     // that are not done yet when the session begins
    uint32_t next;             // the first that may be waiting
    uint32_t open_count;
    uint32_t done_count;     // over all sessions
    uint32_t found_count;    // of the done ones that have corridors
    uint32_t failed_count;   // in this session
    uint32_t coarse_count;   // in this session: done, but search.round left some bound as it was
    uint32_t finished_count; // in this session: done or failed
    uint64_t steps;          // recorded in this session
    int threads;             // that may trim one search
    int64_t started_ns;      // monotonic, of this session
};

// Which cases of a sweep to carry out.
struct run_choice {
    const char *only;     // a pattern with * ? [] that the case's name must match, or NULL
    uint32_t shard;       // 1 .. shard_count: every shard_count-th case from this one on
    uint32_t shard_count; // 1: all
    uint32_t stop_after;  // at most so many searches in this session; 0: all
    bool keep_going;      // leave out cases whose scenario is invalid, and say which
};

// Makes the run folder and its journal with one search of `scenario`. `directory` must be absent or
// empty; NULL picks the first free of runs/NAME, runs/NAME-2, ... `threads` may trim.
// Errors: STATUS_INVALID (the folder is not empty or cannot be made), STATUS_IO. Nothing is left
// behind then.
enum status run_create(struct run *run, const char *directory, const struct scenario *scenario,
                       int threads, int64_t now_ns, struct error *error) MUST_USE;

// The same with a search for each case of the sweep that `only` and `shard` choose; their scenarios
// are checked before anything starts. `stop_after` leaves the later ones waiting.
// Errors: also STATUS_INVALID (no case matches; the scenario of one is invalid, unless keep_going;
// all are).
enum status run_create_sweep(struct run *run, const char *directory, const struct sweep *sweep,
                             const struct run_choice *choice, int threads, int64_t now_ns,
                             struct error *error) MUST_USE;

enum { RUN_WARNINGS_MAX = 20 }; // shown of a sweep; more would bury each other

// The cases of a sweep that `only` and `shard` choose, one after the other: what a run and its
// preview go through.
struct run_cases {
    const struct sweep *sweep;       // borrowed
    const struct run_choice *choice; // borrowed
    uint32_t next;                   // case to look at
    uint32_t count;                  // given so far
    uint32_t invalid;                // left out
    uint32_t without_overlap;        // given so far whose verdicts do not depend on barrier.overlap
    uint32_t implausible;            // given so far of which something is unlikely
    uint32_t told[RUN_WARNINGS_MAX]; // (told_count) hashes of warnings that were shown
    uint32_t told_count;
};

void run_cases_init(struct run_cases *cases, const struct sweep *sweep,
                    const struct run_choice *choice);

// Gives the next case and its scenario, to be released by the caller; `index` is UINT32_MAX after
// the last. What is unlikely of a case is shown, with its name; what many cases have from the base,
// once. Errors: STATUS_INVALID (its scenario is, and there is no keep_going).
enum status run_cases_next(struct run_cases *cases, uint32_t *index, struct scenario *scenario,
                           struct error *error) MUST_USE;

// Called after the last: says whether there was any, and notes what was left out and what varies
// without a consequence. Errors: STATUS_INVALID.
enum status run_cases_check(const struct run_cases *cases, struct error *error) MUST_USE;

// Takes up a run folder where its journal ends. Searches that are done stay so; of the others those
// that `only` chooses are carried out in this session (shard and keep_going belong to the
// beginning). Errors: STATUS_INVALID (no run there; no search that is missing matches), STATUS_IO,
// STATUS_REFUSED (another schema or version wrote it; it is being written; it is done).
enum status run_resume(struct run *run, const char *directory, const struct run_choice *choice,
                       int threads, int64_t now_ns, struct error *error) MUST_USE;

// The next search that waits and is chosen, without opening it: false when there is none.
bool run_waiting(struct run *run, uint32_t *index);

// Opens a waiting search: reads its scenario and replays its finished steps, if any.
// Errors: STATUS_IO, STATUS_REFUSED (its steps do not replay); the search is then
// SEARCH_STANDING_FAILED, which ends a run of one search, and not a sweep.
enum status run_open(struct run *run, uint32_t index, int64_t now_ns, struct error *error) MUST_USE;

// Asks an open search for its next step: true with `request`, `bounds`, `box` and room for the
// verdicts when there is one, false when it is done, with its result in the journal.
enum status run_next(struct run *run, uint32_t index, int64_t now_ns, bool *wanted,
                     struct error *error) MUST_USE;

// The step of the search is sampled: hands its verdicts to the search, which trims its box. A pure
// function of the search alone: many searches may be trimmed at once, in any threads.
void run_trim(struct run_search *search);

// Writes the step that was trimmed to the journal, before anything follows from it.
enum status run_record(struct run *run, uint32_t index, struct error *error) MUST_USE;

// Releases what a search that is done holds.
void run_close(struct run *run, uint32_t index);

// Whether this session has nothing left to do.
bool run_finished(const struct run *run);

// Time spent on the run, over all its sessions.
int64_t run_elapsed_ns(const struct run *run, int64_t now_ns);

// Writes the state in which the run ends for now.
enum status run_end(struct run *run, enum run_state state, int64_t now_ns,
                    struct error *error) MUST_USE;

// Releases everything. A zeroed struct is fine.
void run_fini(struct run *run);

// Removes the folder of a run that never began to sample, so that no empty shell is left.
void run_abandon(struct run *run);

#endif
