#include "coordinator/search/seek.h"

#include <assert.h>
#include <glib.h>
#include <math.h>

static const double seek_spread =
    1.05; // widening of the elite's own spread, against settling early

void seek_init(struct seek *seek, const struct box *space, uint32_t wanted)
{
    *seek = (struct seek){.space = space, .wanted = wanted};
    box_init(&seek->box, space->count);
    box_assign(&seek->box, space);
    cloud_init(&seek->good, space->count);
    cloud_init(&seek->elite, space->count);
}

void seek_fini(struct seek *seek)
{
    box_fini(&seek->box);
    cloud_fini(&seek->good);
    cloud_fini(&seek->elite);
    *seek = (struct seek){0};
}

// A bad design by its violation and where it stands.
struct candidate {
    uint16_t violation;
    uint32_t index;
    const struct cloud *cloud;
};

static int by_violation(const void *a, const void *b)
{
    const struct candidate *one = a;
    const struct candidate *two = b;
    if (one->violation != two->violation)
        return one->violation < two->violation ? -1 : 1;
    // Both lists come in the order in which samples were drawn; the older ones first.
    return one->index < two->index ? -1 : one->index > two->index;
}

// Keeps the least violated designs of the elite so far and of this round.
static void update_elite(struct seek *seek, const struct cloud *bad, uint32_t count)
{
    const uint32_t all = seek->elite.count + bad->count;
    struct candidate *candidates = g_new(struct candidate, all + 1);
    for (uint32_t i = 0; i < all; i++) {
        const bool old = i < seek->elite.count;
        const struct cloud *cloud = old ? &seek->elite : bad;
        const uint32_t place = old ? i : i - seek->elite.count;
        candidates[i] =
            (struct candidate){.violation = cloud->violation[place], .index = i, .cloud = cloud};
    }
    qsort(candidates, all, sizeof *candidates, by_violation);
    struct cloud elite;
    cloud_init(&elite, seek->space->count);
    const uint32_t old_count = seek->elite.count;
    for (uint32_t i = 0; i < all && i < count; i++) {
        const struct candidate *one = &candidates[i];
        const uint32_t place = one->cloud == bad ? one->index - old_count : one->index;
        cloud_add(&elite, one->cloud->values + place, one->cloud->capacity, one->violation);
    }
    cloud_fini(&seek->elite);
    seek->elite = elite;
    g_free(candidates);
}

// A box around the elite: in each variable its mean, give or take what a uniform distribution of
// the same mean deviation would span.
static void surround_elite(struct seek *seek)
{
    const uint32_t count = seek->elite.count;
    for (uint32_t v = 0; v < seek->space->count; v++) {
        const double *column = cloud_column(&seek->elite, v);
        double mean = 0;
        for (uint32_t i = 0; i < count; i++)
            mean += column[i] / count;
        double deviation = 0;
        for (uint32_t i = 0; i < count; i++)
            deviation += (column[i] < mean ? mean - column[i] : column[i] - mean) / count;
        const double lower = mean - 2 * seek_spread * deviation;
        const double upper = mean + 2 * seek_spread * deviation;
        seek->box.lower[v] = lower > seek->space->lower[v] ? lower : seek->space->lower[v];
        seek->box.upper[v] = upper < seek->space->upper[v] ? upper : seek->space->upper[v];
    }
}

// A tenth of a round, but enough to have a spread.
static uint32_t elite_count(uint32_t samples)
{
    uint32_t count = samples / 10;
    if (count > SEEK_ELITE_MAX)
        count = SEEK_ELITE_MAX;
    return count < 5 ? 5 : count;
}

void seek_note(struct seek *seek, const struct cloud *good, const struct cloud *bad,
               uint32_t samples)
{
    cloud_add_inside(&seek->good, good, seek->space);
    update_elite(seek, bad, elite_count(samples));
}

void seek_complete(struct seek *seek, const struct cloud *good, const struct cloud *bad,
                   uint32_t samples)
{
    assert(seek->state == SEEK_LOOKING);
    seek_note(seek, good, bad, samples);
    seek->round++;
    const bool near = seek->round > SEEK_WHOLE_ROUNDS;
    if (seek->good.count >= (near ? 1 : seek->wanted)) {
        seek->state = SEEK_FOUND;
    } else if (seek->round >= SEEK_WHOLE_ROUNDS) {
        if (seek->good.count > 0)
            seek->state = SEEK_FOUND;
        else if (seek->round >= SEEK_WHOLE_ROUNDS + SEEK_NEAR_ROUNDS)
            seek->state = SEEK_FAILED;
        else
            surround_elite(seek);
    }
}

// Squared distance of two good designs in units of the design space.
static double apart(const struct seek *seek, uint32_t one, const double *two, size_t stride)
{
    double sum = 0;
    for (uint32_t v = 0; v < seek->space->count; v++) {
        const double whole = seek->space->upper[v] - seek->space->lower[v];
        const double difference = (cloud_column(&seek->good, v)[one] - two[v * stride]) / whole;
        sum += difference * difference;
    }
    return sum;
}

// The mean of the good designs.
static double *middle_of(const struct seek *seek)
{
    const uint32_t variables = seek->space->count;
    double *mean = g_new0(double, variables + 1);
    for (uint32_t v = 0; v < variables; v++) {
        for (uint32_t i = 0; i < seek->good.count; i++)
            mean[v] += cloud_column(&seek->good, v)[i] / seek->good.count;
    }
    return mean;
}

// Lowers `nearest`, the distances of all good designs from the points chosen so far, for one more.
static void come_nearer(const struct seek *seek, double *nearest, const double *point,
                        size_t stride)
{
    for (uint32_t i = 0; i < seek->good.count; i++) {
        const double distance = apart(seek, i, point, stride);
        nearest[i] = distance < nearest[i] ? distance : nearest[i];
    }
}

// The point that comes `rank` places behind the first when points are ordered by distance; ties go
// by index.
static uint32_t ranked_point(const double *distance, uint32_t count, uint32_t rank)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t before = 0;
        for (uint32_t j = 0; j < count; j++)
            before += distance[j] < distance[i] || (distance[j] == distance[i] && j < i);
        if (before == rank)
            return i;
    }
    return count - 1;
}

static void fill_infinite(double *values, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        values[i] = INFINITY;
}

void seek_starts(const struct seek *seek, uint32_t count, struct cloud *starts)
{
    const struct cloud *good = &seek->good;
    if (good->count == 0 || count == 0)
        return;
    double *middle = middle_of(seek);
    double *nearest = g_new(double, good->count);
    if (good->count > 1 && count > 1) {
        cloud_add(starts, middle, 1, 0);
        count--;
    }
    for (uint32_t i = 0; i < good->count; i++)
        nearest[i] = apart(seek, i, middle, 1);
    // The first is the one nearest to the middle, the second half-way out, the others are far from
    // all before them.
    for (uint32_t done = 0; done < count && done < good->count; done++) {
        const uint32_t rank = done == 0 ? 0 : done == 1 ? good->count / 2 : good->count - 1;
        const double *point = good->values + ranked_point(nearest, good->count, rank);
        cloud_add(starts, point, good->capacity, 0);
        if (done == 0)
            fill_infinite(nearest, good->count);
        come_nearer(seek, nearest, point, good->capacity);
    }
    g_free(nearest);
    g_free(middle);
}
