#include "coordinator/search/tournament.h"

#include <assert.h>
#include <glib.h>

uint32_t tournament_starts(uint32_t step_count)
{
    // The first start, the middle of the good designs, may be bad.
    const uint32_t count = 1 + step_count / TOURNAMENT_START_STEPS;
    return count < 2 ? 2 : count < TOURNAMENT_STARTS ? count : TOURNAMENT_STARTS;
}

// The number of steps that each box still in has until the next decision.
static uint32_t round_steps(const struct tournament *tournament)
{
    const uint32_t fair = tournament->step_count / (4 * tournament->left_count);
    // Many boxes are told apart quickly, or steps run out. The last decision, between two, is taken
    // after they have begun to balance.
    uint32_t wanted = TOURNAMENT_GROW_STEPS;
    if (tournament->left_count > TOURNAMENT_FEW)
        wanted = TOURNAMENT_MANY_STEPS;
    else if (tournament->left_count == 2)
        wanted = 2 * TOURNAMENT_GROW_STEPS;
    return fair < 1 ? 1 : fair < wanted ? fair : wanted;
}

void tournament_start(struct tournament *tournament, const struct box *space,
                      const struct cloud *starts, uint32_t step_count)
{
    assert(starts->count >= 1);
    tournament->count = tournament->left_count = starts->count;
    tournament->explores = g_new0(struct explore, starts->count);
    tournament->left = g_new(uint32_t, starts->count);
    tournament->step_count = step_count;
    for (uint32_t i = 0; i < starts->count; i++) {
        tournament->left[i] = i;
        explore_init(&tournament->explores[i], space, starts->values + i, starts->capacity);
        if (tournament->demands != NULL)
            explore_demand(&tournament->explores[i], tournament->demands);
    }
    tournament->turn_steps = round_steps(tournament);
    tournament->growing_steps = tournament->left_count * tournament->turn_steps;
}

void tournament_award(struct tournament *tournament, const struct box *space, const struct box *box)
{
    struct cloud start;
    cloud_init(&start, space->count);
    cloud_add(&start, box->lower, 1, 0);
    tournament_start(tournament, space, &start, 0);
    explore_move(&tournament->explores[0], box);
    explore_settle(&tournament->explores[0]);
    cloud_fini(&start);
}

void tournament_fini(struct tournament *tournament)
{
    for (uint32_t i = 0; i < tournament->count; i++)
        explore_fini(&tournament->explores[i]);
    g_free(tournament->explores);
    g_free(tournament->left);
    *tournament = (struct tournament){0};
}

struct explore *tournament_current(struct tournament *tournament)
{
    return tournament->left_count == 0 ? NULL
                                       : &tournament->explores[tournament->left[tournament->turn]];
}

// Keeps the better half of the boxes. There are few, so each is moved up past the worse ones.
static void halve(struct tournament *tournament)
{
    uint32_t *left = tournament->left;
    for (uint32_t i = 1; i < tournament->left_count; i++) {
        for (uint32_t j = i; j > 0; j--) {
            if (!explore_ahead(&tournament->explores[left[j]], &tournament->explores[left[j - 1]]))
                break;
            const uint32_t worse = left[j - 1];
            left[j - 1] = left[j];
            left[j] = worse;
        }
    }
    tournament->left_count = (tournament->left_count + 1) / 2;
    tournament->turn = 0;
}

// Gives the turn to the next box; after the last one the better half stays.
static void pass_turn(struct tournament *tournament)
{
    if (--tournament->turn_steps > 0)
        return;
    if (++tournament->turn == tournament->left_count)
        halve(tournament);
    tournament->turn_steps = round_steps(tournament);
}

bool tournament_complete(struct tournament *tournament, const struct explore_step *step)
{
    explore_complete(tournament_current(tournament), step);
    tournament->steps++;
    if (tournament->left_count > 1)
        pass_turn(tournament);
    // After the first round a box that has grown is balanced: trimming on would only nibble at it.
    struct explore *next = tournament_current(tournament);
    if (tournament->steps >= tournament->growing_steps && next->grown)
        explore_settle(next);
    if (tournament->steps < tournament->step_count)
        return false;
    while (tournament->left_count > 1)
        halve(tournament);
    return true;
}
