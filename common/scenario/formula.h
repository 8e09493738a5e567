// Models in closed form: what they compute with and what comes out. Most are problems whose largest
// box is known exactly, so that the whole program can be held against it; two_section_crash,
// ordered_crash and corridor_crash are also the plainest crash models there are.
//
// A formula computes with inputs, each a variable of the design or the same for all designs, and
// with constants, which are never part of a design. Both stand in scenario.formula in the order
// given here. x_i are all variables in the order of the file.
//
//   model              inputs                          outcomes
//   hypersphere        x_i                             distance = |x| - sqrt(n) / 2
//   ellipse            x, y                            level, 1 on the ellipse, less inside
//   linear             x_i                             row_1, row_2, ... = matrix x
//   rosenbrock         x_i                             value = sum 100 (x_{i+1} - x_i^2)^2
//                                                                  + (1 - x_i)^2
//   two_section_crash  F1 F2 mass d1 d2 speed          energy_remaining, decel_max = F2 / mass,
//                                                      order = F1 - F2
//   ordered_crash      mass speed F_1 .. F_n           energy_remaining, order_max = greatest
//                                                      F_i - F_{i+1}, decel_max = greatest F_i
//                                                      / mass
//   corridor_crash     length energy, then the forces  energy_remaining, force_max = greatest sum
//                      of path 1, of path 2, ...       over the paths
//
// energy_remaining is the kinetic energy (mass speed^2 / 2, or `energy`) less what the structure
// takes: force times length summed over its sections, or along each path by the trapezoid rule with
// `rows` points evenly over `length`.
#ifndef SOBOX_COMMON_SCENARIO_FORMULA_H
#define SOBOX_COMMON_SCENARIO_FORMULA_H

#include "common/scenario/scenario.h"

enum { FORMULA_ELLIPSE_X, FORMULA_ELLIPSE_Y, FORMULA_ELLIPSE_INPUT_COUNT };

enum {
    FORMULA_ELLIPSE_CENTER_X,
    FORMULA_ELLIPSE_CENTER_Y,
    FORMULA_ELLIPSE_SEMI_AXIS_1, // > 0, along the direction of the angle
    FORMULA_ELLIPSE_SEMI_AXIS_2, // > 0, across it
    FORMULA_ELLIPSE_ANGLE_DEG,   // [degrees] from x to the first semi-axis, counter-clockwise
    FORMULA_ELLIPSE_CONSTANT_COUNT,
};

// The constants of the linear model are its matrix, row by row: formula.rows x input_count.

enum {
    FORMULA_TWO_SECTION_F1,    // [N]
    FORMULA_TWO_SECTION_F2,    // [N]
    FORMULA_TWO_SECTION_MASS,  // [kg]
    FORMULA_TWO_SECTION_D1,    // [m]
    FORMULA_TWO_SECTION_D2,    // [m]
    FORMULA_TWO_SECTION_SPEED, // [m/s]
    FORMULA_TWO_SECTION_INPUT_COUNT,
};

// The constants of the ordered crash are the lengths of its sections [m], at least two.
enum {
    FORMULA_ORDERED_MASS,  // [kg]
    FORMULA_ORDERED_SPEED, // [m/s]
    FORMULA_ORDERED_FORCE, // [N] of section 1; section i follows at FORMULA_ORDERED_FORCE + i - 1
};

enum {
    FORMULA_CORRIDOR_LENGTH, // [m]
    FORMULA_CORRIDOR_ENERGY, // [J]
    FORMULA_CORRIDOR_FORCE,  // [N] path j, point k at FORMULA_CORRIDOR_FORCE + j x rows + k
};

enum formula_two_section_outcome {
    FORMULA_TWO_SECTION_ENERGY_REMAINING,
    FORMULA_TWO_SECTION_DECEL_MAX,
    FORMULA_TWO_SECTION_ORDER,
};
enum formula_ordered_outcome {
    FORMULA_ORDERED_ENERGY_REMAINING,
    FORMULA_ORDERED_ORDER_MAX,
    FORMULA_ORDERED_DECEL_MAX,
};
enum formula_corridor_outcome {
    FORMULA_CORRIDOR_ENERGY_REMAINING,
    FORMULA_CORRIDOR_FORCE_MAX,
};

// How many outcomes the scenario's formula has. The scenario is one of a model in closed form here
// and below, without cases.
uint32_t formula_outcome_count(const struct scenario *scenario);

// The outcome's name and unit, as scenario_outcome_name() and scenario_outcome_unit().
const char *formula_outcome_name(const struct scenario *scenario, uint32_t outcome,
                                 char name[SCENARIO_OUTCOME_NAME_SIZE]);
const char *formula_outcome_unit(const struct scenario *scenario, uint32_t outcome);

// How large the outcome's terms get in the design space: what its violations are measured by where
// the bounds are zero and give no measure. Above 0 and finite.
double formula_outcome_scale(const struct scenario *scenario, uint32_t outcome);

#endif
