#include "worker/components/polyline.h"

#include <glib.h>
#include <math.h>

// A piece of the polyline between two kept points, and the point in between that it misses most.
struct piece {
    uint32_t from;
    uint32_t to;
    uint32_t worst;
    double miss; // 0 where there is nothing in between
};

// The polyline's ordinate at a point of the curve between two kept ones.
static double on_line(const struct polyline *line, int ordinate, uint32_t from, uint32_t to,
                      uint32_t at)
{
    const double *y = line->y[ordinate];
    const double share = (line->x[at] - line->x[from]) / (line->x[to] - line->x[from]);
    return y[from] + share * (y[to] - y[from]);
}

static struct piece piece_make(const struct polyline *line, const struct polyline_rule *rule,
                               uint32_t from, uint32_t to)
{
    struct piece piece = {from, to, from, 0.0};
    for (uint32_t i = from + 1; i < to; i++) {
        double miss = 0.0;
        for (int k = 0; k < POLYLINE_ORDINATE_COUNT; k++) {
            const double apart = fabs(line->y[k][i] - on_line(line, k, from, to, i));
            miss = fmax(miss, apart / rule->scale[k]);
        }
        if (miss > piece.miss) {
            piece.worst = i;
            piece.miss = miss;
        }
    }
    return piece;
}

// The pieces between the points that are kept so far. Returns how many.
static uint32_t make_pieces(const struct polyline *line, const struct polyline_rule *rule,
                            const bool *kept, struct piece *pieces)
{
    uint32_t count = 0;
    uint32_t from = 0;
    for (uint32_t i = 1; i < line->count; i++) {
        if (kept[i]) {
            pieces[count++] = piece_make(line, rule, from, i);
            from = i;
        }
    }
    return count;
}

static uint32_t find_worst(const struct piece *pieces, uint32_t count)
{
    uint32_t worst = 0;
    for (uint32_t i = 1; i < count; i++) {
        worst = pieces[i].miss > pieces[worst].miss ? i : worst;
    }
    return worst;
}

uint32_t polyline_thin(const struct polyline *line, const struct polyline_rule *rule, bool *kept)
{
    kept[0] = kept[line->count - 1] = true;
    g_autofree struct piece *pieces = g_new(struct piece, line->count);
    uint32_t count = make_pieces(line, rule, kept, pieces);
    while (count > 0 && count + 1 < rule->point_max) {
        const uint32_t worst = find_worst(pieces, count);
        const struct piece split = pieces[worst];
        if (split.miss == 0.0 || split.miss <= rule->tolerance) {
            break;
        }
        kept[split.worst] = true;
        pieces[worst] = piece_make(line, rule, split.from, split.worst);
        pieces[count++] = piece_make(line, rule, split.worst, split.to);
    }
    return count + 1;
}

double polyline_miss(const struct polyline *line, const struct polyline_rule *rule,
                     const bool *kept)
{
    g_autofree struct piece *pieces = g_new(struct piece, line->count);
    const uint32_t count = make_pieces(line, rule, kept, pieces);
    return count > 0 ? pieces[find_worst(pieces, count)].miss : 0.0;
}

// The area between two lines that are `a` and `b` apart at the ends of a stretch, crossing or not.
static double area_between(double width, double a, double b)
{
    if (a * b >= 0.0) {
        return 0.5 * width * (fabs(a) + fabs(b));
    }
    return 0.5 * width * (a * a + b * b) / (fabs(a) + fabs(b));
}

double polyline_misplaced(const struct polyline *line, int ordinate, const bool *kept)
{
    const double *y = line->y[ordinate];
    double whole = 0.0;
    double apart = 0.0;
    uint32_t from = 0;
    for (uint32_t to = 1; to < line->count; to++) {
        if (!kept[to]) {
            continue;
        }
        double before = 0.0;
        for (uint32_t i = from + 1; i <= to; i++) {
            const double here = i < to ? y[i] - on_line(line, ordinate, from, to, i) : 0.0;
            const double width = line->x[i] - line->x[i - 1];
            apart += area_between(width, before, here);
            whole += area_between(width, y[i - 1], y[i]);
            before = here;
        }
        from = to;
    }
    return whole > 0.0 ? apart / whole : 0.0;
}
