// The few statistics a certificate needs.
#ifndef SOBOX_COMMON_NUMERIC_STATISTICS_H
#define SOBOX_COMMON_NUMERIC_STATISTICS_H

#include <stdint.h>

// The one-sided Clopper-Pearson lower bound of a share: with probability `confidence` the true
// share of good designs is at least this when `bad` of `samples` independent ones were bad.
// 100 samples without a bad one give 0.9705 at 0.95, 299 give 0.99. Returns 0 when all are bad or
// there is no sample. 0 < confidence < 1, bad <= samples.
double statistics_share_lower(uint64_t samples, uint64_t bad, double confidence);

#endif
