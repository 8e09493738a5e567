// The widest box that keeps linear limits: the convex problem at the heart of the cutting-set
// method (cutting_set.h).
//
//     maximize    sum_v weight_v ln(upper_v - lower_v) - price t
//     subject to  constant_i + sum_v (a_iv lower_v + b_iv upper_v) + t >= tolerance,  t >= 0,
//                 every side within its range
//
// The excess t makes every set of limits feasible: where limits contradict each other, or are
// missed by the box at hand, the box misses all by t at most. Solved by a logarithmic barrier and
// Newton's method (Boyd and Vandenberghe, "Convex optimization", 11.3). Its matrix is a 2 x 2 block
// a variable plus one outer product a limit, so each step solves a system as large as there are
// limits (Woodbury's identity): a box of 720 variables costs little more than one of 18.
#ifndef SOBOX_COORDINATOR_SEARCH_WIDEST_H
#define SOBOX_COORDINATOR_SEARCH_WIDEST_H

#include <stdbool.h>
#include <stdint.h>

// Lengths are in units of the design space: 0 is its lower bound, 1 its upper one. Sides stand in
// pairs: 2v is the lower bound of variable v, 2v + 1 its upper one.
struct widest_problem {
    uint32_t variables;
    const double *weights;      // (variables) what a variable's log-width counts, or NULL: 1 each
    const double *least;        // (2 x variables) the range of each side;
    const double *most;         // a side whose range has no width stands still
    uint32_t limit_count;       //
    const double *const *limit; // (limit_count) each (2 x variables): the slope along each side
    const double *constant;     // (limit_count)
    double tolerance;           // what each limit is to exceed
    double price;               // of the excess
};

struct widest_answer {
    double *sides;  // (2 x variables) in: a box to start from; out: the widest one
    double excess;  // by how much a limit is missed at most
    double *prices; // (limit_count) or NULL; out: what one of tolerance costs at each limit
    double shadow;  // sum of the limits' prices: what one of tolerance costs in log-volume
};

// Solves the problem to within about 0.01 of the best log-volume. There is some box whose sides are
// strictly inside their ranges, lower below upper.
void widest(const struct widest_problem *problem, struct widest_answer *answer);

#endif
