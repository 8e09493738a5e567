#include "coordinator/search/trim.h"

#include "coordinator/search/carve.h"

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

// A point and what it is sorted by; equal keys are told apart by the points' coordinates, so that
// the order in which points are given does not matter.
struct ranked {
    double key;
    uint32_t point;
};

static int by_key(const void *a, const void *b, void *data)
{
    const struct ranked *one = a;
    const struct ranked *two = b;
    const struct cloud *cloud = data;
    if (one->key != two->key)
        return one->key < two->key ? -1 : 1;
    for (uint32_t v = 0; v < cloud->variables; v++) {
        const double *column = cloud_column(cloud, v);
        if (column[one->point] != column[two->point])
            return column[one->point] < column[two->point] ? -1 : 1;
    }
    return one->point < two->point ? -1 : one->point > two->point;
}

static void rank(struct ranked *ranked, const struct cloud *cloud)
{
    for (uint32_t i = 0; i < cloud->count; i++)
        ranked[i].point = i;
    qsort_r(ranked, cloud->count, sizeof *ranked, by_key, (void *)cloud);
}

// For each point its distance from `from`: the largest over the variables, in widths of the box.
static void distances(struct ranked *ranked, const struct cloud *cloud, const struct box *box,
                      const double *from)
{
    double *distance = g_new0(double, cloud->count + 1);
    for (uint32_t v = 0; v < cloud->variables; v++) {
        const double width = box->upper[v] - box->lower[v];
        if (!(width > 0))
            continue;
        const double scale = 1 / width;
        const double middle = from[v];
        const double *column = cloud_column(cloud, v);
#pragma omp simd
        for (uint32_t i = 0; i < cloud->count; i++) {
            const double ahead = fabs(column[i] - middle) * scale;
            distance[i] = ahead > distance[i] ? ahead : distance[i];
        }
    }
    for (uint32_t i = 0; i < cloud->count; i++)
        ranked[i].key = distance[i];
    g_free(distance);
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
    const uint32_t variables = box->count;
    double *centre = g_new(double, variables + 1);
    struct ranked *ranked = g_new(struct ranked, good->count + 1);
    centre_of(box, centre);
    distances(ranked, good, box, centre);
    rank(ranked, good);
    for (uint32_t i = 0; i < count && i < good->count; i++) {
        const uint32_t place = (uint32_t)((uint64_t)good->count * i / (2 * count));
        double *anchor = trimming->anchors + (size_t)trimming->anchor_count++ * variables;
        for (uint32_t v = 0; v < variables; v++)
            anchor[v] = cloud_column(good, v)[ranked[place].point];
    }
    g_free(ranked);
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
    struct ranked *ranked = g_new(struct ranked, bad->count + 1);
    if (order == ORDER_NEAREST_FIRST) {
        distances(ranked, bad, carve->grown, carve->anchor);
    } else {
        const double sign = order == ORDER_WORST_FIRST ? -1 : 1;
        for (uint32_t i = 0; i < bad->count; i++)
            ranked[i].key = sign * bad->violation[i];
    }
    rank(ranked, bad);
    for (uint32_t i = 0; i < bad->count; i++) {
        if (carve_holds(carve, ranked[i].point))
            carve_off(carve, ranked[i].point, CARVE_SIDE_NONE);
    }
    g_free(ranked);
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
    if (found && trimming.bad->count > 0) {
        bool warm = false;
        if (options->keep != NULL) {
            warm = previous != NULL;
            for (uint32_t i = 0; i <= (uint32_t)warm; i++)
                add_anchor(&trimming, options->keep);
        } else {
            warm = pick_previous_anchor(&trimming);
            pick_anchors(&trimming, &whole, &trimming.good, options->anchors);
        }
        carve_points_init(&trimming.points, trimming.bad, options->threads);
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
