// The corridors of variables that are no spring's force, as a gnuplot script that carries its data:
// a bar a variable, its corridor as the share of its design space, because variables of all kinds
// of units stand below each other.
//
//     title, subtitle, legend
//     F1  |    294480 [######]516720          |   grey: the design space
//     F2  |            516720 [###] 627840    |   blue: the corridor
//         0 %                             100 %   orange: the one it is compared with
#ifndef SOBOX_COORDINATOR_REPORT_BARS_H
#define SOBOX_COORDINATOR_REPORT_BARS_H

#include "coordinator/report/figure.h"

// How many variables of the other run have the name of one of this run.
uint32_t bars_shared_variables(const struct run_data_search *search,
                               const struct run_data_search *other);

// The script, as figure_script(). Compared are the variables that both runs have. With `normalise`
// the bounds are not written beside the bars; with many variables neither are they.
char *bars_script(const struct figure *figure);

#endif
