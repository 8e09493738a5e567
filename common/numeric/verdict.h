// What the search needs to know of one simulated design: good, or which constraint it violates most
// and how badly. 3 bytes a bad sample on the wire, 1 bit a good one.
//
// The violation is relative: (bound - value) / scale of the constraint, see design.md section 6.
// It is kept on a fixed scale, the exponent and the 8 leading mantissa bits of its IEEE single
// (bits 15..30), which orders as the number does, needs no logarithm, and is the same on every
// machine. A non-finite outcome has the greatest violation there is.
#ifndef SOBOX_COMMON_NUMERIC_VERDICT_H
#define SOBOX_COMMON_NUMERIC_VERDICT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    VERDICT_GOOD = 0,           // the violation of a good sample
    VERDICT_NON_FINITE = 65535, // the violation of a sample with a non-finite outcome
};

struct verdict {
    uint16_t violation; // VERDICT_GOOD, or 1..VERDICT_NON_FINITE: greater is worse
    uint8_t constraint; // index of the worst violated constraint; 0 where good
    float margin;       // with VERDICT_DETAIL_MARGIN: how far inside its bound, in the constraint's
                        // own scale, the outcome lies that was asked for; below 0 outside
};

// How much of each verdict travels.
enum verdict_detail {
    VERDICT_DETAIL_FULL,   // good or bad, constraint and violation: for trimming
    VERDICT_DETAIL_SHARE,  // good or bad only: for certificates; bad ones unpack as constraint 0,
                           // violation 1
    VERDICT_DETAIL_MARGIN, // as in full, and the margin of each sample: for adversarial search
    VERDICT_DETAIL_COUNT
};

// Puts a relative violation on the scale. Not above 0 (a bound that is not there gives -infinity):
// VERDICT_GOOD. Above 0: at least 1. NaN or +infinity: VERDICT_NON_FINITE.
uint16_t verdict_violation(double relative);

// The relative violation in the middle of the step of the scale that `violation` names; 0 for
// VERDICT_GOOD, infinite for VERDICT_NON_FINITE.
double verdict_relative(uint16_t violation);

// The greatest number of bytes that `count` verdicts pack into.
size_t verdict_packed_size_max(uint32_t count, enum verdict_detail detail);

// Packs `count` verdicts: a bit a sample (1 is good, sample 0 in the lowest bit of byte 0, unused
// bits 0), then with VERDICT_DETAIL_MARGIN the margin of each (4 bytes, an IEEE single, low first),
// then with it and with VERDICT_DETAIL_FULL for each bad one in order its constraint (1 byte) and
// its violation (2 bytes, low first). Returns the bytes written to `packed`, which has room for
// verdict_packed_size_max().
size_t verdict_pack(const struct verdict *verdicts, uint32_t count, enum verdict_detail detail,
                    uint8_t *packed);

// The inverse. Returns false, with `verdicts` (count) untouched, when `packed` is not exactly what
// verdict_pack() writes for `count` verdicts: wrong size, set unused bits, a constraint not below
// `constraint_count`, a bad one with VERDICT_GOOD, a margin that is no number. It trusts nothing it
// is given.
bool verdict_unpack(struct verdict *verdicts, uint32_t count, enum verdict_detail detail,
                    uint32_t constraint_count, const uint8_t *packed, size_t packed_size);

// How many of `count` verdicts are good.
uint32_t verdict_good_count(const struct verdict *verdicts, uint32_t count);

#endif
