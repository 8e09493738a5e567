// A run: the searches of one command, and the journal that keeps them. It is made anew from a
// scenario or taken up again from a run folder; from then on both go the same way.
//
//     run_create() or run_resume()
//     for each search: run_next() -> sample the step somewhere -> run_complete() -> run_next() ...
//     run_end()
#ifndef SOBOX_COORDINATOR_RUNTIME_RUN_H
#define SOBOX_COORDINATOR_RUNTIME_RUN_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"
#include "coordinator/journal/journal.h"
#include "coordinator/search/search.h"

#include <stdbool.h>
#include <stdint.h>

// One search and the step it wants sampled.
struct run_search {
    struct scenario scenario;
    struct search *search;
    struct search_request request; // meaningful while `active`
    bool active;                   // a step is being sampled
    bool done;
    double *bounds;           // (2 x variables) of the step's box as it travels: lower, then upper
    struct digest box;        // digest of the bounds' bytes: the box's name on the network
    struct verdict *verdicts; // (request.sampling.samples) filled in as outcomes arrive
    int64_t started_ns;       // monotonic, of this session
    int64_t finished_ns;      // monotonic, once done
};

struct run {
    char *directory;
    bool folder_made; // by run_create(), so run_abandon() may remove it
    struct journal *journal;
    struct journal_run record;   // as the journal has it
    struct run_search *searches; // (record.search_count)
    uint32_t done_count;
    int64_t started_ns; // monotonic, of this session
};

// Makes the run folder and its journal with one search of `scenario`, which is taken over (zeroed)
// on success. `directory` must be absent or empty; NULL picks the first free of runs/NAME,
// runs/NAME-2, ... `threads` may trim.
// Errors: STATUS_INVALID (the folder is not empty or cannot be made), STATUS_IO. Nothing is left
// behind then.
enum status run_create(struct run *run, const char *directory, struct scenario *scenario,
                       int threads, int64_t now_ns, struct error *error) MUST_USE;

// Takes up a run folder where its journal ends, by replaying each search's finished steps.
// Errors: STATUS_INVALID (no run there), STATUS_IO, STATUS_REFUSED (another schema or version wrote
// it; it is being written; it is done; its steps do not replay).
enum status run_resume(struct run *run, const char *directory, int threads, int64_t now_ns,
                       struct error *error) MUST_USE;

// Asks search `index` for its next step: true with `request`, `bounds`, `box` and room for the
// verdicts when there is one, false when it is done, with its result in the journal.
enum status run_next(struct run *run, uint32_t index, int64_t now_ns, bool *wanted,
                     struct error *error) MUST_USE;

// The step of search `index` is sampled: hands its verdicts to the search and writes the step to
// the journal before anything follows from it.
enum status run_complete(struct run *run, uint32_t index, struct error *error) MUST_USE;

// Time spent on the run, over all its sessions.
int64_t run_elapsed_ns(const struct run *run, int64_t now_ns);

// Writes the state in which the run ends for now.
enum status run_end(struct run *run, enum journal_state state, int64_t now_ns,
                    struct error *error) MUST_USE;

// Releases everything. A zeroed struct is fine.
void run_fini(struct run *run);

// Removes the folder of a run that never began to sample, so that no empty shell is left.
void run_abandon(struct run *run);

#endif
