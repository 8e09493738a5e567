#include "coordinator/report/leaving.h"

#include <math.h>
#include <stddef.h>

// The value at a place inside the range of x.
static double value_at(const double *x, const double *y, uint32_t count, double place)
{
    uint32_t i = 1;
    while (i + 1 < count && x[i] < place)
        i++;
    const double width = x[i] - x[i - 1];
    if (place >= x[i])
        return y[i];
    return y[i - 1] + (y[i] - y[i - 1]) * (place - x[i - 1]) / width;
}

// How far the curve is outside at a place, on one side: at most 0 when it is inside.
static double outside(const struct leaving_curves *curves, bool above, double place)
{
    const double force = value_at(curves->x, curves->y, curves->count, place);
    const double bound = value_at(curves->deformation, above ? curves->upper : curves->lower,
                                  curves->point_count, place);
    return above ? force - bound : bound - force;
}

// The next point of either curve behind a place, at most `to`.
static double next_place(const struct leaving_curves *curves, double place, double to)
{
    double next = to;
    for (uint32_t i = 0; i < curves->count; i++)
        if (curves->x[i] > place)
            next = fmin(next, curves->x[i]);
    for (uint32_t i = 0; i < curves->point_count; i++)
        if (curves->deformation[i] > place)
            next = fmin(next, curves->deformation[i]);
    return next;
}

// What is being written.
struct finding {
    struct leaving_piece *pieces;
    uint32_t room, count;
    struct leaving_piece piece; // the one that goes on
    bool open;
};

static void reach(struct finding *finding, bool above, double place, double distance)
{
    if (!finding->open)
        finding->piece = (struct leaving_piece){
            .from = place, .to = place, .above = above, .worst = 0, .worst_at = place};
    finding->open = true;
    finding->piece.to = place;
    if (distance > finding->piece.worst) {
        finding->piece.worst = distance;
        finding->piece.worst_at = place;
    }
}

static void finish(struct finding *finding)
{
    if (finding->open && finding->piece.worst > 0) {
        if (finding->count < finding->room)
            finding->pieces[finding->count] = finding->piece;
        finding->count++;
    }
    finding->open = false;
}

// One side of the corridor, from left to right.
static void find_side(const struct leaving_curves *curves, bool above, double from, double to,
                      struct finding *finding)
{
    double place = from, distance = outside(curves, above, from);
    if (distance > 0)
        reach(finding, above, place, distance);
    while (place < to) {
        const double next = next_place(curves, place, to);
        const double next_distance = outside(curves, above, next);
        if ((distance > 0) != (next_distance > 0)) {
            const double crossing = place + (next - place) * distance / (distance - next_distance);
            reach(finding, above, crossing, 0);
            if (next_distance <= 0)
                finish(finding);
        }
        if (next_distance > 0)
            reach(finding, above, next, next_distance);
        place = next;
        distance = next_distance;
    }
    finish(finding);
}

// Sorts by where the pieces begin; there are few.
static void sort(struct leaving_piece *pieces, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++)
        for (uint32_t k = i; k > 0 && pieces[k].from < pieces[k - 1].from; k--) {
            const struct leaving_piece swap = pieces[k];
            pieces[k] = pieces[k - 1];
            pieces[k - 1] = swap;
        }
}

uint32_t leaving_find(const struct leaving_curves *curves, struct leaving_piece *pieces,
                      uint32_t room, double *from, double *to)
{
    struct finding finding = {.pieces = pieces, .room = room};
    *from = fmax(curves->x[0], curves->deformation[0]);
    *to = fmin(curves->x[curves->count - 1], curves->deformation[curves->point_count - 1]);
    if (*from > *to)
        return 0;
    find_side(curves, true, *from, *to, &finding);
    find_side(curves, false, *from, *to, &finding);
    sort(pieces, finding.count < room ? finding.count : room);
    return finding.count;
}
