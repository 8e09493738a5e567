#include "worker/reduction/branches.h"

#include <assert.h>
#include <glib.h>
#include <math.h>

// A piece of a polyline between two kept points, and the point in between that it misses most.
struct piece {
    uint32_t from;
    uint32_t to;
    uint32_t worst;
    double miss; // [N] 0 where there is nothing in between
};

static double sample_size(const struct branches_sample *sample)
{
    return hypot(sample->force[SCENARIO_DIRECTION_X], sample->force[SCENARIO_DIRECTION_Y]);
}

static struct piece piece_make(const struct branches_sample *points, uint32_t from, uint32_t to)
{
    struct piece piece = {from, to, from, 0.0};
    const struct branches_sample *a = &points[from];
    const struct branches_sample *b = &points[to];
    for (uint32_t i = from + 1; i < to; i++) {
        const double share =
            (points[i].deformation - a->deformation) / (b->deformation - a->deformation);
        double miss = 0.0;
        for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
            const double on_line = a->force[k] + share * (b->force[k] - a->force[k]);
            miss = fmax(miss, fabs(points[i].force[k] - on_line));
        }
        if (miss > piece.miss) {
            piece.worst = i;
            piece.miss = miss;
        }
    }
    return piece;
}

// Keeps `point_max` of the points (all that matter, when fewer): splits the worst piece again and
// again. Returns how many.
static uint32_t thin(struct branches_sample *points, uint32_t count, uint32_t point_max)
{
    if (count <= point_max) {
        return count;
    }
    g_autofree struct piece *pieces = g_new(struct piece, point_max);
    g_autofree bool *kept = g_new0(bool, count);
    kept[0] = kept[count - 1] = true;
    pieces[0] = piece_make(points, 0, count - 1);
    for (uint32_t piece_count = 1; piece_count + 1 < point_max; piece_count++) {
        uint32_t worst = 0;
        for (uint32_t i = 1; i < piece_count; i++) {
            worst = pieces[i].miss > pieces[worst].miss ? i : worst;
        }
        const struct piece split = pieces[worst];
        if (split.miss == 0.0) {
            break;
        }
        kept[split.worst] = true;
        pieces[worst] = piece_make(points, split.from, split.worst);
        pieces[piece_count] = piece_make(points, split.worst, split.to);
    }
    uint32_t left = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (kept[i]) {
            points[left++] = points[i];
        }
    }
    return left;
}

// Adds points in ascending order. A branch needs two: one alone is continued with its force, which
// the model does anyway.
static void add_points(struct branches_sample *points, uint32_t count, uint32_t point_max,
                       struct design_branch *branch)
{
    const double further = 1e-3; // [m]
    count = thin(points, count, point_max);
    for (uint32_t i = 0; i < count; i++) {
        design_add(branch, points[i].deformation, points[i].force[SCENARIO_DIRECTION_X],
                   points[i].force[SCENARIO_DIRECTION_Y]);
    }
    if (count == 1) {
        design_add(branch, points[0].deformation + further, points[0].force[SCENARIO_DIRECTION_X],
                   points[0].force[SCENARIO_DIRECTION_Y]);
    }
}

// Moves those samples to `points` that lie beyond all before them, in the direction of `sign`.
// Returns how many; adds what the others carried to `passed`.
static uint32_t envelope(const struct branches_sample *samples, uint32_t count, double sign,
                         struct branches_sample *points, double *passed)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (kept == 0 || sign * samples[i].deformation > sign * points[kept - 1].deformation) {
            points[kept++] = samples[i];
        } else {
            *passed += sample_size(&samples[i]);
        }
    }
    return kept;
}

static void reverse(struct branches_sample *points, uint32_t count)
{
    for (uint32_t i = 0; i < count / 2; i++) {
        const struct branches_sample swapped = points[i];
        points[i] = points[count - 1 - i];
        points[count - 1 - i] = swapped;
    }
}

double branches_make(const struct branches_sample *samples, uint32_t count, uint32_t point_max,
                     struct design_spring *spring)
{
    assert(point_max >= 2);
    if (count == 0) {
        design_add(&spring->load, 0.0, 0.0, 0.0);
        design_add(&spring->load, 1.0, 0.0, 0.0);
        return 0.0;
    }
    uint32_t top = 0;
    for (uint32_t i = 1; i < count; i++) {
        top = samples[i].deformation > samples[top].deformation ? i : top;
    }
    double passed = 0.0;
    g_autofree struct branches_sample *points = g_new(struct branches_sample, count);
    uint32_t point_count = envelope(samples, top + 1, 1.0, points, &passed);
    add_points(points, point_count, point_max, &spring->load);
    point_count = envelope(samples + top + 1, count - top - 1, -1.0, points, &passed);
    reverse(points, point_count);
    add_points(points, point_count, point_max, &spring->unload);
    return passed;
}
