#include "coordinator/search/balance.h"

#include <assert.h>
#include <glib.h>

static const double balance_reach = 0.25;   // of the width: how deep a side is felt
static const double balance_evidence = 40;  // bad samples that move the sides by half the gain
static const double balance_move_max = 0.1; // of the width, in one step

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

static double clamp(double value, double least, double most)
{
    return value < least ? least : value > most ? most : value;
}

void balance(struct box *box, const struct box *space, const struct balance_step *step)
{
    assert(box->count == space->count && step->samples > 0);
    const uint32_t variables = box->count;
    const uint32_t bad = step->bad->count;
    double *sums = g_new(double, 2 * (size_t)variables + 1);
#pragma omp parallel for num_threads(step->threads) if ((size_t)bad * variables > 100000)
    for (uint32_t v = 0; v < variables; v++)
        weigh(cloud_column(step->bad, v), bad, box->lower[v], box->upper[v], sums + 2 * v);
    const double mean = mean_weight(box, space, sums);
    // Few bad samples say little about where they come from.
    const double gain = step->gain * bad / (bad + balance_evidence);
    const double share = (double)bad / step->samples;
    const double wanted = step->bad_share;
    const double out = step->volume_gain / (2.0 * variables) * (wanted - share) /
                       (wanted + share + 1.0 / step->samples);
    for (uint32_t v = 0; v < variables; v++) {
        const double width = box->upper[v] - box->lower[v];
        double move[2];
        for (int i = 0; i < 2; i++) {
            const double excess = mean > 0 ? sums[2 * v + i] / mean - 1 : 0;
            move[i] = clamp(out - gain * excess, -balance_move_max, balance_move_max) * width;
        }
        box->lower[v] = clamp(box->lower[v] - move[0], space->lower[v], space->upper[v]);
        box->upper[v] = clamp(box->upper[v] + move[1], space->lower[v], space->upper[v]);
    }
    g_free(sums);
}
