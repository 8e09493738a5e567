#include "coordinator/search/ranking.h"

#include <math.h>
#include <string.h>

enum {
    CROWD = 24, // up to so many a plain insertion is fastest
    DIGIT_BITS_MAX = 11,
};

static void insert_all(uint32_t *order, uint32_t count, const double *key)
{
    for (uint32_t i = 1; i < count; i++) {
        const uint32_t index = order[i];
        uint32_t place = i;
        for (; place > 0 && key[order[place - 1]] > key[index]; place--)
            order[place] = order[place - 1];
        order[place] = index;
    }
}

// Turns numbers of keys a digit has into the places where they start.
static void places_of(uint32_t *counts, uint32_t digits)
{
    uint32_t place = 0;
    for (uint32_t digit = 0; digit < digits; digit++) {
        const uint32_t count = counts[digit];
        counts[digit] = place;
        place += count;
    }
}

// Sorts by cell: pairs of cell (high half) and index go to `pairs`, in order.
static void sort_cells(const uint32_t *order, uint32_t count, const double *key, double least,
                       double scale, uint32_t bits, uint64_t *pairs, uint64_t *other)
{
    const uint32_t digits = 1U << bits;
    const int32_t last = (int32_t)(digits * digits - 1);
    uint32_t low[1 << DIGIT_BITS_MAX];
    uint32_t high[1 << DIGIT_BITS_MAX];
    memset(low, 0, digits * sizeof *low);
    memset(high, 0, digits * sizeof *high);
    for (uint32_t i = 0; i < count; i++) {
        const int32_t found = (int32_t)((key[order[i]] - least) * scale);
        const uint32_t cell = (uint32_t)(found < last ? found : last);
        pairs[i] = (uint64_t)cell << 32 | order[i];
        low[cell & (digits - 1)]++;
        high[cell >> bits]++;
    }
    places_of(low, digits);
    places_of(high, digits);
    for (uint32_t i = 0; i < count; i++)
        other[low[(pairs[i] >> 32) & (digits - 1)]++] = pairs[i];
    for (uint32_t i = 0; i < count; i++)
        pairs[high[other[i] >> (32 + bits)]++] = other[i];
}

// A crowded cell, spread over cells of its own. Least and most then lie in different ones, so every
// round parts something.
static void sort_crowd(uint32_t *order, uint32_t count, const double *key, uint64_t *pairs,
                       uint64_t *other);

static void sort(uint32_t *order, uint32_t count, const double *key, double least, double most,
                 uint64_t *pairs, uint64_t *other)
{
    const uint32_t bits = count < 128 ? 4 : count < 1024 ? 6 : count < 32768 ? 8 : DIGIT_BITS_MAX;
    const double scale = (double)(1U << 2 * bits) / (most - least);
    if (count <= CROWD || !(scale > 0) || !isfinite(scale)) {
        insert_all(order, count, key);
        return;
    }
    sort_cells(order, count, key, least, scale, bits, pairs, other);
    for (uint32_t i = 0; i < count; i++)
        order[i] = (uint32_t)pairs[i];
    uint32_t end;
    for (uint32_t first = 0; first < count; first = end) {
        for (end = first + 1; end < count && pairs[end] >> 32 == pairs[first] >> 32;)
            end++;
        if (end - first > CROWD)
            sort_crowd(order + first, end - first, key, pairs + first, other + first);
        else if (end - first > 1)
            insert_all(order + first, end - first, key);
    }
}

static void sort_crowd(uint32_t *order, uint32_t count, const double *key, uint64_t *pairs,
                       uint64_t *other)
{
    double least = key[order[0]];
    double most = least;
    for (uint32_t i = 1; i < count; i++) {
        least = fmin(least, key[order[i]]);
        most = fmax(most, key[order[i]]);
    }
    if (least < most)
        sort(order, count, key, least, most, pairs, other);
}

void ranking_sort(uint32_t *order, uint32_t count, const double *key, double least, double most,
                  uint64_t *scratch)
{
    sort(order, count, key, least, most, scratch, scratch + count);
}
