// The samples of a finished step, made again. A message brings verdicts and no samples, since a
// sample is a function of where it stands in its step; so the search makes those that it wants to
// look at once more. In a step of many samples it looks at the first ones only: each is drawn from
// the same box, so they are as good a choice as any.
#ifndef SOBOX_COORDINATOR_SEARCH_RECALL_H
#define SOBOX_COORDINATOR_SEARCH_RECALL_H

#include "common/numeric/verdict.h"
#include "common/sampling/sampling.h"
#include "coordinator/search/cloud.h"
#include "coordinator/search/frame.h"

#include <stdbool.h>

struct recall {
    const struct frame *frame; // borrowed
    struct cloud good;         // some of the good samples, at least one if there were any
    struct cloud bad;          // all bad ones, or as many as tell something
    uint32_t looked_at; // samples of the step, the first ones, whose bad ones are all in `bad`
    double *chunk;      // room for samples of all variables
};

// The caller releases it with recall_fini(). `frame` is borrowed.
void recall_init(struct recall *recall, const struct frame *frame);

// Releases a recall. A zeroed struct is fine.
void recall_fini(struct recall *recall);

// Makes the samples of a step that was drawn from `box` (all variables) and judged by `verdicts`.
// `good_count` is how many of them are good. Where it is not `known` by how much the bad ones
// violate, each violates by the least there is.
void recall_step(struct recall *recall, const struct sampling *sampling, const struct box *box,
                 const struct verdict *verdicts, uint32_t good_count, bool known);

#endif
