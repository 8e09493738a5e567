// A duration that is measured again and again, and a bound it seldom exceeds: the smoothed mean
// plus four smoothed deviations, as TCP computes its retransmission timer (RFC 6298, section 2:
// "RTO <- SRTT + max (G, K*RTTVAR)", K = 4).
#ifndef SOBOX_COORDINATOR_SCHEDULE_ESTIMATE_H
#define SOBOX_COORDINATOR_SCHEDULE_ESTIMATE_H

#include <stdbool.h>

struct estimate {
    double mean;      // in the unit of what is measured
    double deviation; // mean absolute deviation, same unit
    bool measured;    // at least once
};

// Takes a measurement in, of which no more counts than twice the bound, or `least` if that is more:
// one hiccup then does not make the estimate useless for the next twenty measurements, and what
// has really become longer doubles it each time. Weight 1/8 for the mean, 1/4 for the deviation;
// the first one sets the mean and half of it as deviation.
void estimate_add(struct estimate *estimate, double value, double least);

// mean + 4 x deviation; 0 where nothing was measured.
double estimate_bound(const struct estimate *estimate);

#endif
