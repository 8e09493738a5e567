// What holds each corridor: fresh samples just outside every bound that could move, and which
// constraint the bad ones among them violate most.
//
//               corridor            slab: a tenth of the corridor wide, not beyond the design
//     |-----[=============]//|---|  space; all other variables inside the box
//   space                        space
//
// One step of samples a bound, uniform whatever the `sampling` setting says. A bound is not sampled
// where something else than a constraint holds it: it lies on the edge of the design space, it is
// held, its variable is fixed. Of variables that share a corridor each has its own slab, and their
// samples count together, for the bound of one is the bound of all.
//
// In many dimensions bad designs sit in the corners, and a slab is good for the most part: 95 % is
// not a corridor that stopped short but one whose sides are all worth their place (balance.h).
//
// The search plans the steps and asks for them; whoever has their verdicts, from the journal too,
// makes the explanation from them. Both go through this module, so both see the same slabs.
#ifndef SOBOX_COORDINATOR_SEARCH_EXPLAIN_H
#define SOBOX_COORDINATOR_SEARCH_EXPLAIN_H

#include "common/numeric/verdict.h"
#include "common/sampling/sampling.h"
#include "common/scenario/scenario.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    EXPLAIN_SAMPLES = 500,      // a bound at most, where the scenario does not say
    EXPLAIN_SAMPLES_LEAST = 20, // then, whatever they cost
    EXPLAIN_SHARE = 8,          // then, all bounds together: at most this part of what was spent
    EXPLAIN_BUDGET_SHARE = 10,  // of a budget: at most this part is set aside
    EXPLAIN_BUDGET_LEAST = 10,  // samples a bound; with less room there is no explanation
};

// What holds a bound.
enum explain_holder {
    EXPLAIN_UNKNOWN,      // it was not sampled (yet)
    EXPLAIN_CONSTRAINT,   // the one that bad samples just outside violate most
    EXPLAIN_NOTHING,      // just outside the share of good designs is no lower than inside
    EXPLAIN_DESIGN_SPACE, // it lies on its edge, or nothing else holds it from there
    EXPLAIN_HELD,         // search.hold
    EXPLAIN_FIXED,        // the variable has one value
};

// A bound of the box: that of `variable`, the upper one or the lower.
struct explain_bound {
    uint32_t variable;
    bool upper;
    enum explain_holder holder;
    double from, to;       // of the slab, `from` <= `to`, in the variable's unit
    uint32_t drawn;        // samples in it
    uint64_t samples;      // the same; of a shared corridor those of all that share it
    uint64_t good;         // of those
    uint32_t constraint;   // EXPLAIN_CONSTRAINT: the most often violated one
    uint64_t violated;     // by how many samples it is violated worst
    bool at_minimum_width; // the corridor is as narrow as search.minimum_widths lets it be
    bool at_reference;     // the bound lies on the value of search.reference
};

// A bad sample in a slab.
struct explain_bad {
    uint32_t bound;      // index
    float distance;      // from the bound, in widths of the corridor, 0 to a tenth
    float violation;     // relative, of its worst constraint; infinite for a non-finite outcome
    uint32_t constraint; // that one
};

// What relaxing a constraint by 1 % of its scale would be worth: gain.h.
struct explain_gain {
    double amount;     // by which its bounds move [the outcome's unit]
    double log_volume; // gained; NAN where it cannot be told
    bool at_least;     // it is more than that, by how much the samples do not reach to say
};

struct explain {
    const struct scenario *scenario; // borrowed
    struct box box;                  // the corridors
    struct explain_bound *bounds;    // (2 x variables) lower and upper of variable 0, of 1, ...
    uint32_t *steps;                 // (step_count) indexes of the bounds that are sampled
    uint32_t step_count;
    uint32_t taken;          // of the steps
    bool known;              // without samples: explain_take_known()
    struct box slab;         // of the step asked for last
    struct explain_bad *bad; // (bad_count) of all slabs
    uint64_t bad_count;
    uint64_t bad_room;
    uint64_t *worst; // (2 x variables x constraints) bad samples by bound and constraint

    // Of the box itself, where that is known (explain_take_inside).
    uint64_t inside_samples;
    uint64_t inside_bad;
    struct explain_bad *inside; // (inside_bad) of which bound and distance mean nothing

    struct explain_gain *gains; // (constraints) filled in by explain_conclude()
};

// Finds out which bounds of `box` (all variables; copied) are to be sampled. `scenario` is
// borrowed. The caller releases it with explain_fini().
void explain_init(struct explain *explain, const struct scenario *scenario, const struct box *box);

// Releases what it owns. A zeroed struct is fine.
void explain_fini(struct explain *explain);

// How many bounds a search of the scenario may have to sample: what to set aside for.
uint32_t explain_steps_most(const struct scenario *scenario);

// How many samples a bound the scenario asks for, for `steps` bounds when `spent` designs were
// evaluated before; 0: none.
uint32_t explain_samples(const struct scenario_search *settings, uint32_t steps, uint64_t spent);

// What a budget of evaluations sets aside for the explanation.
uint64_t explain_reserve(const struct scenario *scenario);

// The box of step `step` (from 0, below step_count): borrowed until the next call.
const struct box *explain_slab(struct explain *explain, uint32_t step);

// Takes the verdicts of the next step: `sampling` says which samples they are of. The steps come
// in order. Returns false, and takes nothing, when there is no further step, the verdicts do not
// belong to the scenario, or the samples were drawn from another box than this step's.
bool explain_take(struct explain *explain, const struct sampling *sampling, const struct box *box,
                  const struct verdict *verdicts);

// Takes verdicts, in full detail, on independent samples of the box itself: the certificate's.
void explain_take_inside(struct explain *explain, const struct verdict *verdicts, uint32_t samples);

// Takes what a search for a box of good designs knows without samples: the constraint that holds
// each bound (2 x variables), or one that the scenario does not have, and the log-volume that
// relaxing each constraint by 1 % is worth (constraints).
void explain_take_known(struct explain *explain, const uint8_t *holders, const double *gains);

// Says from all samples taken what holds each bound, and what each constraint is worth.
void explain_conclude(struct explain *explain);

// "constraint", "nothing", "design_space", "held", "fixed", "unknown".
const char *explain_holder_name(enum explain_holder holder);

#endif
