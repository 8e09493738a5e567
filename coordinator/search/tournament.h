// Which start is worth exploring: a box grows from each for some steps, the better half goes on,
// and so forth until one is left, which has all remaining steps. Boxes take turns, one step each at
// a time of a round, so that a search is still one sequence of steps.
//
// A start alone is not enough: where two kinds of good designs lie apart, a box that grows from the
// one may never see the other.
#ifndef SOBOX_COORDINATOR_SEARCH_TOURNAMENT_H
#define SOBOX_COORDINATOR_SEARCH_TOURNAMENT_H

#include "coordinator/search/explore.h"

enum {
    TOURNAMENT_STARTS = 6,       // unless others are asked for
    TOURNAMENT_START_STEPS = 20, // of exploration for each start beyond the first
    TOURNAMENT_GROW_STEPS = 5,   // of each box until the next decision
    TOURNAMENT_FEW = 4,          // boxes; with more of them
    TOURNAMENT_MANY_STEPS = 3,   // steps until the next decision
};

struct tournament {
    const struct demands *demands; // borrowed, set before the start; NULL: none
    struct explore *explores;      // (count) one for each start
    uint32_t count;
    uint32_t *left; // (left_count of count) indexes of the boxes that are still in, best first
    uint32_t left_count;
    uint32_t turn;          // place in `left` of the box whose step is next
    uint32_t turn_steps;    // steps it has left before the next one's turn
    uint32_t steps;         // of all boxes, finished
    uint32_t step_count;    // to be spent in all
    uint32_t growing_steps; // of all boxes together; then those that have grown are balanced
};

// How many starts are worth trying with so many steps of exploration: never one alone.
uint32_t tournament_starts(uint32_t step_count);

// Lines up a box for each of `starts` (at least 1). The tournament is
// zeroed before, but for its demands; the caller releases it with tournament_fini(). `space` is
// borrowed.
void tournament_start(struct tournament *tournament, const struct box *space,
                      const struct cloud *starts, uint32_t step_count);

// A tournament that is over before it starts: `box` has won.
void tournament_award(struct tournament *tournament, const struct box *space,
                      const struct box *box);

// Releases a tournament. A zeroed struct is fine.
void tournament_fini(struct tournament *tournament);

// The box whose step is next; NULL before the start.
struct explore *tournament_current(struct tournament *tournament);

// Takes the verdicts on tournament_current()->sampled. Returns whether all steps are spent; then
// the best box is the only one left.
bool tournament_complete(struct tournament *tournament, const struct explore_step *step);

#endif
