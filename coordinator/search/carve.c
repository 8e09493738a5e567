#include "coordinator/search/carve.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

// One side more keeps the point out.
static uint64_t out_of(uint32_t side)
{
    return UINT64_C(1) << 32 | side;
}

static bool out_by_one(uint64_t out)
{
    return out >> 32 == 1;
}

void carve_points_init(struct carve_points *points, const struct cloud *cloud, int threads)
{
    enum { TILE = 16 };
    const uint32_t variables = cloud->variables;
    points->cloud = cloud;
    points->rows = g_new(double, (size_t)cloud->count *variables + 1);
    // In tiles, so that both sides of the transposition stay in the cache.
#pragma omp parallel for num_threads(threads) if ((size_t)cloud->count * variables > 100000)
    for (uint32_t first = 0; first < cloud->count; first += TILE) {
        const uint32_t end = cloud->count - first < TILE ? cloud->count : first + TILE;
        for (uint32_t v = 0; v < variables; v++) {
            const double *column = cloud_column(cloud, v);
            for (uint32_t i = first; i < end; i++)
                points->rows[(size_t)i * variables + v] = column[i];
        }
    }
}

void carve_points_fini(struct carve_points *points)
{
    g_free(points->rows);
    *points = (struct carve_points){0};
}

void carve_init(struct carve *carve, const struct box *grown, const struct carve_points *points)
{
    const size_t variables = grown->count;
    *carve = (struct carve){.grown = grown, .points = points};
    box_init(&carve->box, grown->count);
    box_assign(&carve->box, grown);
    carve->out = g_new0(uint64_t, points->cloud->count + 1);
    carve->limit = g_new(double, 2 * variables + 1);
    carve->support = g_new(uint32_t, 2 * variables + 1);
    carve->shares = g_new(double, variables + 1);
}

void carve_fini(struct carve *carve)
{
    box_fini(&carve->box);
    g_free(carve->out);
    g_free(carve->limit);
    g_free(carve->support);
    g_free(carve->shares);
    *carve = (struct carve){0};
}

void carve_assign(struct carve *carve, const struct carve *from)
{
    assert(carve->points == from->points);
    const size_t sides = 2 * (size_t)carve->grown->count;
    carve->anchor = from->anchor;
    box_assign(&carve->box, &from->box);
    memcpy(carve->out, from->out, carve->points->cloud->count * sizeof *carve->out);
    memcpy(carve->limit, from->limit, sides * sizeof *carve->limit);
    memcpy(carve->support, from->support, sides * sizeof *carve->support);
}

// Adds `add` to the points whose coordinate lies in [least, most]. Eight bytes in, eight bytes out:
// the loop that trimming spends its time in is one compare, one mask and one addition a lane.
static inline __attribute__((always_inline)) void mark_body(uint64_t *restrict out,
                                                            const double *restrict column,
                                                            uint32_t count, double least,
                                                            double most, uint64_t add)
{
#pragma omp simd
    for (uint32_t i = 0; i < count; i++)
        out[i] += ((column[i] >= least) & (column[i] <= most)) ? add : 0;
}

static void mark_plain(uint64_t *out, const double *column, uint32_t count, double least,
                       double most, uint64_t add)
{
    mark_body(out, column, count, least, most, add);
}

#ifdef __x86_64__
__attribute__((target("avx2"))) static void mark_avx2(uint64_t *out, const double *column,
                                                      uint32_t count, double least, double most,
                                                      uint64_t add)
{
    mark_body(out, column, count, least, most, add);
}
#endif

static void mark(uint64_t *out, const double *column, uint32_t count, double least, double most,
                 uint64_t add)
{
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx2")) {
        mark_avx2(out, column, count, least, most, add);
        return;
    }
#endif
    mark_plain(out, column, count, least, most, add);
}

void carve_cut(struct carve *carve, uint32_t side, double bound)
{
    const struct cloud *bad = carve->points->cloud;
    const double *column = cloud_column(bad, side / 2);
    if (side % 2 == 0) {
        mark(carve->out, column, bad->count, carve->box.lower[side / 2],
             nextafter(bound, -INFINITY), out_of(side));
        carve->box.lower[side / 2] = bound;
    } else {
        mark(carve->out, column, bad->count, nextafter(bound, INFINITY), carve->box.upper[side / 2],
             out_of(side));
        carve->box.upper[side / 2] = bound;
    }
}

// The bound that just excludes a bad point from a side. Bounds belong to the box, so it is the next
// number inwards.
static double bound_inside(uint32_t side, double coordinate)
{
    return side % 2 == 0 ? nextafter(coordinate, INFINITY) : nextafter(coordinate, -INFINITY);
}

bool carve_off(struct carve *carve, uint32_t point, uint32_t forbidden)
{
    const uint32_t variables = carve->grown->count;
    const double *row = carve->points->rows + (size_t)point * variables;
    const double *anchor = carve->anchor;
    const double *lower = carve->box.lower;
    const double *upper = carve->box.upper;
    double *shares = carve->shares;
    // An equal coordinate cannot separate the two; it would cut the anchor off.
#pragma omp simd
    for (uint32_t v = 0; v < variables; v++) {
        const double left = row[v] > anchor[v] ? row[v] - lower[v] : upper[v] - row[v];
        const double share = left / (upper[v] - lower[v]);
        shares[v] = row[v] == anchor[v] ? -1 : share;
    }
    if (forbidden != CARVE_SIDE_NONE &&
        (row[forbidden / 2] > anchor[forbidden / 2]) == forbidden % 2)
        shares[forbidden / 2] = -1;
    uint32_t best = 0;
    for (uint32_t v = 1; v < variables; v++)
        best = shares[v] > shares[best] ? v : best;
    if (!(shares[best] >= 0))
        return false;
    const uint32_t side = 2 * best + (row[best] > anchor[best]);
    carve_cut(carve, side, bound_inside(side, row[best]));
    return true;
}

// Notes that `point`, which only `side` keeps out, stops that side.
static void stop_side(struct carve *carve, uint32_t side, uint32_t point)
{
    const double coordinate = cloud_column(carve->points->cloud, side / 2)[point];
    const double bound = bound_inside(side, coordinate);
    const bool nearer = side % 2 == 0 ? bound > carve->limit[side] : bound < carve->limit[side];
    if (nearer) {
        carve->limit[side] = bound;
        carve->support[side] = point;
    }
}

static void find_limits(struct carve *carve)
{
    for (uint32_t v = 0; v < carve->grown->count; v++) {
        carve->limit[2 * v] = carve->grown->lower[v];
        carve->limit[2 * v + 1] = carve->grown->upper[v];
        carve->support[2 * v] = carve->support[2 * v + 1] = CARVE_SIDE_NONE;
    }
    for (uint32_t i = 0; i < carve->points->cloud->count; i++) {
        if (out_by_one(carve->out[i]))
            stop_side(carve, (uint32_t)carve->out[i], i);
    }
}

// Moves a side out to its limit. Points that this side kept out together with one other are now
// kept out by that other alone, and stop it.
static void move_out(struct carve *carve, uint32_t side)
{
    const struct cloud *bad = carve->points->cloud;
    const double *column = cloud_column(bad, side / 2);
    const double bound = carve->limit[side];
    const bool lower = side % 2 == 0;
    const double old = lower ? carve->box.lower[side / 2] : carve->box.upper[side / 2];
    const double from = lower ? bound : nextafter(old, INFINITY);
    const double to = lower ? nextafter(old, -INFINITY) : bound;
    for (uint32_t i = 0; i < bad->count; i++) {
        if (!((column[i] >= from) & (column[i] <= to)))
            continue;
        carve->out[i] -= out_of(side);
        assert(carve->out[i] != 0);
        if (out_by_one(carve->out[i]))
            stop_side(carve, (uint32_t)carve->out[i], i);
    }
    if (lower)
        carve->box.lower[side / 2] = bound;
    else
        carve->box.upper[side / 2] = bound;
}

// The side whose way out multiplies its width by most, or CARVE_SIDE_NONE when none can move.
static uint32_t best_side_out(const struct carve *carve)
{
    uint32_t best = CARVE_SIDE_NONE;
    double best_gain = 1;
    for (uint32_t side = 0; side < 2 * carve->grown->count; side++) {
        const double lower = carve->box.lower[side / 2];
        const double upper = carve->box.upper[side / 2];
        const double width =
            side % 2 == 0 ? upper - carve->limit[side] : carve->limit[side] - lower;
        const double gain = width / (upper - lower);
        if (gain > best_gain) {
            best = side;
            best_gain = gain;
        }
    }
    return best;
}

void carve_expand(struct carve *carve)
{
    find_limits(carve);
    for (uint32_t side; (side = best_side_out(carve)) != CARVE_SIDE_NONE;)
        move_out(carve, side);
}

// Lets the support of a side in and cuts it off elsewhere, together with any other bad point that
// has the very same coordinate.
static bool give_up_support(struct carve *carve, uint32_t side)
{
    const struct cloud *bad = carve->points->cloud;
    const double *column = cloud_column(bad, side / 2);
    const double coordinate = column[carve->support[side]];
    for (uint32_t i = 0; i < bad->count; i++)
        carve->out[i] -= column[i] == coordinate ? out_of(side) : 0;
    if (side % 2 == 0)
        carve->box.lower[side / 2] = coordinate;
    else
        carve->box.upper[side / 2] = coordinate;
    for (uint32_t i = 0; i < bad->count; i++) {
        if (column[i] == coordinate && carve_holds(carve, i) && !carve_off(carve, i, side))
            return false;
    }
    return true;
}

bool carve_improve(struct carve *carve, struct carve *scratch)
{
    bool improved = false;
    struct volume volume = volume_of(&carve->box, carve->grown);
    for (uint32_t side = 0; side < 2 * carve->grown->count; side++) {
        if (carve->support[side] == CARVE_SIDE_NONE)
            continue;
        carve_assign(scratch, carve);
        if (!give_up_support(scratch, side))
            continue;
        carve_expand(scratch);
        struct volume tried = volume_of(&scratch->box, scratch->grown);
        if (volume_above(tried, volume)) {
            carve_assign(carve, scratch);
            volume = tried;
            improved = true;
        }
    }
    return improved;
}
