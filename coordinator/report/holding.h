// What holds each corridor, in words and as JSON: made from the samples just outside the bounds
// (explain.h) for the table, for result.json and for documents.
#ifndef SOBOX_COORDINATOR_REPORT_HOLDING_H
#define SOBOX_COORDINATOR_REPORT_HOLDING_H

#include "coordinator/report/run_data.h"

#include <jansson.h>
#include <stdio.h>

// A constraint as an engineer writes it: "s_L >= 0.25 m", "-20 <= yaw_deg <= 20 deg"; with
// `normalise`, as below, without its limits. The caller frees it.
char *holding_constraint(const struct scenario *scenario, uint32_t constraint, bool normalise);

// The constraint of which relaxing it by 1 % gains most, in words with the gain; NULL where that is
// not known. The caller frees it.
char *holding_costliest(const struct run_data_search *search);

// Prints how many bounds each constraint holds and what relaxing it would gain. Nothing is printed
// where nothing is known.
void holding_print_summary(const struct run_data_search *search, bool normalise, FILE *out);

// Prints what holds the lower and the upper bound of each variable. The same. With `normalise`
// deformations are shares of the spring's.
void holding_print_bounds(const struct run_data_search *search, bool normalise, FILE *out);

// What holds a bound as a JSON object, or null.
json_t *holding_json_bound(const struct run_data_search *search, uint32_t variable, bool upper);

// The constraints, what each holds and what relaxing it would gain, as a JSON array.
json_t *holding_json_constraints(const struct run_data_search *search);

// Without a good design: the least violating one, and what it misses by how much; else null.
json_t *holding_json_least(const struct run_data_search *search);

// The same in words, as lines of the table.
void holding_print_least(const struct run_data_search *search, bool normalise, FILE *out);

#endif
