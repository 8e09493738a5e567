// A run folder in memory: what run.db says, checked against its scenarios, and what follows from
// it. Everything the report shows is made from this.
#ifndef SOBOX_COORDINATOR_REPORT_RUN_DATA_H
#define SOBOX_COORDINATOR_REPORT_RUN_DATA_H

#include "common/scenario/scenario.h"
#include "coordinator/journal/journal.h"
#include "coordinator/report/reach.h"
#include "coordinator/search/certificate.h"
#include "coordinator/search/explain.h"

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
    char **values;                // of its case on the run's axes, ends with NULL
    GArray *steps;                // of struct run_step
    const char *name;             // of its case, else of its scenario
    const char *status;           // protocol_status_name(); while unfinished how the run stands, or
                                  // "waiting" or "failed" in a sweep
    const struct box *box; // the corridors: of the result, else of the last step's samples; NULL
                           // before the first step and where no good design was found
    double log_volume;     // of the box
    uint64_t evaluations;  // samples of all finished steps
    int64_t wall_ns;

    // Of the samples whose verdict says so: how many there are, how many are bad, and for how many
    // a constraint is the one that is violated worst.
    uint64_t judged, bad;
    uint64_t worst[SCENARIO_CONSTRAINT_MAX];

    // Of the first step that looked at the whole design space; 0 samples: none did.
    uint32_t space_samples, space_good;

    // The least violating sample that is not good: UINT32_MAX before there is one. Meaningful where
    // no good design was found, as the record's box is that very design then.
    uint32_t least_constraint;
    uint16_t least_violation;

    // What holds each corridor, from the samples there are; `scenario` is NULL in it where nothing
    // can be said: before there is a result, and where no good design was found.
    struct explain explain;

    struct reach reach; // what of the corridors designs reach, after run_data_find_reach()

    struct box last_box; // the search's own, sampled last; count 0 before the first step

    // What fresh designs of each kind but points showed of the corridors; no samples before.
    struct certificate kinds[DESIGN_KIND_COUNT];

    // Of the last certificate, until it is known whether an explanation follows.
    struct verdict *certificate; // (certificate_samples) NULL without details
    uint32_t certificate_samples;
};

struct run_data {
    struct journal_run run;
    char **axes;                      // paths that change from case to case, ends with NULL
    struct run_data_search *searches; // (run.search_count), or NULL: they are loaded one by one
    struct journal *journal;          // open until run_data_fini()
    char *directory;
};

// Reads a run folder. On failure the struct is zeroed.
// Errors: those of journal_open(); STATUS_IO (run.db is damaged or contradicts its scenario).
enum status run_data_read(struct run_data *data, const char *directory,
                          struct error *error) MUST_USE;

// The same without the searches, of which there may be a hundred thousand.
enum status run_data_open(struct run_data *data, const char *directory,
                          struct error *error) MUST_USE;

// Loads one search (index < run.search_count), to be released with run_data_release(). On failure
// the struct is zeroed. Errors: STATUS_IO.
enum status run_data_load(const struct run_data *data, uint32_t index,
                          struct run_data_search *search, struct error *error) MUST_USE;
void run_data_release(struct run_data_search *search);

// Finds what of its corridors designs reach, by simulating some thousand: for those who show the
// corridors point by point. Before there is a box, or where the model has no springs, nothing is
// known after it.
void run_data_find_reach(struct run_data_search *search);

// Whether the run was begun as a sweep: its searches are cases then.
bool run_data_is_sweep(const struct run_data *data);

// Releases what it owns. A zeroed struct is fine.
void run_data_fini(struct run_data *data);

// The index of the variable of a spring's discretization point and direction.
uint32_t run_data_variable(const struct run_data_search *search, uint32_t spring,
                           enum scenario_direction direction, uint32_t point);

// Whether the search ended without any good sample.
bool run_data_found_nothing(const struct run_data_search *search);

#endif
