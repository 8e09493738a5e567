#include "coordinator/search/carve.h"

#include "coordinator/search/ranking.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

// One side more keeps the point out.
static uint32_t out_of(uint32_t side)
{
    return side << 16 | 1;
}

static bool out_by_one(uint32_t out)
{
    return (out & UINT16_MAX) == 1;
}

static const uint32_t *order_of(const struct carve_points *points, uint32_t variable)
{
    return points->order + (size_t)variable * points->cloud->count;
}

void carve_points_init(struct carve_points *points, const struct cloud *cloud,
                       const struct box *grown, int threads)
{
    const uint32_t count = cloud->count;
    assert(cloud->variables <= CARVE_VARIABLE_MAX);
    points->cloud = cloud;
    points->order = g_new(uint32_t, (size_t)count * cloud->variables + 1);
#pragma omp parallel num_threads(threads) if ((size_t)count * cloud->variables > 20000)
    {
        uint64_t *scratch = g_new(uint64_t, 2 * (size_t)count + 1);
#pragma omp for schedule(dynamic, 4)
        for (uint32_t v = 0; v < cloud->variables; v++) {
            uint32_t *order = points->order + (size_t)v * count;
            for (uint32_t i = 0; i < count; i++)
                order[i] = i;
            ranking_sort(order, count, cloud_column(cloud, v), grown->lower[v], grown->upper[v],
                         scratch);
        }
        g_free(scratch);
    }
}

void carve_points_fini(struct carve_points *points)
{
    g_free(points->order);
    *points = (struct carve_points){0};
}

void carve_init(struct carve *carve, const struct box *grown, const struct carve_points *points)
{
    const size_t variables = grown->count;
    *carve = (struct carve){.grown = grown, .points = points};
    box_init(&carve->box, grown->count);
    box_assign(&carve->box, grown);
    carve->out = g_new0(uint32_t, points->cloud->count + 1);
    carve->place = g_new0(uint32_t, 2 * variables + 1);
    for (uint32_t v = 0; v < variables; v++)
        carve->place[2 * v + 1] = points->cloud->count;
    carve->limit = g_new(double, 2 * variables + 1);
    carve->support = g_new(uint32_t, 2 * variables + 1);
    carve->loose = g_new(uint32_t, 2 * variables + 1);
    carve->is_loose = g_new0(bool, 2 * variables + 1);
    carve->row = g_new(double, variables + 1);
    carve->shares = g_new(double, variables + 1);
}

void carve_fini(struct carve *carve)
{
    box_fini(&carve->box);
    g_free(carve->out);
    g_free(carve->place);
    g_free(carve->limit);
    g_free(carve->support);
    g_free(carve->loose);
    g_free(carve->is_loose);
    g_free(carve->row);
    g_free(carve->shares);
    *carve = (struct carve){0};
}

void carve_assign(struct carve *carve, const struct carve *from)
{
    assert(carve->points == from->points);
    const size_t sides = 2 * (size_t)carve->grown->count;
    assert(from->loose_count == 0);
    carve->anchor = from->anchor;
    box_assign(&carve->box, &from->box);
    memcpy(carve->out, from->out, carve->points->cloud->count * sizeof *carve->out);
    memcpy(carve->place, from->place, sides * sizeof *carve->place);
    carve->limited = from->limited;
    memcpy(carve->limit, from->limit, sides * sizeof *carve->limit);
    memcpy(carve->support, from->support, sides * sizeof *carve->support);
    while (carve->loose_count > 0)
        carve->is_loose[carve->loose[--carve->loose_count]] = false;
}

static void loosen(struct carve *carve, uint32_t side)
{
    if (carve->is_loose[side])
        return;
    carve->is_loose[side] = true;
    carve->loose[carve->loose_count++] = side;
}

// One side more keeps the point out. What only another kept out does not stop that any more.
static void put_out(struct carve *carve, uint32_t side, uint32_t point)
{
    const uint32_t out = carve->out[point];
    carve->out[point] = out + out_of(side);
    if (carve->limited && out_by_one(out) && carve->support[out >> 16] == point)
        loosen(carve, out >> 16);
}

void carve_cut(struct carve *carve, uint32_t side, double bound)
{
    const struct cloud *bad = carve->points->cloud;
    const double *column = cloud_column(bad, side / 2);
    const uint32_t *order = order_of(carve->points, side / 2);
    uint32_t place = carve->place[side];
    if (side % 2 == 0) {
        for (; place < bad->count && column[order[place]] < bound; place++)
            put_out(carve, side, order[place]);
        carve->box.lower[side / 2] = bound;
    } else {
        for (; place > 0 && column[order[place - 1]] > bound; place--)
            put_out(carve, side, order[place - 1]);
        carve->box.upper[side / 2] = bound;
    }
    carve->place[side] = place;
    if (carve->limited)
        loosen(carve, side);
}

// The bound that just excludes a bad point from a side. Bounds belong to the box, so it is the next
// number inwards.
static double bound_inside(uint32_t side, double coordinate)
{
    return side % 2 == 0 ? nextafter(coordinate, INFINITY) : nextafter(coordinate, -INFINITY);
}

// For each variable the share of its width that is left when a point is cut off on its side of the
// anchor.
static void find_shares(double *restrict shares, const double *restrict row, const struct box *box,
                        const double *restrict anchor)
{
    const double *restrict lower = box->lower;
    const double *restrict upper = box->upper;
    const uint32_t count = box->count;
#pragma omp simd
    for (uint32_t v = 0; v < count; v++) {
        const double from = lower[v];
        const double to = upper[v];
        const double kept = row[v] > anchor[v] ? from : to;
        shares[v] = fabs(row[v] - kept) / (to - from);
    }
}

bool carve_off(struct carve *carve, uint32_t point, uint32_t forbidden)
{
    const uint32_t variables = carve->grown->count;
    const double *anchor = carve->anchor;
    double *row = carve->row;
    for (uint32_t v = 0; v < variables; v++)
        row[v] = cloud_column(carve->points->cloud, v)[point];
    find_shares(carve->shares, row, &carve->box, anchor);
    uint32_t best = 0;
    double most = -1;
    for (uint32_t v = 0; v < variables; v++) {
        // An equal coordinate cannot separate the two; it would cut the anchor off.
        if (carve->shares[v] > most && row[v] != anchor[v] &&
            2 * v + (row[v] > anchor[v]) != forbidden) {
            best = v;
            most = carve->shares[v];
        }
    }
    if (!(most >= 0))
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

// Finds the limit of a side by itself: the first point further out that no other side keeps out.
static void find_limit(struct carve *carve, uint32_t side)
{
    const struct cloud *bad = carve->points->cloud;
    const uint32_t *order = order_of(carve->points, side / 2);
    uint32_t place = carve->place[side];
    if (side % 2 == 0) {
        carve->limit[side] = carve->grown->lower[side / 2];
        while (place > 0 && !out_by_one(carve->out[order[place - 1]]))
            place--;
        carve->support[side] = place > 0 ? order[place - 1] : CARVE_SIDE_NONE;
    } else {
        carve->limit[side] = carve->grown->upper[side / 2];
        while (place < bad->count && !out_by_one(carve->out[order[place]]))
            place++;
        carve->support[side] = place < bad->count ? order[place] : CARVE_SIDE_NONE;
    }
    if (carve->support[side] != CARVE_SIDE_NONE)
        carve->limit[side] = bound_inside(side, cloud_column(bad, side / 2)[carve->support[side]]);
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
            stop_side(carve, carve->out[i] >> 16, i);
    }
}

// One side less keeps the point out. What only one other still keeps out stops that.
static void let_in(struct carve *carve, uint32_t side, uint32_t point)
{
    const uint32_t out = carve->out[point] -= out_of(side);
    if (out_by_one(out))
        stop_side(carve, out >> 16, point);
}

// Moves a side out to its limit.
static void move_out(struct carve *carve, uint32_t side)
{
    const struct cloud *bad = carve->points->cloud;
    const double *column = cloud_column(bad, side / 2);
    const uint32_t *order = order_of(carve->points, side / 2);
    const double bound = carve->limit[side];
    uint32_t place = carve->place[side];
    if (side % 2 == 0) {
        for (; place > 0 && column[order[place - 1]] >= bound; place--)
            let_in(carve, side, order[place - 1]);
        carve->box.lower[side / 2] = bound;
    } else {
        for (; place < bad->count && column[order[place]] <= bound; place++)
            let_in(carve, side, order[place]);
        carve->box.upper[side / 2] = bound;
    }
    carve->place[side] = place;
}

// The side whose way out multiplies its width by most, or CARVE_SIDE_NONE when none can move.
static uint32_t best_side_out(const struct carve *carve)
{
    uint32_t best = CARVE_SIDE_NONE;
    double best_gain = 1;
    for (uint32_t side = 0; side < 2 * carve->grown->count; side++) {
        const double lower = carve->box.lower[side / 2];
        const double upper = carve->box.upper[side / 2];
        const double limit = carve->limit[side];
        // Most sides are at rest; a division for each would be most of an expansion.
        if (limit == (side % 2 == 0 ? lower : upper))
            continue;
        const double width = side % 2 == 0 ? upper - limit : limit - lower;
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
    if (!carve->limited)
        find_limits(carve);
    carve->limited = true;
    while (carve->loose_count > 0) {
        const uint32_t side = carve->loose[--carve->loose_count];
        carve->is_loose[side] = false;
        find_limit(carve, side);
    }
    for (uint32_t side; (side = best_side_out(carve)) != CARVE_SIDE_NONE;)
        move_out(carve, side);
}

// Lets the support of a side in and cuts it off elsewhere, together with any other bad point that
// has the very same coordinate. A side may rest a rounding error before its limit; what lies
// between is let in as well.
static bool give_up_support(struct carve *carve, uint32_t side)
{
    const struct cloud *bad = carve->points->cloud;
    const double *column = cloud_column(bad, side / 2);
    const uint32_t *order = order_of(carve->points, side / 2);
    const double coordinate = column[carve->support[side]];
    uint32_t first = carve->place[side];
    uint32_t end = first;
    if (side % 2 == 0) {
        while (first > 0 && column[order[first - 1]] >= coordinate)
            first--;
        carve->place[side] = first;
        carve->box.lower[side / 2] = coordinate;
    } else {
        while (end < bad->count && column[order[end]] <= coordinate)
            end++;
        carve->place[side] = end;
        carve->box.upper[side / 2] = coordinate;
    }
    loosen(carve, side);
    for (uint32_t i = first; i < end; i++)
        let_in(carve, side, order[i]);
    for (uint32_t i = first; i < end; i++) {
        if (carve_holds(carve, order[i]) && !carve_off(carve, order[i], side))
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
