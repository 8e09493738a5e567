// Moves all sides of a box a little so that each is worth its place: where the box is largest for
// its purity, every side that could move has the same share of bad designs along it, for otherwise
// moving one out and another in by the same factor would give a purer box of the same volume.
// (Write p for the bad share of the box and p_s for that along side s; moving side s out by a
// factor 1 + e changes the logarithm of the volume by e and p by e (p_s - p). Lagrange: all p_s are
// equal. Where the logarithm of a width counts w_s times, p_s - p is in proportion to w_s.)
//
// The share along a side is estimated from the bad samples of one step, each counted by its
// distance from the side. One step's estimate is noise, so sides move by little and the noise
// averages out over the steps (stochastic approximation; Robbins and Monro, 1951). A side that is
// pushed the same way again and again moves faster, one that is pushed to and fro slower (after
// Kesten, 1958). All samples of all steps thus shape the box, where a trim lets single samples
// decide: in 30 dimensions, where the bad designs sit in the corners, that is the difference
// between half and nine tenths of the possible volume.
#ifndef SOBOX_COORDINATOR_SEARCH_BALANCE_H
#define SOBOX_COORDINATOR_SEARCH_BALANCE_H

#include "coordinator/search/cloud.h"

// What is remembered of each side from step to step. Side 2v is the lower bound of variable v, side
// 2v + 1 its upper bound.
struct balance {
    uint32_t variables;
    double *push;        // (sides) in -1..1: mean of the last pushes, inwards positive
    double *eager;       // (sides) by what the side's gain is multiplied
    double *sums;        // (sides) scratch: weights of the bad samples along the side
    double volume_push;  // in -1..1: mean of the last steps' lack of bad samples
    double volume_eager; // by what the volume's gain is multiplied
};

// What one step showed and how it is used.
struct balance_step {
    uint32_t samples;        // of the step, uniform in the box
    uint32_t bad_count;      // how many of them were bad
    const struct cloud *bad; // those, or some of them, uniform too
    double bad_share;        // to be approached
    double gain;             // how fast sides move against each other
    double volume_gain;      // how fast they move together towards bad_share
    double volume_eager_max; // by what that may rise while the box is far too small or large, >= 1
    const double *weights;   // (variables) what a width is worth, > 0; or NULL: all the same
    int threads;
};

void balance_init(struct balance *balance, uint32_t variables);

// Releases what a balance owns. A zeroed struct is fine.
void balance_fini(struct balance *balance);

// Moves the sides of `box`, from which the samples were drawn, within `space`.
void balance_move(struct balance *balance, struct box *box, const struct box *space,
                  const struct balance_step *step);

#endif
