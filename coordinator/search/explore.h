// The way of one box from a good design to the widest box of about 70 % good designs around it.
//
// Growing: the box grows, is sampled and trimmed; a growth that leaves too few good samples is
// taken back. Coarse and quick: a point becomes a box of the right size in some ten steps.
// Balancing: the box is sampled as it is and its sides are moved (balance.h) so that 70 % stay
// good. Slow and fine: the shape settles.
#ifndef SOBOX_COORDINATOR_SEARCH_EXPLORE_H
#define SOBOX_COORDINATOR_SEARCH_EXPLORE_H

#include "coordinator/search/balance.h"
#include "coordinator/search/demands.h"
#include "coordinator/search/growth.h"
#include "coordinator/search/trim.h"
#include "coordinator/search/volume.h"

enum { EXPLORE_MEMORY = 3 }; // steps that a box is judged by

struct explore {
    const struct box *space;       // borrowed
    const struct demands *demands; // borrowed; NULL: none
    struct box box;                // as it stands: trimmed, or balanced
    struct box sampled;            // what to sample in the next step
    struct growth growth;
    struct balance balance;
    double rate; // growth of the next step; 0 when it does not grow
    bool balancing;
    bool grown;     // has met bad samples and was trimmed: there is a box to balance
    uint32_t steps; // finished
    struct volume yield[EXPLORE_MEMORY]; // volume of good designs sampled in the last steps
};

// What a step showed.
struct explore_step {
    const struct cloud *good; // good samples: some, at least one if there were any
    const struct cloud
        *bad; // bad ones: all, or those among so many samples that more would not help
    uint32_t samples;
    uint32_t good_count;
    double bad_share; // to be approached when balancing
    double gain;      // as in struct balance_step
    double volume_gain;
    double volume_eager_max;
    int threads;
};

// How fast the sides move against each other while exploring; consolidation slows down from there.
extern const double explore_gain;

// Starts from a good design; start[i * stride] is its variable i.
void explore_init(struct explore *explore, const struct box *space, const double *start,
                  size_t stride);

// Meets the demands (borrowed) from now on.
void explore_demand(struct explore *explore, const struct demands *demands);

// Begins from a box instead of its start, or from a design: lower equal to upper.
void explore_begin(struct explore *explore, const struct box *box);

void explore_fini(struct explore *explore);

// Takes the verdicts on `sampled` and moves on.
void explore_complete(struct explore *explore, const struct explore_step *step);

// Samples the box as it stands from now on, and balances its sides.
void explore_settle(struct explore *explore);

// Goes on from another box, which is sampled as it stands.
void explore_move(struct explore *explore, const struct box *box);

// Whether there is nothing left to grow into: the box is the whole design space, all of it good.
bool explore_whole(const struct explore *explore);

// Whether the box of `a` holds more good designs than that of `b`, by the last steps of both.
bool explore_ahead(const struct explore *a, const struct explore *b);

#endif
