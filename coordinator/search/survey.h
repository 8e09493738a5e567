// What all samples so far say about the bad share of any box, also of one that was never sampled as
// it stands: the steps of a search draw from boxes that overlap nearly, so a bad sample of one step
// tells of the boxes of all others.
//
//     +-----------+ step 1: 100 samples      A bad sample in both boxes stands for the volume that
//     |    +------+------+ step 2: 100       each sample of the two steps together stands for:
//     |    |  x   |      |                   1 / (100 / volume 1 + 100 / volume 2).
//     +----+------+      |                   Where only step 2 looked, 1 / (100 / volume 2).
//          +-------------+
//
// (The balance heuristic of multiple importance sampling; Veach and Guibas, 1995. The volume of a
// box is known, so good samples need not be kept.)
#ifndef SOBOX_COORDINATOR_SEARCH_SURVEY_H
#define SOBOX_COORDINATOR_SEARCH_SURVEY_H

#include "coordinator/search/cloud.h"
#include "coordinator/search/volume.h"

// A step: a box, what was drawn from it, and how many bad samples it left.
struct survey_step {
    struct volume volume; // of the box, in units of the space
    uint32_t samples;
    uint32_t bad;
};

struct survey {
    const struct box *space; // borrowed
    struct cloud bad;        // bad samples of the steps, the oldest first
    struct survey_step *steps;
    double *bounds;      // (step x 2 variables) of each step's box: lower, then upper bounds
    uint32_t step_count; // steps that are remembered
    uint32_t step_capacity;
};

// An empty one. The caller releases it with survey_fini(). `space` is borrowed.
void survey_init(struct survey *survey, const struct box *space);

// Releases a survey. A zeroed struct is fine.
void survey_fini(struct survey *survey);

// Takes in a step: `samples` drawn from `box`, `bad` of them bad. With more than
// `bad_max` bad samples the oldest steps are forgotten, a quarter at once; the last one stays.
void survey_add(struct survey *survey, const struct box *box, uint32_t samples,
                const struct cloud *bad, uint32_t bad_max);

// Adds the bad samples that lie in `region` to `inside` and returns (malloc'ed by GLib, the caller
// frees it) the share of the region's volume that each of them stands for.
double *survey_inside(const struct survey *survey, const struct box *region, struct cloud *inside);

// The estimated bad share of a box with a volume. What no step looked at counts as good.
double survey_share(const struct survey *survey, const struct box *box);

#endif
