// Everything that chance decides in a storm, from one seed: the same seed throws the same numbers
// in the same order, so a storm that fails can be watched again.
#ifndef SOBOX_TESTS_CLUSTER_DICE_H
#define SOBOX_TESTS_CLUSTER_DICE_H

#include <stdbool.h>
#include <stdint.h>

struct dice {
    uint64_t seed;
    uint64_t thrown;
};

// A number in [0, 1).
double dice_unit(struct dice *dice);

// An integer in 0 .. below - 1.
uint32_t dice_below(struct dice *dice, uint32_t below);

// True with that probability.
bool dice_chance(struct dice *dice, double probability);

// A number between `low` and `high`, both above 0, its logarithm uniform: no scale is favoured.
double dice_scale(struct dice *dice, double low, double high);

// A waiting time with that mean, exponentially distributed, at least 1 [ns].
int64_t dice_wait_ns(struct dice *dice, double mean_ns);

// A sender number: random, not 0.
uint64_t dice_sender(struct dice *dice);

#endif
