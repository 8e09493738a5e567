#include "common/numeric/box.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

void box_init(struct box *box, uint32_t count)
{
    box->count = count;
    box->lower = g_new0(double, count);
    box->upper = g_new0(double, count);
}

void box_fini(struct box *box)
{
    g_free(box->lower);
    g_free(box->upper);
    *box = (struct box){0};
}

void box_assign(struct box *box, const struct box *from)
{
    assert(box->count == from->count);
    if (from->count == 0)
        return;
    memmove(box->lower, from->lower, from->count * sizeof *from->lower);
    memmove(box->upper, from->upper, from->count * sizeof *from->upper);
}

bool box_equal(const struct box *a, const struct box *b)
{
    if (a->count != b->count)
        return false;
    size_t size = a->count * sizeof *a->lower;
    return size == 0 ||
           (memcmp(a->lower, b->lower, size) == 0 && memcmp(a->upper, b->upper, size) == 0);
}

double box_log_volume(const struct box *box, const struct box *space)
{
    assert(box->count == space->count);
    double sum = 0;
    for (uint32_t i = 0; i < space->count; i++) {
        double whole = space->upper[i] - space->lower[i];
        if (whole > 0)
            sum += log((box->upper[i] - box->lower[i]) / whole);
    }
    return sum;
}

uint32_t box_free_count(const struct box *space)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < space->count; i++)
        count += space->upper[i] > space->lower[i];
    return count;
}

bool box_contains(const struct box *box, const double *point)
{
    for (uint32_t i = 0; i < box->count; i++) {
        // Written so that a NaN coordinate is outside.
        if (!(point[i] >= box->lower[i] && point[i] <= box->upper[i]))
            return false;
    }
    return true;
}

bool box_inside(const struct box *inner, const struct box *outer)
{
    assert(inner->count == outer->count);
    return box_contains(outer, inner->lower) && box_contains(outer, inner->upper);
}
