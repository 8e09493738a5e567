#include "coordinator/search/trim.h"

#include "coordinator/search/carve.h"
#include "coordinator/search/ranking.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// The order in which bad points are cut off.
enum order {
    ORDER_NEAREST_FIRST, // by distance from the anchor in units of the box
    ORDER_WORST_FIRST,
    ORDER_WORST_LAST,
    ORDER_COUNT
};

struct trim_options trim_options_default(void)
{
    return (struct trim_options){.anchors = 2, .rounds = 1, .edge = 0, .threads = 1};
}

// What points are sorted by.
struct keys {
    const struct cloud *cloud;
    double *key; // (points) in [least, most]
    double least;
    double most;
};

static int by_coordinates(const void *a, const void *b, void *data)
{
    const uint32_t one = *(const uint32_t *)a;
    const uint32_t two = *(const uint32_t *)b;
    const struct cloud *cloud = data;
    for (uint32_t v = 0; v < cloud->variables; v++) {
        const double *column = cloud_column(cloud, v);
        if (column[one] != column[two])
            return column[one] < column[two] ? -1 : 1;
    }
    return one < two ? -1 : one > two;
}

// Sorts points by key. `order` comes sorted by the first variable. Equal keys are told apart by the
// points' coordinates, so that the order in which points are given does not matter.
static void rank(uint32_t *order, const struct keys *keys)
{
    const struct cloud *cloud = keys->cloud;
    const double *key = keys->key;
    const double *column = cloud_column(cloud, 0);
    uint64_t *scratch = g_new(uint64_t, 2 * (size_t)cloud->count + 1);
    ranking_sort(order, cloud->count, key, keys->least, keys->most, scratch);
    g_free(scratch);
    uint32_t end;
    for (uint32_t first = 0; first < cloud->count; first = end) {
        for (end = first + 1; end < cloud->count && key[order[end]] == key[order[first]] &&
                              column[order[end]] == column[order[first]];)
            end++;
        if (end - first > 1)
            qsort_r(order + first, end - first, sizeof *order, by_coordinates, (void *)cloud);
    }
}

// The points in the order of the first variable. The caller releases it with g_free().
static uint32_t *along_first(const struct cloud *cloud, const struct box *box)
{
    uint32_t *order = g_new(uint32_t, cloud->count + 1);
    uint64_t *scratch = g_new(uint64_t, 2 * (size_t)cloud->count + 1);
    for (uint32_t i = 0; i < cloud->count; i++)
        order[i] = i;
    ranking_sort(order, cloud->count, cloud_column(cloud, 0), box->lower[0], box->upper[0],
                 scratch);
    g_free(scratch);
    return order;
}

// For each point its distance from `from`: the largest over the variables, in widths of the box.
static void distances(struct keys *keys, const struct box *box, const double *from)
{
    enum { BLOCK = 1024 }; // so that the distances stay in the nearest cache
    const struct cloud *cloud = keys->cloud;
    memset(keys->key, 0, cloud->count * sizeof *keys->key);
    for (uint32_t first = 0; first < cloud->count; first += BLOCK) {
        const uint32_t count = cloud->count - first < BLOCK ? cloud->count - first : BLOCK;
        double *distance = keys->key + first;
        for (uint32_t v = 0; v < cloud->variables; v++) {
            const double width = box->upper[v] - box->lower[v];
            if (!(width > 0))
                continue;
            const double scale = 1 / width;
            const double middle = from[v];
            const double *column = cloud_column(cloud, v) + first;
#pragma omp simd
            for (uint32_t i = 0; i < count; i++) {
                const double ahead = fabs(column[i] - middle) * scale;
                distance[i] = ahead > distance[i] ? ahead : distance[i];
            }
        }
    }
    keys->least = 0;
    keys->most = 0;
    for (uint32_t i = 0; i < cloud->count; i++)
        keys->most = keys->key[i] > keys->most ? keys->key[i] : keys->most;
}

// Everything the candidates share.
struct trimming {
    const struct box *grown;
    const struct box *previous; // or NULL
    struct cloud good;          // points inside grown
    const struct cloud *bad;
    struct carve_points points; // the bad ones
    uint32_t anchor_count;
    double *anchors; // (anchor_count x variables)
};

static void centre_of(const struct box *box, double *centre)
{
    for (uint32_t v = 0; v < box->count; v++)
        centre[v] = box->lower[v] + (box->upper[v] - box->lower[v]) / 2;
}

// Picks good points from the middle half of the box: the most central one, then others at even
// steps of the ranking by distance from the centre.
static void pick_anchors(struct trimming *trimming, const struct box *box, const struct cloud *good,
                         uint32_t count)
{
    if (good->count == 0)
        return;
    const uint32_t variables = box->count;
    double *centre = g_new(double, variables + 1);
    struct keys keys = {.cloud = good, .key = g_new(double, good->count + 1)};
    centre_of(box, centre);
    distances(&keys, box, centre);
    uint32_t *order = along_first(good, box);
    rank(order, &keys);
    for (uint32_t i = 0; i < count && i < good->count; i++) {
        const uint32_t place = (uint32_t)((uint64_t)good->count * i / (2 * count));
        double *anchor = trimming->anchors + (size_t)trimming->anchor_count++ * variables;
        for (uint32_t v = 0; v < variables; v++)
            anchor[v] = cloud_column(good, v)[order[place]];
    }
    g_free(order);
    g_free(keys.key);
    g_free(centre);
}

// The box's own anchor goes first, when a good point lies in it: with it the previous box is a
// starting point.
static bool pick_previous_anchor(struct trimming *trimming)
{
    if (trimming->previous == NULL)
        return false;
    struct cloud good;
    cloud_init(&good, trimming->good.variables);
    cloud_add_inside(&good, &trimming->good, trimming->previous);
    pick_anchors(trimming, trimming->previous, &good, 1);
    const bool found = good.count > 0;
    cloud_fini(&good);
    return found;
}

static void add_anchor(struct trimming *trimming, const double *point)
{
    const size_t variables = trimming->grown->count;
    memcpy(trimming->anchors + trimming->anchor_count++ * variables, point,
           variables * sizeof *point);
}

static void cut_all(struct carve *carve, enum order order)
{
    const struct cloud *bad = carve->points->cloud;
    struct keys keys = {.cloud = bad, .key = g_new(double, bad->count + 1)};
    if (order == ORDER_NEAREST_FIRST) {
        distances(&keys, carve->grown, carve->anchor);
    } else {
        const double sign = order == ORDER_WORST_FIRST ? -1 : 1;
        for (uint32_t i = 0; i < bad->count; i++)
            keys.key[i] = sign * bad->violation[i];
        keys.least = order == ORDER_WORST_FIRST ? -UINT16_MAX : 0;
        keys.most = order == ORDER_WORST_FIRST ? 0 : UINT16_MAX;
    }
    uint32_t *points = g_memdup2(carve->points->order, bad->count * sizeof *points);
    rank(points, &keys);
    for (uint32_t i = 0; i < bad->count; i++) {
        if (carve_holds(carve, points[i]))
            carve_off(carve, points[i], CARVE_SIDE_NONE);
    }
    g_free(points);
    g_free(keys.key);
}

// Candidate 0 starts from the previous box when `warm`, the others from the grown one: the first
// anchor with every order, the others with the first.
static void carve_candidate(struct carve *carve, const struct trimming *trimming,
                            uint32_t candidate, bool warm)
{
    const uint32_t variables = trimming->grown->count;
    carve_init(carve, trimming->grown, &trimming->points);
    if (warm && candidate == 0) {
        carve->anchor = trimming->anchors;
        for (uint32_t v = 0; v < variables; v++) {
            if (trimming->previous->lower[v] > trimming->grown->lower[v])
                carve_cut(carve, 2 * v, trimming->previous->lower[v]);
            if (trimming->previous->upper[v] < trimming->grown->upper[v])
                carve_cut(carve, 2 * v + 1, trimming->previous->upper[v]);
        }
        cut_all(carve, ORDER_NEAREST_FIRST);
    } else {
        const uint32_t place = candidate - warm;
        const uint32_t order = place < ORDER_COUNT ? place : 0;
        const uint32_t anchor = place < ORDER_COUNT ? 0 : place - ORDER_COUNT + 1;
        carve->anchor = trimming->anchors + (size_t)(anchor + warm) * variables;
        cut_all(carve, (enum order)order);
    }
    carve_expand(carve);
}

// Moves each cut from its bad point towards the last good point inside.
static void round_off(struct box *box, const struct trimming *trimming, double edge)
{
    if (edge == 0)
        return;
    struct cloud good;
    cloud_init(&good, box->count);
    cloud_add_inside(&good, &trimming->good, box);
    for (uint32_t v = 0; v < box->count; v++) {
        const double *column = cloud_column(&good, v);
        double least = box->upper[v];
        double most = box->lower[v];
        for (uint32_t i = 0; i < good.count; i++) {
            least = column[i] < least ? column[i] : least;
            most = column[i] > most ? column[i] : most;
        }
        if (box->lower[v] > trimming->grown->lower[v] && least > box->lower[v])
            box->lower[v] += edge * (least - box->lower[v]);
        if (box->upper[v] < trimming->grown->upper[v] && most < box->upper[v])
            box->upper[v] -= edge * (box->upper[v] - most);
    }
    cloud_fini(&good);
}

static void improve(struct carve *carve, uint32_t rounds)
{
    struct carve scratch;
    carve_init(&scratch, carve->grown, carve->points);
    while (rounds > 0 && carve_improve(carve, &scratch))
        rounds--;
    carve_fini(&scratch);
}

static void trim_from_anchors(const struct trimming *trimming, bool warm,
                              const struct trim_options *options, struct box *trimmed)
{
    const uint32_t count = warm + ORDER_COUNT + (trimming->anchor_count - warm) - 1;
    struct carve *carves = g_new0(struct carve, count);
#pragma omp parallel for num_threads(options->threads) schedule(dynamic)
    for (uint32_t i = 0; i < count; i++)
        carve_candidate(&carves[i], trimming, i, warm);
    uint32_t best = 0;
    for (uint32_t i = 1; i < count; i++) {
        if (volume_above(volume_of(&carves[i].box, trimming->grown),
                         volume_of(&carves[best].box, trimming->grown)))
            best = i;
    }
    improve(&carves[best], options->rounds);
    box_assign(trimmed, &carves[best].box);
    round_off(trimmed, trimming, options->edge);
    for (uint32_t i = 0; i < count; i++)
        carve_fini(&carves[i]);
    g_free(carves);
}

bool trim(const struct box *grown, const struct box *previous, const struct cloud *good,
          const struct cloud *bad, const struct trim_options *options, struct box *trimmed)
{
    assert(grown->count == good->variables && grown->count == bad->variables);
    assert(options->anchors > 0 && options->anchors <= TRIM_ANCHOR_MAX && options->threads > 0);
    struct box whole;
    box_init(&whole, grown->count);
    box_assign(&whole, grown);
    struct trimming trimming = {.grown = &whole, .previous = previous};
    cloud_init(&trimming.good, grown->count);
    cloud_add_inside(&trimming.good, good, grown);
    // Mostly all bad points were sampled from this very box; then they need not be copied.
    struct cloud inside;
    cloud_init(&inside, grown->count);
    trimming.bad = bad;
    if (!cloud_inside(bad, grown)) {
        cloud_add_inside(&inside, bad, grown);
        trimming.bad = &inside;
    }
    trimming.anchors = g_new(double, (size_t)(TRIM_ANCHOR_MAX + 1) * (grown->count + 1));
    const bool found = trimming.good.count > 0 || options->keep != NULL;
    if (found && trimming.bad->count > 0 && grown->count > 0) {
        bool warm = false;
        if (options->keep != NULL) {
            warm = previous != NULL;
            for (uint32_t i = 0; i <= (uint32_t)warm; i++)
                add_anchor(&trimming, options->keep);
        } else {
            warm = pick_previous_anchor(&trimming);
            pick_anchors(&trimming, &whole, &trimming.good, options->anchors);
        }
        carve_points_init(&trimming.points, trimming.bad, &whole, options->threads);
        trim_from_anchors(&trimming, warm, options, trimmed);
        carve_points_fini(&trimming.points);
    } else {
        box_assign(trimmed, &whole);
    }
    g_free(trimming.anchors);
    cloud_fini(&trimming.good);
    cloud_fini(&inside);
    box_fini(&whole);
    return found;
}
