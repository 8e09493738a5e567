// A run of one scenario with several seeds: which of its boxes is the result, and by how much its
// bounds would differ had another seed been drawn.
//
//     seed=1   |------[=======]---|          best: of those that are done the largest box
//     seed=2   |-----[=======]----|          spread of a bound: its standard deviation over
//     seed=3   |------[======]----|          all searches that found corridors
//
// A bound is worth no more digits than its spread leaves it.
#ifndef SOBOX_COORDINATOR_REPORT_SEEDS_H
#define SOBOX_COORDINATOR_REPORT_SEEDS_H

#include "coordinator/report/run_data.h"

struct seeds {
    uint32_t best;           // index of the search; 0 where none has corridors
    uint32_t searches;       // that have corridors and are finished
    double log_volume;       // of the best
    double log_volume_mean;  // over them
    double log_volume_least; //
    double log_volume_spread;
    struct box spread; // of each bound, in the variable's unit; NAN where fewer than two searches
                       // say; count 0: no search has corridors
};

// Whether the searches of a run differ in their seed alone.
bool seeds_alone(const struct run_data *data);

// Reads all searches of such a run. The caller releases it. Errors: STATUS_IO.
enum status seeds_read(const struct run_data *data, struct seeds *seeds,
                       struct error *error) MUST_USE;

// Releases what it owns. A zeroed struct is fine.
void seeds_fini(struct seeds *seeds);

// The search that a run of any kind shows where none is asked for: of seeds the best, else the
// first. Errors: STATUS_IO.
enum status seeds_shown(const struct run_data *data, uint32_t *index, struct error *error) MUST_USE;

// How many decimals a number is worth whose spread this is: the last one is no smaller than the
// spread. At most `most`; below zero the last digits before the point are worth nothing.
int seeds_decimals(double spread, int most);

#endif
