// Reads how to search. Lists of numbers, one a variable, are written in four ways:
//
//     start: 0.5                                   the same for all
//     start: [0.5, 0.25, 0.1]                      in the order of the variables
//     start: {F1: 300e3, F2: 500e3}                by variable
//     start: {front: 100e3}                        by spring: all its forces; by spring and
//     start: {front.force_x: [0, 100e3, 200e3]}    direction: a number, or one for each point;
//                                                  and single forces, 'front.force_x[2]'
//
// The complete form of each key:
//
//     search:
//       starts: 4                                  # how many, and with which to begin:
//       start: centre                              # the middle of the design space, or numbers
//       start_box: {lower: ..., upper: ...}        # numbers each
//       evaluations: 40000                         # in all
//       weights: {F1: 2}                           # 1 for those not named
//       minimum_widths: {F1: 50e3}                 # 0 for those not named
//       hold: {lower: {F1: 200e3}, upper: {F2: 600e3, F1: 200e3}}   # others move
//       reference: ...                             # as start
//       tie: [[rail-left, rail-right], [F1, F2]]   # springs, spring.direction, or variables
#ifndef SOBOX_COMMON_SCENARIO_SEARCH_READ_H
#define SOBOX_COMMON_SCENARIO_SEARCH_READ_H

#include "common/scenario/scenario.h"
#include "common/scenario/tree.h"

// Fills scenario.search from the mapping `node`. Variables, design space and springs are known.
// Returns false with `error` filled (STATUS_INVALID).
bool search_read(const struct tree_node *node, struct scenario *scenario, struct error *error);

#endif
