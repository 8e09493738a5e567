// From a wide box of which some 70 % is good to the widest box that is as pure as wanted.
//
//     bad share
//      .3 |\                              The wanted share falls and the box is balanced at each
//         | \__                           step, so that its shape follows the good region; when it
//         |    \____                      has settled, its last boxes are averaged.
//         |         \______________
//         +-----------------+--+--+-> steps
//                     settled  averaged, and a box without known bad samples on trial
//
// Balanced sides find the shape by many samples, and leave the bad share that was asked for. Where
// bad designs fill a corner to the brim one cut is worth more than sides in balance, and in few
// dimensions the known bad samples say exactly how far a side can go. So a box cut out of all known
// bad samples is tried too: if it is larger, fresh samples decide. In many dimensions such a box
// finds the gaps between the samples, and fails.
#ifndef SOBOX_COORDINATOR_SEARCH_CONSOLIDATE_H
#define SOBOX_COORDINATOR_SEARCH_CONSOLIDATE_H

#include "coordinator/search/explore.h"
#include "coordinator/search/survey.h"

struct consolidate {
    const struct box *space; // borrowed
    uint32_t steps;          // finished
    uint32_t step_count;     // to be spent in all
    double bad_from;         // bad share it starts from
    double bad_to;           // and ends at
    struct box explored;     // where it started
    struct box average;      // of the last boxes
    uint32_t average_count;  // of those
    uint32_t trial_steps;    // left of the trial of a box without known bad samples
    uint64_t trial_bad;      // bad samples in it so far
    struct box balanced;     // to go back to when it fails
};

// An idle one. `space` is borrowed. The caller releases it with consolidate_fini().
void consolidate_init(struct consolidate *consolidate, const struct box *space);
void consolidate_fini(struct consolidate *consolidate);

// Starts, or starts again, on `explore`'s box.
void consolidate_start(struct consolidate *consolidate, struct explore *explore,
                       uint32_t step_count, double bad_from, double bad_to);

// Takes the verdicts on explore->sampled; of `step` its bad_share and gains are filled in here.
// `survey` holds the steps so far, this one included. Returns whether all steps are spent.
bool consolidate_complete(struct consolidate *consolidate, struct explore *explore,
                          struct explore_step step, const struct survey *survey);

// Nothing more is gained: if the box is at rest, the steps left are cut down to those of a last
// trial. Otherwise nothing happens.
void consolidate_hasten(struct consolidate *consolidate);

// Whether the wanted share is reached and no trial goes on: the box only has to come to rest.
bool consolidate_resting(const struct consolidate *consolidate);

#endif
