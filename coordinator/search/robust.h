// The search for a box without a bad design: cutting sets from several starts, of which the better
// ones go on.
//
//     starts   o o o o o o   two fifths of the steps, in equal parts
//              o     o   o   one fifth, in equal parts
//                    o       the rest
//
// One start may end between a box that lets the car rotate and one that lets it glance off; which
// of them holds more is known only when both have grown.
#ifndef SOBOX_COORDINATOR_SEARCH_ROBUST_H
#define SOBOX_COORDINATOR_SEARCH_ROBUST_H

#include "coordinator/search/cloud.h"
#include "coordinator/search/cutting_set.h"

struct robust {
    struct cutting_set *sets; // (count) those that are left first
    uint32_t count;
    uint32_t left;                  // that go on
    uint32_t round;                 // 0, 1 or 2: the last one
    uint32_t current;               // whose turn it is
    uint32_t turns;                 // steps of each set in this round
    uint32_t turn;                  // steps of the round finished by all sets
    uint32_t steps;                 // of all rounds
    uint32_t refined;               // sets so far that came down in the last round
    struct adversary_report report; // of the last step
};

// Starts around each of `starts` (designs of the free variables) and with the whole design space,
// with `steps` in all (at least one a start). What is pointed at is borrowed. The caller releases
// it with robust_fini().
void robust_init(struct robust *robust, const struct frame *frame, const struct demands *demands,
                 const struct curve_map *curves, uint32_t constraints, uint32_t samples,
                 uint64_t seed, const struct cloud *starts, uint32_t steps);

// The same with one set alone that starts with `box`, and no steps: what there is, is attacked.
void robust_init_one(struct robust *robust, const struct frame *frame,
                     const struct demands *demands, const struct curve_map *curves,
                     uint32_t constraints, uint32_t samples, uint64_t seed, const struct box *box);

// Releases it. A zeroed struct is fine.
void robust_fini(struct robust *robust);

// The cutting set whose trial is to be attacked next.
struct cutting_set *robust_current(const struct robust *robust);

// Takes the verdicts of the attack; true when all steps are spent: the current set is the best.
bool robust_complete(struct robust *robust, const struct sampling *sampling,
                     const struct verdict *verdicts);

#endif
