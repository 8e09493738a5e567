// A run folder in memory: what run.db says, checked against its scenarios, and what follows from
// it. Everything the report shows is made from this.
#ifndef SOBOX_COORDINATOR_REPORT_RUN_DATA_H
#define SOBOX_COORDINATOR_REPORT_RUN_DATA_H

#include "common/scenario/scenario.h"
#include "coordinator/journal/journal.h"

#include <glib.h>

// One finished step: a row of history.csv.
struct run_step {
    char phase[16];
    uint32_t step;
    uint32_t samples;
    uint32_t good;
    double growth;
    double log_volume;
};

// One search of the run.
struct run_data_search {
    struct scenario scenario;
    struct journal_search record; // its box is empty until it is finished
    GArray *steps;                // of struct run_step
    const char *name;             // of its case, else of its scenario
    const char *status;           // search_status_name(), or how the run stands while unfinished
    const struct box *box; // the corridors: of the result, else of the last step's samples; NULL
                           // before the first step and where no good design was found
    double log_volume;     // of the box
    uint64_t evaluations;  // samples of all finished steps
    int64_t wall_ns;

    // Of the samples whose verdict says so: how many there are, how many are bad, and for how many
    // a constraint is the one that is violated worst.
    uint64_t judged, bad;
    uint64_t worst[SCENARIO_CONSTRAINT_MAX];

    struct box last_box; // sampled last; count 0 before the first step
};

struct run_data {
    struct journal_run run;
    struct run_data_search *searches; // (run.search_count)
};

// Reads a run folder. On failure the struct is zeroed.
// Errors: those of journal_open(); STATUS_IO (run.db is damaged or contradicts its scenario).
enum status run_data_read(struct run_data *data, const char *directory,
                          struct error *error) MUST_USE;

// Releases what it owns. A zeroed struct is fine.
void run_data_fini(struct run_data *data);

// The index of the variable of a spring's discretization point and direction.
uint32_t run_data_variable(const struct run_data_search *search, uint32_t spring,
                           enum scenario_direction direction, uint32_t point);

// Whether the search ended without any good sample.
bool run_data_found_nothing(const struct run_data_search *search);

#endif
