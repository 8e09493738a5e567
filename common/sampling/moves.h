// Designs of an adversarial search: each attack is a design in the box, given by the level of every
// variable in its interval, and a step samples each attack and its neighbours. A design that moves
// with the box keeps its levels, so a worst corner stays a corner while the box grows.
//
//     levels   0 ........ 127 ........ 254        lower bound, middle, upper bound
//
//     move     1              the attack itself
//              free           each free variable at its other bound (flip)
//              free           each free variable a tenth of its width inwards (probe: the slope)
//              3 x curves     each curve of more than one free variable at its lower bound, its
//                             middle, its upper bound
//              MOVES_LEAPS    several variables or whole curves at random bounds
//
// Sample i of the step is move i % moves_count() of attack i / moves_count().
#ifndef SOBOX_COMMON_SAMPLING_MOVES_H
#define SOBOX_COMMON_SAMPLING_MOVES_H

#include "common/numeric/box.h"
#include "common/numeric/curve_map.h"

#include <stddef.h>
#include <stdint.h>

enum {
    MOVES_LEVEL_MAX = 254, // even, so that the middle is a level
    MOVES_PROBE = 25,      // levels: far enough for the noise of a single-precision margin, near
                           // enough for a slope
    MOVES_LEAPS = 8,       // random moves of an attack
};

// The attacks of a step. Each is a row of 1 + variables bytes: the constraint whose margin it
// wants to know, then the levels of all variables, 0 .. MOVES_LEVEL_MAX.
struct moves {
    uint32_t variables;
    uint32_t attacks;
    uint8_t *rows; // (attacks x (1 + variables))
};

struct sampling;

// Releases attacks. A zeroed struct is fine.
void moves_fini(struct moves *moves);

// The bytes of the attacks' table.
size_t moves_size(const struct moves *moves);

// How many samples each attack takes in this box.
uint32_t moves_count(const struct curve_map *curves, const struct box *box);

// The constraint whose margin sample `index` is to tell.
uint8_t moves_target(const struct sampling *sampling, uint32_t per_attack, uint32_t index);

// The levels (variables) of sample `index` of the step. Variables without width have level 0 or
// that of their attack: they are not moved.
void moves_levels(const struct sampling *sampling, const struct box *box, uint32_t index,
                  uint8_t *levels);

// Fills in samples index[0] .. index[count - 1]: values[variable * stride + i] belongs to sample
// index[i]. stride >= count.
void moves_fill(const struct sampling *sampling, const struct box *box, const uint32_t *index,
                uint32_t count, double *values, size_t stride);

// The value of a variable at a level of its interval: exactly the bounds at 0 and MOVES_LEVEL_MAX.
double moves_value(double lower, double upper, uint8_t level);

#endif
