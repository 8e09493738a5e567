// One box search as a pure step machine: it asks for a step of samples, is given their verdicts,
// and asks for the next, until it is done (design.md section 4). It knows no clock, network or
// file; the same verdicts give the same bits, whoever computed them and however many threads trim.
//
//     seek -> explore (grow, sample, trim) -> consolidate (sample, trim) -> certify -> explain ->
//     done
//
// Where every bound is held there is nothing to search: the search begins with certify, and ends
// with the box as it is, whatever is found in it.
//
// With search.round the box is rounded inwards whenever it is about to be certified, so what is
// attacked and certified is what is handed out.
//
// The last phase changes nothing in the box: it samples just outside it, to say what holds it
// (explain.h). It may be left out.
//
// A finished step is an event: the journal keeps the verdicts of each, and a search is resumed by
// replaying them.
#ifndef SOBOX_COORDINATOR_SEARCH_SEARCH_H
#define SOBOX_COORDINATOR_SEARCH_SEARCH_H

#include "common/numeric/box.h"
#include "common/numeric/digest.h"
#include "common/numeric/verdict.h"
#include "common/protocol/protocol.h"
#include "common/sampling/sampling.h"
#include "common/scenario/scenario.h"

// What the search wants sampled next.
struct search_request {
    struct sampling sampling; // with the step's number and its count of samples
    enum search_phase phase;
    enum verdict_detail detail;
    const struct box *box; // borrowed; valid until search_complete()
};

// The record of a finished step: a row of history.csv.
struct search_step {
    uint32_t step;
    enum search_phase phase;
    uint32_t samples;
    uint32_t good;
    double growth;     // growth rate used in this step; 0 where the box did not grow
    double log_volume; // of the box after the step
};

struct search_progress {
    enum search_phase phase;
    uint32_t step;         // steps finished
    uint32_t step_count;   // an estimate of the total, never below `step`
    uint64_t evaluations;  // samples counted so far
    double good_share;     // of the last finished step
    double log_volume;     // of the current box
    const struct box *box; // current box; borrowed until the next search_complete()
};

// What fresh samples of a box showed.
struct search_purity {
    uint64_t samples;
    uint64_t bad;
    double estimate; // good share of the samples
    double lower95;  // what the true share exceeds with 95 % confidence, repeated looks counted
};

struct search_result {
    enum search_status status;
    const struct box *box; // the corridors; borrowed for the life of the search. Without a good
                           // design it is the least violating one alone, lower equal to upper
    double log_volume;     // -infinity without a good design
    struct search_purity purity;                   // of the samples that decide: points
    struct search_purity kinds[DESIGN_KIND_COUNT]; // of each kind of designs, points among them; no
                                                   // samples where it was not looked at
    const double *worst;    // (variables) the worst design of the box that was found, or NULL;
                            // borrowed for the life of the search
    const uint8_t *holders; // (2 x variables) the constraint that holds each bound or 255, and
    const double *gains; // (constraints) what 1 % of each is worth in log-volume: where a promise
                         // of every design tells it, else NULL; borrowed likewise
    double margin;       // by which it is inside its nearest constraint, in that one's own scale
    uint64_t evaluations;
    uint64_t non_finite; // samples with a non-finite outcome
    uint32_t steps;
    uint32_t blocking_constraint; // no good design: the constraint most often in the way
    struct digest digest;         // of the bounds' bits and the counts, those of the explanation
                                  // left out: the same with one and without
};

struct search;

// A search of `scenario` (borrowed for the life of the search). `threads` may trim. The caller
// frees it.
struct search *search_create(const struct scenario *scenario, uint64_t seed, int threads);
void search_free(struct search *search);

// Fills in what to sample next; false when the search is done. Asking twice changes nothing.
bool search_request(const struct search *search, struct search_request *request);

// Takes the verdicts of the requested step (request.sampling.samples of them) and moves on.
void search_complete(struct search *search, const struct verdict *verdicts);

// The record of the step completed last. There is one.
const struct search_step *search_last_step(const struct search *search);

void search_progress(const struct search *search, struct search_progress *progress);

// The result so far; final when search_request() returns false.
void search_result(const struct search *search, struct search_result *result);

#endif
