#include "coordinator/search/balance.h"

#include <assert.h>
#include <glib.h>

static const double balance_reach = 0.25;   // of the width: how deep a side is felt
static const double balance_evidence = 40;  // bad samples that move the sides by half the gain
static const double balance_move_max = 0.1; // of the width, in one step

// How a side's gain follows its pushes: over some seven steps, by at most a factor of four.
static const double balance_memory = 0.15;
static const double balance_eagerness = 0.7;
static const double balance_eager_min = 0.25;
static const double balance_eager_max = 4;

// The volume's gain rises likewise while a box is far too small or large, and falls back to what
// was asked for when it has come near.
static const double balance_volume_eagerness = 1.5;
static const double balance_volume_doubt = 0.15; // agreement that leaves the gain as it is

void balance_init(struct balance *balance, uint32_t variables)
{
    const size_t sides = 2 * (size_t)variables + 1;
    balance->variables = variables;
    balance->push = g_new0(double, sides);
    balance->eager = g_new(double, sides);
    balance->sums = g_new(double, sides);
    for (size_t side = 0; side < sides; side++)
        balance->eager[side] = 1;
    balance->volume_eager = 1;
    balance->volume_push = 0;
}

void balance_fini(struct balance *balance)
{
    g_free(balance->push);
    g_free(balance->eager);
    g_free(balance->sums);
    *balance = (struct balance){0};
}

static double clamp(double value, double least, double most)
{
    return value < least ? least : value > most ? most : value;
}

// Sums of the bad samples' weights along the lower and the upper side of a variable. A sample at
// the side weighs 1, one `balance_reach` inside 0.
static void weigh(const double *column, uint32_t count, double lower, double upper, double sums[2])
{
    const double reach = balance_reach * (upper - lower);
    sums[0] = sums[1] = 0;
    if (!(reach > 0))
        return;
    for (uint32_t i = 0; i < count; i++) {
        const double above = column[i] - lower;
        const double below = upper - column[i];
        sums[0] += above < reach ? 1 - above / reach : 0;
        sums[1] += below < reach ? 1 - below / reach : 0;
    }
}

// The mean weight of the sides that can move both ways.
static double mean_weight(const struct box *box, const struct box *space, const double *sums)
{
    double sum = 0;
    uint32_t sides = 0;
    for (uint32_t v = 0; v < box->count; v++) {
        if (box->lower[v] > space->lower[v]) {
            sum += sums[2 * v];
            sides++;
        }
        if (box->upper[v] < space->upper[v]) {
            sum += sums[2 * v + 1];
            sides++;
        }
    }
    return sides > 0 ? sum / sides : 0;
}

// What the mean of the bad samples' weights would be for a side of each variable if it were worth
// its place; NULL where that is the mean of all sides.
static double *worth(const struct box *box, const struct box *space, double mean,
                     const struct balance_step *step)
{
    if (step->weights == NULL)
        return NULL;
    double sum = 0;
    uint32_t sides = 0;
    for (uint32_t v = 0; v < box->count; v++) {
        const uint32_t free = (box->lower[v] > space->lower[v]) + (box->upper[v] < space->upper[v]);
        sum += free * step->weights[v];
        sides += free;
    }
    // What bad samples anywhere in the box would give.
    const double even = step->bad->count * balance_reach / 2;
    const double excess = sum > 0 && mean > even ? (mean - even) * sides / sum : 0;
    double *targets = g_new(double, box->count + 1);
    for (uint32_t v = 0; v < box->count; v++)
        targets[v] = (mean < even ? mean : even) + step->weights[v] * excess;
    return targets;
}

// Notes a push on a side and returns the factor for its gain.
static double eagerness(struct balance *balance, uint32_t side, double push)
{
    push = clamp(push, -1, 1);
    const double agreement = clamp(push * balance->push[side], -0.5, 0.5);
    balance->push[side] += balance_memory * (push - balance->push[side]);
    balance->eager[side] = clamp(balance->eager[side] * (1 + balance_eagerness * agreement),
                                 balance_eager_min, balance_eager_max);
    return balance->eager[side];
}

// Notes by how much the step lacked bad samples and returns the factor for the volume's gain. About
// where the box comes to rest the lack changes its sign, and its mean is small.
static double volume_eagerness(struct balance *balance, double lack, double most)
{
    const double agreement = clamp(lack * balance->volume_push, -0.5, 0.5) - balance_volume_doubt;
    balance->volume_push += balance_memory * (clamp(lack, -1, 1) - balance->volume_push);
    balance->volume_eager =
        clamp(balance->volume_eager * (1 + balance_volume_eagerness * agreement), 1, most);
    return balance->volume_eager;
}

void balance_move(struct balance *balance, struct box *box, const struct box *space,
                  const struct balance_step *step)
{
    assert(box->count == space->count && box->count == balance->variables && step->samples > 0);
    const uint32_t variables = box->count;
    const uint32_t bad = step->bad->count;
    double *sums = balance->sums;
#pragma omp parallel for num_threads(step->threads) if ((size_t)bad * variables > 100000)
    for (uint32_t v = 0; v < variables; v++)
        weigh(cloud_column(step->bad, v), bad, box->lower[v], box->upper[v], sums + 2 * v);
    const double mean = mean_weight(box, space, sums);
    double *targets = worth(box, space, mean, step);
    // Few bad samples say little about where they come from.
    const double evidence = bad / (bad + balance_evidence);
    const double share = (double)step->bad_count / step->samples;
    // Linear in the share, so that noise does not shift where it comes to rest.
    const double lack = (step->bad_share - share) / (step->bad_share + 1.0 / step->samples);
    const double volume_gain =
        step->volume_gain * volume_eagerness(balance, lack, step->volume_eager_max);
    const double out = volume_gain / (2.0 * variables) * clamp(lack, -1.5, 1);
    for (uint32_t v = 0; v < variables; v++) {
        const double width = box->upper[v] - box->lower[v];
        double move[2];
        for (uint32_t i = 0; i < 2; i++) {
            const double target = targets != NULL ? targets[v] : mean;
            const double push = mean > 0 ? evidence * (sums[2 * v + i] / target - 1) : 0;
            const double gain = step->gain * eagerness(balance, 2 * v + i, push);
            move[i] = clamp(out - gain * push, -balance_move_max, balance_move_max) * width;
        }
        box->lower[v] = clamp(box->lower[v] - move[0], space->lower[v], space->upper[v]);
        box->upper[v] = clamp(box->upper[v] + move[1], space->lower[v], space->upper[v]);
    }
    g_free(targets);
}
