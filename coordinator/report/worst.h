// The worst design that an adversarial search found in the corridors: how near it comes to a
// constraint, and the design itself as a file for sobox-simulate.
#ifndef SOBOX_COORDINATOR_REPORT_WORST_H
#define SOBOX_COORDINATOR_REPORT_WORST_H

#include "coordinator/report/run_data.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

struct worst {
    bool known;
    uint32_t constraint; // that it is nearest to, or violates most
    double value;        // its outcome there, in the outcome's unit
    double margin; // how far inside, in the constraint's own scale; below 0: the design is bad
};

// Simulates the worst design of a search's result; of one that has none nothing is known.
void worst_find(struct worst *worst, const struct run_data_search *search);

// One line of the table, where it is known.
void worst_print(const struct run_data_search *search, bool normalise, FILE *out);

// For result.json: null where it is not known.
json_t *worst_json(const struct run_data_search *search);

// Writes the design: of the crash model as sobox-simulate --design takes it, of others a table as
// sobox-coordinator --evaluate takes it.
void worst_write(const struct run_data_search *search, FILE *csv);

#endif
