// Certifying a box: fresh, independent, uniform samples that no trim has seen, and the
// Clopper-Pearson bound of their good share.
//
// A box that fails may be improved and tried again, and each look is a chance to pass by luck: with
// enough of them any box would. So the looks share the 5 % that an error may have: the first takes
// 4.5 % of it, each later one half of what is left. The bound of look k is taken at confidence
// 1 - alpha_k; the probability that any look certifies a box which does not deserve it is then
// at most the sum of the alpha_k, below 5 %, however the boxes were chosen (Bonferroni).
#ifndef SOBOX_COORDINATOR_SEARCH_CERTIFICATE_H
#define SOBOX_COORDINATOR_SEARCH_CERTIFICATE_H

#include <stdbool.h>
#include <stdint.h>

enum { CERTIFICATE_LOOKS = 5 }; // at most, in one search

struct certificate {
    uint32_t looks;   // taken so far
    uint64_t samples; // of the last look
    uint64_t bad;
    double lower95; // what the good share exceeds with 95 % confidence, repeated looks counted
};

// The share of the error probability that look `look` (from 0) takes.
double certificate_alpha(uint32_t look);

// Takes a look.
void certificate_look(struct certificate *certificate, uint64_t samples, uint64_t bad);

// Takes the one look at a box that nothing follows from: all of the error probability is its own.
void certificate_look_once(struct certificate *certificate, uint64_t samples, uint64_t bad);

// The most bad samples of `samples` with which the next look reaches `target`; -1 when even none is
// too many.
int64_t certificate_bad_max(const struct certificate *certificate, uint64_t samples, double target);

#endif
