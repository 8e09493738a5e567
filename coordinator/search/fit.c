#include "coordinator/search/fit.h"

#include "coordinator/search/trim.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stdlib.h>

enum {
    FIT_ROUNDS = 10, // over all sides, at one price; mostly two are enough
    FIT_SHRUNK = 10, // boxes smaller than the one without known bad samples
    FIT_PRICES = 32, // at which a box is fitted
    FIT_BOXES = FIT_SHRUNK + 1 + FIT_PRICES,
    FIT_NONE = UINT32_MAX,
};

// What a bad volume costs in volumes: so much that none is worth its place, then from the greatest
// price down in steps of 2^(1/4).
static const double fit_price_all = 1e9;
static const double fit_price_most = 1024;
static const double fit_price_fall = 1.189207115002721;

// The smallest box has this part of the volume of the one without known bad samples.
static const double fit_volume_least = 0.7;

// A side moves in by no more than this part of the width at a time.
static const double fit_width_kept = 0.25;

// A bad sample that one side alone could let in or keep out.
struct at_side {
    double depth; // how far inwards of the region's bound it lies
    double mass;
    uint32_t point;
};

// The bad samples that a box is fitted to: all, or one half.
struct fitting {
    const struct box *region;
    const double *keep;    // or NULL
    struct cloud inside;   // bad samples in the region
    double *mass;          // (points) share of the region's volume
    uint32_t *out;         // (points) variables in which the box does not hold the point
    struct box box;        // as it stands
    uint32_t *support;     // (sides) the point on which a side rests, or FIT_NONE
    struct at_side *along; // (points) scratch
    struct box *path;      // (FIT_BOXES)
};

// Takes those of `all` whose number is `first` and every `stride`-th from there.
static void fitting_init(struct fitting *fitting, const struct box *region, const double *keep,
                         const struct cloud *all, const double *mass, uint32_t first,
                         uint32_t stride)
{
    *fitting = (struct fitting){.region = region, .keep = keep};
    cloud_init(&fitting->inside, region->count);
    cloud_reserve(&fitting->inside, all->count / stride + 1);
    fitting->mass = g_new(double, all->count / stride + 1);
    for (uint32_t i = first; i < all->count; i += stride) {
        fitting->mass[fitting->inside.count] = stride * mass[i];
        cloud_add(&fitting->inside, all->values + i, all->capacity, all->violation[i]);
    }
    fitting->out = g_new(uint32_t, fitting->inside.count + 1);
    fitting->along = g_new(struct at_side, fitting->inside.count + 1);
    fitting->support = g_new(uint32_t, 2 * (size_t)region->count + 1);
    box_init(&fitting->box, region->count);
    fitting->path = g_new0(struct box, FIT_BOXES);
    for (int i = 0; i < FIT_BOXES; i++)
        box_init(&fitting->path[i], region->count);
}

static void fitting_fini(struct fitting *fitting)
{
    for (int i = 0; i < FIT_BOXES; i++)
        box_fini(&fitting->path[i]);
    g_free(fitting->path);
    cloud_fini(&fitting->inside);
    g_free(fitting->mass);
    g_free(fitting->out);
    g_free(fitting->along);
    g_free(fitting->support);
    box_fini(&fitting->box);
}

static bool beyond(const struct fitting *fitting, uint32_t variable, double value)
{
    return value < fitting->box.lower[variable] || value > fitting->box.upper[variable];
}

static void begin_from(struct fitting *fitting, const struct box *start)
{
    box_assign(&fitting->box, start);
    for (uint32_t i = 0; i < fitting->inside.count; i++)
        fitting->out[i] = 0;
    for (uint32_t v = 0; v < start->count; v++) {
        const double *column = cloud_column(&fitting->inside, v);
        for (uint32_t i = 0; i < fitting->inside.count; i++)
            fitting->out[i] += beyond(fitting, v, column[i]);
        fitting->support[2 * v] = fitting->support[2 * v + 1] = FIT_NONE;
    }
}

// The deepest first; equal depths by their points.
static bool deeper(const struct at_side *a, const struct at_side *b)
{
    return a->depth != b->depth ? a->depth > b->depth : a->point < b->point;
}

// Lets the first of a heap sink to where it belongs: a side passes few of the points along it, so
// they are taken off a heap and never sorted.
static void sink(struct at_side *heap, uint32_t count, uint32_t at)
{
    for (uint32_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && deeper(&heap[child + 1], &heap[child]))
            child++;
        if (!deeper(&heap[child], &heap[at]))
            return;
        const struct at_side swap = heap[at];
        heap[at] = heap[child];
        heap[child] = swap;
    }
}

// Collects the points that no other side keeps out, and that this one may keep out.
static uint32_t collect(struct fitting *fitting, uint32_t side, double deepest)
{
    const uint32_t v = side / 2;
    const bool lower = side % 2 == 0;
    const double *column = cloud_column(&fitting->inside, v);
    const double bound = lower ? fitting->region->lower[v] : fitting->region->upper[v];
    const double other = lower ? fitting->box.upper[v] : fitting->box.lower[v];
    uint32_t count = 0;
    for (uint32_t i = 0; i < fitting->inside.count; i++) {
        if (fitting->out[i] > 1 || (fitting->out[i] == 1 && !beyond(fitting, v, column[i])))
            continue;
        if (lower ? column[i] > other : column[i] < other)
            continue;
        const double depth = lower ? column[i] - bound : bound - column[i];
        if (depth <= deepest)
            fitting->along[count++] =
                (struct at_side){.depth = depth, .mass = fitting->mass[i], .point = i};
    }
    for (uint32_t i = count / 2; i-- > 0;)
        sink(fitting->along, count, i);
    return count;
}

// The share of the region's volume that the box has without its width in one variable.
static double cross_section(const struct fitting *fitting, uint32_t variable)
{
    const struct box *box = &fitting->box;
    const struct box *region = fitting->region;
    double product = 1;
    for (uint32_t v = 0; v < box->count; v++) {
        if (v != variable)
            product *= (box->upper[v] - box->lower[v]) / (region->upper[v] - region->lower[v]);
    }
    return product;
}

static void put_side(struct fitting *fitting, uint32_t side, double bound)
{
    const uint32_t v = side / 2;
    const double *column = cloud_column(&fitting->inside, v);
    for (uint32_t i = 0; i < fitting->inside.count; i++)
        fitting->out[i] -= beyond(fitting, v, column[i]);
    if (side % 2 == 0)
        fitting->box.lower[v] = bound;
    else
        fitting->box.upper[v] = bound;
    for (uint32_t i = 0; i < fitting->inside.count; i++)
        fitting->out[i] += beyond(fitting, v, column[i]);
}

// How deep a side may go: not past the point to keep, nor through most of the box at once.
static double deepest(const struct fitting *fitting, uint32_t side)
{
    const uint32_t v = side / 2;
    const bool lower = side % 2 == 0;
    const double width = fitting->box.upper[v] - fitting->box.lower[v];
    const double in = (1 - fit_width_kept) * width;
    const double limit = lower ? fitting->box.lower[v] + in : fitting->box.upper[v] - in;
    double depth = lower ? limit - fitting->region->lower[v] : fitting->region->upper[v] - limit;
    if (fitting->keep != NULL) {
        const double kept = lower ? fitting->keep[v] - fitting->region->lower[v]
                                  : fitting->region->upper[v] - fitting->keep[v];
        depth = kept < depth ? kept : depth;
    }
    return depth;
}

// Moves a side to where it is worth most; returns whether it moved.
static bool move_side(struct fitting *fitting, uint32_t side, double price)
{
    const uint32_t v = side / 2;
    const bool lower = side % 2 == 0;
    const struct box *region = fitting->region;
    const double whole = region->upper[v] - region->lower[v];
    const double section = cross_section(fitting, v) / whole;
    uint32_t count = collect(fitting, side, deepest(fitting, side));
    const double most =
        lower ? fitting->box.upper[v] - region->lower[v] : region->upper[v] - fitting->box.lower[v];
    // Going outwards, the side lets in one point after the other and rests on the next, until
    // what it has let in costs more than all that is left to win.
    double let_in = 0;
    double best_worth = -INFINITY;
    uint32_t best = FIT_NONE;
    while (section * most - price * let_in > best_worth) {
        const double width = count > 0 ? most - fitting->along[0].depth : most;
        const double worth = section * width - price * let_in;
        if (worth > best_worth) {
            best_worth = worth;
            best = count > 0 ? fitting->along[0].point : FIT_NONE;
        }
        if (count == 0)
            break;
        let_in += fitting->along[0].mass;
        fitting->along[0] = fitting->along[--count];
        sink(fitting->along, count, 0);
    }
    const double old = lower ? fitting->box.lower[v] : fitting->box.upper[v];
    double bound = lower ? region->lower[v] : region->upper[v];
    fitting->support[side] = best;
    if (best != FIT_NONE)
        bound = nextafter(cloud_column(&fitting->inside, v)[best], lower ? INFINITY : -INFINITY);
    if (bound == old)
        return false;
    put_side(fitting, side, bound);
    return true;
}

static void settle_at(struct fitting *fitting, double price)
{
    bool moved = true;
    for (int round = 0; round < FIT_ROUNDS && moved; round++) {
        moved = false;
        for (uint32_t side = 0; side < 2 * fitting->region->count; side++)
            moved = move_side(fitting, side, price) || moved;
    }
}

// Draws the sides that rest on bad samples in, until a part of the volume is left.
static void draw_in(const struct fitting *fitting, double volume, struct box *box)
{
    uint32_t resting = 0;
    for (uint32_t side = 0; side < 2 * box->count; side++)
        resting += fitting->support[side] != FIT_NONE;
    box_assign(box, &fitting->box);
    for (uint32_t side = 0; side < 2 * box->count; side++) {
        if (fitting->support[side] == FIT_NONE)
            continue;
        const uint32_t v = side / 2;
        const double move =
            (1 - volume) / resting * (fitting->box.upper[v] - fitting->box.lower[v]);
        if (side % 2 == 0)
            box->lower[v] += move;
        else
            box->upper[v] -= move;
        if (fitting->keep != NULL) {
            box->lower[v] = fmin(box->lower[v], fitting->keep[v]);
            box->upper[v] = fmax(box->upper[v], fitting->keep[v]);
        }
    }
}

// Fits the boxes of the path, the smallest first.
static bool find_path(struct fitting *fitting, const struct box *start,
                      const struct fit_options *options)
{
    struct trim_options trimming = trim_options_default();
    trimming.keep = options->keep;
    trimming.threads = options->threads;
    struct box pure;
    box_init(&pure, start->count);
    const bool found =
        trim(fitting->region, start, options->good, &fitting->inside, &trimming, &pure);
    begin_from(fitting, &pure);
    box_fini(&pure);
    settle_at(fitting, fit_price_all);
    for (int i = 0; i <= FIT_SHRUNK; i++) {
        const double part = (double)(FIT_SHRUNK - i) / FIT_SHRUNK;
        draw_in(fitting, 1 - part * (1 - fit_volume_least), &fitting->path[i]);
    }
    double price = fit_price_most;
    for (int i = FIT_SHRUNK + 1; i < FIT_BOXES; i++, price /= fit_price_fall) {
        settle_at(fitting, price);
        box_assign(&fitting->path[i], &fitting->box);
    }
    return found;
}

static double part_of(const struct box *box, const struct box *region)
{
    double part = 1;
    for (uint32_t v = 0; v < box->count; v++)
        part *= (box->upper[v] - box->lower[v]) / (region->upper[v] - region->lower[v]);
    return part;
}

// The bad share of a box by the samples of a fitting.
static double share_by(const struct fitting *fitting, const struct box *box)
{
    double bad = 0;
    for (uint32_t i = 0; i < fitting->inside.count; i++) {
        bool in = true;
        for (uint32_t v = 0; v < box->count && in; v++) {
            const double value = cloud_column(&fitting->inside, v)[i];
            in = value >= box->lower[v] && value <= box->upper[v];
        }
        bad += in ? fitting->mass[i] : 0;
    }
    return bad / part_of(box, fitting->region);
}

// What a sample stands for where most were drawn.
static double least_mass(const double *mass, uint32_t count)
{
    double least = count > 0 ? mass[0] : 0;
    for (uint32_t i = 1; i < count; i++)
        least = mass[i] < least ? mass[i] : least;
    return least;
}

// The bad share that the fitted box `i` of the path is expected to have: that of its own samples
// and what fitting flatters itself by.
static double expected(const struct fitting *all, const struct fitting halves[2], int i)
{
    double flattery = 0;
    for (int half = 0; half < 2; half++) {
        const struct box *box = &halves[half].path[i];
        flattery += (share_by(&halves[1 - half], box) - share_by(&halves[half], box)) / 4;
    }
    return share_by(all, &all->path[i]) + fmax(flattery, 0);
}

bool fit(const struct survey *survey, const struct box *region, const struct box *start,
         const struct fit_options *options, struct box *fitted)
{
    struct cloud inside;
    cloud_init(&inside, region->count);
    double *mass = survey_inside(survey, region, &inside);
    struct fitting all;
    struct fitting halves[2];
    fitting_init(&all, region, options->keep, &inside, mass, 0, 1);
    bool found = find_path(&all, start, options);
    for (uint32_t half = 0; half < 2; half++) {
        fitting_init(&halves[half], region, options->keep, &inside, mass, half, 2);
        found = find_path(&halves[half], start, options) && found;
    }
    int best = -1;
    // A share below that of one sample cannot be told from none.
    const double least = least_mass(mass, inside.count);
    struct volume largest = {0};
    for (int i = 0; i < FIT_BOXES && found; i++) {
        const double most = fmax(options->bad_share, least / part_of(&all.path[i], region));
        const struct volume volume = volume_of(&all.path[i], region);
        if (expected(&all, halves, i) <= most && volume_above(volume, largest)) {
            best = i;
            largest = volume;
        }
    }
    box_assign(fitted, found ? &all.path[best >= 0 ? best : 0] : start);
    for (uint32_t half = 0; half < 2; half++)
        fitting_fini(&halves[half]);
    fitting_fini(&all);
    g_free(mass);
    cloud_fini(&inside);
    return best >= 0;
}
