// The searches of the simulated cluster: small ones, so that a storm takes milliseconds, and what
// they give when one process does everything: the digests that every storm must reproduce.
#ifndef SOBOX_TESTS_CLUSTER_PROBLEM_H
#define SOBOX_TESTS_CLUSTER_PROBLEM_H

#include "common/numeric/digest.h"
#include "common/scenario/scenario.h"

enum { PROBLEM_SEARCHES = 4 }; // of a run, at most

struct problem {
    struct scenario scenarios[PROBLEM_SEARCHES];
    struct digest digests[PROBLEM_SEARCHES]; // of the calm run's results
    uint64_t samples[PROBLEM_SEARCHES];      // the calm run's evaluations
};

void problem_init(struct problem *problem);
void problem_fini(struct problem *problem);

#endif
