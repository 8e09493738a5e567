// How what is implausible is written down: for the files that check, and nobody else.
#ifndef SOBOX_COMMON_SCENARIO_PLAUSIBILITY_FIND_H
#define SOBOX_COMMON_SCENARIO_PLAUSIBILITY_FIND_H

#include "common/scenario/plausibility.h"

enum { PLAUSIBILITY_HINT_SIZE = 160 }; // [bytes] of a likely slip in words, with its NUL

// A number in another unit than the table's: what it is to be multiplied by.
struct plausibility_slip {
    const char *unit; // NULL ends a list of them
    double factor;
};

// What a check has at hand.
struct plausibility_find {
    struct scenario *scenario;
    enum plausibility_check check;
    const struct tree_node *node;          // to point at
    double value;                          // to be held against the row's limits
    bool error;                            // an error even within the limit of errors
    double given;                          // the number of the file that `value` follows from
    const struct plausibility_slip *slips; // units in which it may be given; may be NULL
    double from, to;                       // in the right one its amount lies in here
    const char *unit;                      // the right one
    const char *figures;                   // what `value` comes from, where that helps; may be NULL
    const char *hint;                      // the likely slip in words, in place of `slips`
};

// Adds a finding to the scenario if the value is outside the row's limits. Returns whether it did.
bool plausibility_find(const struct plausibility_find *find);

// Adds a copy of a finding of one of the scenario's cases, with the case's name.
void plausibility_find_copy(struct scenario *scenario, const struct scenario_finding *finding,
                            const char *case_name);

// Releases the scenario's findings and leaves it without any.
void plausibility_find_free(struct scenario *scenario);

// The checks that hold several numbers against each other. They follow when no single number is an
// error, so that one slip is told once.
void plausibility_relate(const struct crash_document *document, struct scenario *scenario);

#endif
