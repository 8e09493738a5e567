// What a search remembers from step to step. Inside this folder only.
#ifndef SOBOX_COORDINATOR_SEARCH_SEARCH_STATE_H
#define SOBOX_COORDINATOR_SEARCH_SEARCH_STATE_H

#include "coordinator/search/certificate.h"
#include "coordinator/search/consolidate.h"
#include "coordinator/search/demands.h"
#include "coordinator/search/explain.h"
#include "coordinator/search/frame.h"
#include "coordinator/search/given.h"
#include "coordinator/search/plan.h"
#include "coordinator/search/recall.h"
#include "coordinator/search/search.h"
#include "coordinator/search/search_every.h"
#include "coordinator/search/seek.h"
#include "coordinator/search/stagnation.h"
#include "coordinator/search/tournament.h"

// What the digest covers beside the box.
struct counted {
    uint32_t step;
    uint64_t evaluations;
    uint64_t non_finite;
    enum search_status status;
};

struct search {
    const struct scenario *scenario; // borrowed
    uint64_t seed;
    int threads;

    // The free variables, in which everything below is expressed.
    struct frame frame;
    struct demands demands;

    // Where the search stands.
    enum search_phase phase;
    enum search_status status;
    struct search_request request;
    struct box requested; // all variables; request.box points here
    struct search_step last;
    uint32_t step; // steps finished
    uint64_t evaluations;
    uint64_t non_finite;

    // Seek.
    struct given given;
    struct seek seek;
    uint64_t blocked[256]; // bad samples of the seek by worst constraint

    struct search_every every; // in place of what follows, where that is promised
    struct tournament tournament;
    struct consolidate consolidate;
    uint32_t samples; // a step of consolidation
    struct plan plan;
    struct stagnation stagnation; // of the box that is left, then of the one at rest

    // Certify: the looks at points decide; then the other kinds of designs are looked at once.
    struct certificate certificate;
    enum design_kind kind; // that is looked at
    uint32_t kind_samples; // of each other kind
    enum search_status certified;
    struct certificate kinds[DESIGN_KIND_COUNT]; // that of points stands in `certificate`

    // Explain.
    struct explain explain;
    uint32_t explained;         // bounds, of explain.step_count
    uint32_t explain_samples;   // a bound
    uint64_t non_finite_beside; // in samples of which nothing in the box depends
    struct counted counted;     // before it

    // The samples of the step that is being completed.
    struct recall recall;
    struct survey survey; // the steps since exploration began, the newest
    uint32_t good_count;

    struct box result; // all variables
};

// Asks for samples of a box: of all variables, as it stands in `requested`, or of the free ones.
void search_ask_requested(struct search *search, uint32_t samples, enum sampling_method method,
                          enum verdict_detail detail);
void search_ask(struct search *search, const struct box *box, uint32_t samples,
                enum sampling_method method, enum verdict_detail detail);

// The kind of designs that is looked at after the present one; DESIGN_KIND_COUNT: none is left.
enum design_kind search_next_kind(const struct search *search);

// There is a box, and it is final: what is left to do is to say which design in it is the worst,
// where that is not known yet, and what holds it.
void search_finish_box(struct search *search, enum search_status status);

// The second of the two.
void search_begin_explain(struct search *search, enum search_status status);

#endif
