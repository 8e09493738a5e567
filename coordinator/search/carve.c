#include "coordinator/search/carve.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

void carve_init(struct carve *carve, const struct box *grown, const struct cloud *bad)
{
    *carve = (struct carve){.grown = grown, .bad = bad};
    box_init(&carve->box, grown->count);
    box_assign(&carve->box, grown);
    carve->outside = g_new0(uint16_t, bad->count + 1);
    carve->sides = g_new0(uint32_t, bad->count + 1);
    carve->limit = g_new(double, 2 * (size_t)grown->count + 1);
    carve->support = g_new(uint32_t, 2 * (size_t)grown->count + 1);
}

void carve_fini(struct carve *carve)
{
    box_fini(&carve->box);
    g_free(carve->outside);
    g_free(carve->sides);
    g_free(carve->limit);
    g_free(carve->support);
    *carve = (struct carve){0};
}

void carve_assign(struct carve *carve, const struct carve *from)
{
    assert(carve->bad == from->bad);
    const uint32_t count = carve->bad->count;
    const size_t sides = 2 * (size_t)carve->grown->count;
    carve->anchor = from->anchor;
    box_assign(&carve->box, &from->box);
    memcpy(carve->outside, from->outside, count * sizeof *carve->outside);
    memcpy(carve->sides, from->sides, count * sizeof *carve->sides);
    memcpy(carve->limit, from->limit, sides * sizeof *carve->limit);
    memcpy(carve->support, from->support, sides * sizeof *carve->support);
}

void carve_cut(struct carve *carve, uint32_t side, double bound)
{
    const uint32_t count = carve->bad->count;
    const double *restrict column = cloud_column(carve->bad, side / 2);
    uint16_t *restrict outside = carve->outside;
    uint32_t *restrict sides = carve->sides;
    if (side % 2 == 0) {
        const double old = carve->box.lower[side / 2];
        for (uint32_t i = 0; i < count; i++) {
            uint32_t newly = (uint32_t)(column[i] < bound) & (uint32_t)(column[i] >= old);
            outside[i] = (uint16_t)(outside[i] + newly);
            sides[i] += newly ? side : 0;
        }
        carve->box.lower[side / 2] = bound;
    } else {
        const double old = carve->box.upper[side / 2];
        for (uint32_t i = 0; i < count; i++) {
            uint32_t newly = (uint32_t)(column[i] > bound) & (uint32_t)(column[i] <= old);
            outside[i] = (uint16_t)(outside[i] + newly);
            sides[i] += newly ? side : 0;
        }
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
    uint32_t best = CARVE_SIDE_NONE;
    double best_share = -1;
    double best_bound = 0;
    for (uint32_t v = 0; v < carve->grown->count; v++) {
        const double coordinate = cloud_column(carve->bad, v)[point];
        // An equal coordinate cannot separate the two; it would cut the anchor off.
        if (coordinate == carve->anchor[v])
            continue;
        const uint32_t side = 2 * v + (coordinate > carve->anchor[v]);
        if (side == forbidden)
            continue;
        const double lower = carve->box.lower[v];
        const double upper = carve->box.upper[v];
        const double left = side % 2 == 0 ? upper - coordinate : coordinate - lower;
        const double share = left / (upper - lower);
        if (share > best_share) {
            best = side;
            best_share = share;
            best_bound = bound_inside(side, coordinate);
        }
    }
    if (best == CARVE_SIDE_NONE)
        return false;
    carve_cut(carve, best, best_bound);
    return true;
}

// Notes that `point`, which only `side` keeps out, stops that side.
static void stop_side(struct carve *carve, uint32_t side, uint32_t point)
{
    const double coordinate = cloud_column(carve->bad, side / 2)[point];
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
    for (uint32_t i = 0; i < carve->bad->count; i++) {
        if (carve->outside[i] == 1)
            stop_side(carve, carve->sides[i], i);
    }
}

// Moves a side out to its limit. Points that this side kept out together with one other are now
// kept out by that other alone, and stop it.
static void move_out(struct carve *carve, uint32_t side)
{
    const uint32_t count = carve->bad->count;
    const double *column = cloud_column(carve->bad, side / 2);
    const double bound = carve->limit[side];
    const bool lower = side % 2 == 0;
    const double old = lower ? carve->box.lower[side / 2] : carve->box.upper[side / 2];
    const double from = lower ? bound : nextafter(old, INFINITY);
    const double to = lower ? nextafter(old, -INFINITY) : bound;
    for (uint32_t i = 0; i < count; i++) {
        if (!((column[i] >= from) & (column[i] <= to)))
            continue;
        carve->sides[i] -= side;
        carve->outside[i]--;
        assert(carve->outside[i] > 0);
        if (carve->outside[i] == 1)
            stop_side(carve, carve->sides[i], i);
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
    const uint32_t variable = side / 2;
    const double *column = cloud_column(carve->bad, variable);
    const double coordinate = column[carve->support[side]];
    for (uint32_t i = 0; i < carve->bad->count; i++) {
        if (column[i] != coordinate)
            continue;
        carve->sides[i] -= side;
        carve->outside[i]--;
    }
    if (side % 2 == 0)
        carve->box.lower[variable] = coordinate;
    else
        carve->box.upper[variable] = coordinate;
    for (uint32_t i = 0; i < carve->bad->count; i++) {
        if (column[i] == coordinate && carve->outside[i] == 0 && !carve_off(carve, i, side))
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
