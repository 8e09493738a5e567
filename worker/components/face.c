#include "worker/components/face.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum { AXIS_Y = 1, AXIS_Z = 2 };

static const double smallest = 1e-4; // [m2]

double face_area(const struct face_place *place)
{
    return (place->y[1] - place->y[0]) * (place->z[1] - place->z[0]);
}

double face_beside(const struct group *group, const struct face *face)
{
    const double from = group->box.min[AXIS_Y];
    const double to = group->box.max[AXIS_Y];
    const double inside = fmin(to, face->edge_y) - fmax(from, face->far_y);
    return (to - from) - fmax(0.0, inside);
}

// ---- Overlaps ----

static bool shared_place(const struct group_list *groups, uint32_t one, uint32_t other,
                         struct face_place *place)
{
    const struct component_box *a = &groups->items[one].box;
    const struct component_box *b = &groups->items[other].box;
    *place = (struct face_place){
        .y = {fmax(a->min[AXIS_Y], b->min[AXIS_Y]), fmin(a->max[AXIS_Y], b->max[AXIS_Y])},
        .z = {fmax(a->min[AXIS_Z], b->min[AXIS_Z]), fmin(a->max[AXIS_Z], b->max[AXIS_Z])},
        .one = one,
        .other = other,
    };
    return group_shared_area(a, b) >= smallest;
}

static void find_overlaps(const struct group_list *groups, GArray *overlaps)
{
    for (uint32_t one = 0; one < groups->count; one++) {
        for (uint32_t other = one + 1; other < groups->count; other++) {
            struct face_place place;
            if (shared_place(groups, one, other, &place)) {
                g_array_append_val(overlaps, place);
            }
        }
    }
}

// ---- Gaps ----

// The front cut along every patch's edges: a cell lies in a patch as a whole or not at all.
struct grid {
    double y[2 * GROUP_MAX + 2]; // [m] ascending
    double z[2 * GROUP_MAX + 2];
    uint32_t y_count;
    uint32_t z_count;
    bool taken[2 * GROUP_MAX + 1][2 * GROUP_MAX + 1]; // y, z
};

static int compare_numbers(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double other = *(const double *)b;
    return (one > other) - (one < other);
}

static uint32_t make_cuts(double *cuts, const struct group_list *groups, int axis,
                          const double front[2])
{
    uint32_t count = 0;
    cuts[count++] = front[0];
    cuts[count++] = front[1];
    for (uint32_t i = 0; i < groups->count; i++) {
        const double ends[2] = {groups->items[i].box.min[axis], groups->items[i].box.max[axis]};
        for (int k = 0; k < 2; k++) {
            if (ends[k] > front[0] && ends[k] < front[1]) {
                cuts[count++] = ends[k];
            }
        }
    }
    qsort(cuts, count, sizeof *cuts, compare_numbers);
    return count;
}

static bool covers(const struct group_list *groups, double y, double z)
{
    for (uint32_t i = 0; i < groups->count; i++) {
        const struct component_box *box = &groups->items[i].box;
        if (y >= box->min[AXIS_Y] && y <= box->max[AXIS_Y] && z >= box->min[AXIS_Z] &&
            z <= box->max[AXIS_Z]) {
            return true;
        }
    }
    return false;
}

static void grid_make(struct grid *grid, const struct group_list *groups,
                      const struct face_place *front)
{
    grid->y_count = make_cuts(grid->y, groups, AXIS_Y, front->y);
    grid->z_count = make_cuts(grid->z, groups, AXIS_Z, front->z);
    for (uint32_t i = 0; i + 1 < grid->y_count; i++) {
        for (uint32_t k = 0; k + 1 < grid->z_count; k++) {
            grid->taken[i][k] = covers(groups, 0.5 * (grid->y[i] + grid->y[i + 1]),
                                       0.5 * (grid->z[k] + grid->z[k + 1]));
        }
    }
}

// The free rectangle that begins at cell (i, k), as wide in y as can be, then as high, which is
// taken from the grid.
static struct face_place grid_take(struct grid *grid, uint32_t i, uint32_t k)
{
    uint32_t i_end = i;
    while (i_end + 1 < grid->y_count && !grid->taken[i_end][k]) {
        i_end++;
    }
    uint32_t k_end = k;
    bool free = true;
    while (free && k_end + 1 < grid->z_count) {
        for (uint32_t at = i; at < i_end; at++) {
            free = free && !grid->taken[at][k_end];
        }
        k_end += free;
    }
    for (uint32_t at = i; at < i_end; at++) {
        memset(&grid->taken[at][k], true, k_end - k);
    }
    return (struct face_place){
        .y = {grid->y[i], grid->y[i_end]},
        .z = {grid->z[k], grid->z[k_end]},
        .one = FACE_NOBODY,
        .other = FACE_NOBODY,
    };
}

static void find_gaps(const struct group_list *groups, const struct face_place *front, GArray *gaps)
{
    if (!(front->y[1] > front->y[0])) {
        return;
    }
    g_autofree struct grid *grid = g_new(struct grid, 1);
    grid_make(grid, groups, front);
    for (uint32_t k = 0; k + 1 < grid->z_count; k++) {
        for (uint32_t i = 0; i + 1 < grid->y_count; i++) {
            if (grid->taken[i][k]) {
                continue;
            }
            const struct face_place place = grid_take(grid, i, k);
            if (face_area(&place) >= smallest) {
                g_array_append_val(gaps, place);
            }
        }
    }
}

// ---- The whole ----

static struct face_place find_front(const struct group_list *groups, const struct face *face)
{
    struct face_place front = {
        .y = {INFINITY, -INFINITY},
        .z = {INFINITY, -INFINITY},
        .one = FACE_NOBODY,
        .other = FACE_NOBODY,
    };
    for (uint32_t i = 0; i < groups->count; i++) {
        const struct component_box *box = &groups->items[i].box;
        front.y[0] = fmin(front.y[0], box->min[AXIS_Y]);
        front.y[1] = fmax(front.y[1], box->max[AXIS_Y]);
        front.z[0] = fmin(front.z[0], box->min[AXIS_Z]);
        front.z[1] = fmax(front.z[1], box->max[AXIS_Z]);
    }
    front.y[0] = fmax(front.y[0], face->far_y);
    front.y[1] = isfinite(face->edge_y) ? face->edge_y : front.y[1];
    return front;
}

static int compare_places(const void *a, const void *b)
{
    const double one = face_area(a);
    const double other = face_area(b);
    return (one < other) - (one > other);
}

void face_check_make(struct face_check *check, const struct group_list *groups,
                     const struct face *face)
{
    GArray *overlaps = g_array_new(FALSE, FALSE, sizeof(struct face_place));
    GArray *gaps = g_array_new(FALSE, FALSE, sizeof(struct face_place));
    *check = (struct face_check){.front = find_front(groups, face)};
    find_overlaps(groups, overlaps);
    find_gaps(groups, &check->front, gaps);
    g_array_sort(overlaps, compare_places);
    g_array_sort(gaps, compare_places);
    check->overlap_count = overlaps->len;
    check->gap_count = gaps->len;
    check->overlaps = (struct face_place *)g_array_free(overlaps, FALSE);
    check->gaps = (struct face_place *)g_array_free(gaps, FALSE);
    for (uint32_t i = 0; i < check->gap_count; i++) {
        check->gap_area += face_area(&check->gaps[i]);
    }
}

void face_check_fini(struct face_check *check)
{
    g_free(check->overlaps);
    g_free(check->gaps);
    *check = (struct face_check){0};
}
