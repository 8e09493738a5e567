#include "worker/components/spring.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum { AXIS_X, AXIS_Y, AXIS_Z };

// Ends nearer than this are one: drawings are no nearer. [m]
static const double same_place = 1e-3;

double spring_foremost(const struct group_list *groups)
{
    double foremost = INFINITY;
    for (uint32_t i = 0; i < groups->count; i++) {
        foremost = fmin(foremost, groups->items[i].box.min[AXIS_X]);
    }
    return foremost;
}

// Differences of decimal numbers without their rounding errors.
static double to_micrometres(double length)
{
    return round(length * 1e6) / 1e6;
}

static int compare_numbers(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double other = *(const double *)b;
    return (one > other) - (one < other);
}

// Where components of the group begin or end, ascending and apart. Returns how many.
static uint32_t find_ends(const struct component_list *components, const struct group_list *groups,
                          uint32_t group, double *ends)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < components->count; i++) {
        if (groups->of[i] == group) {
            ends[count++] = components->items[i].box.min[AXIS_X];
            ends[count++] = components->items[i].box.max[AXIS_X];
        }
    }
    qsort(ends, count, sizeof *ends, compare_numbers);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (kept == 0 || ends[i] - ends[kept - 1] >= same_place) {
            ends[kept++] = ends[i];
        }
    }
    return kept;
}

// How far x lies from a component, counted to the last place at which no other one takes over. [m]
static double distance(const struct component *component, double x)
{
    const double from = component->box.min[AXIS_X] - same_place;
    const double to = component->box.max[AXIS_X] - same_place;
    return x < from ? from - x : x >= to ? x - to : 0.0;
}

// The components nearest to x together: those that stand there, or in a free way those beside it.
static double force_at(const struct component_list *components, const struct group_list *groups,
                       uint32_t group, double x, enum scenario_direction direction)
{
    double force = 0.0;
    double nearest = INFINITY;
    for (uint32_t i = 0; i < components->count; i++) {
        const struct component *item = &components->items[i];
        if (groups->of[i] != group || distance(item, x) > nearest) {
            continue;
        }
        force = distance(item, x) < nearest ? 0.0 : force;
        nearest = distance(item, x);
        force += item->force[direction];
    }
    return force;
}

// The length along which components stand: the stretches between ends where one does.
static double find_path(const struct component_list *components, const struct group_list *groups,
                        uint32_t group, const double *ends, uint32_t count)
{
    double path = 0.0;
    for (uint32_t i = 0; i + 1 < count; i++) {
        bool stands = false;
        for (uint32_t k = 0; k < components->count; k++) {
            stands = stands ||
                     (groups->of[k] == group && distance(&components->items[k], ends[i]) == 0.0);
        }
        path += stands ? ends[i + 1] - ends[i] : 0.0;
    }
    return to_micrometres(path);
}

static enum status check_front(const struct component_list *components,
                               const struct group_list *groups, uint32_t group, double face_x,
                               struct error *error)
{
    for (uint32_t i = 0; i < components->count; i++) {
        const struct component *item = &components->items[i];
        if (groups->of[i] == group && item->box.min[AXIS_X] < face_x - same_place) {
            return error_set(error, STATUS_INVALID,
                             "%s:%u:1: x_min_m: expected at least %g m, the barrier's face at "
                             "first contact, found %g (forwards is -x)",
                             components->source, item->line, face_x, item->box.min[AXIS_X]);
        }
    }
    return STATUS_OK;
}

static void set_points(struct spring *spring, const struct component_list *components,
                       const struct group_list *groups, uint32_t group, double face_x,
                       const double *deformation, uint32_t count)
{
    spring->point_count = count;
    for (uint32_t i = 0; i < count; i++) {
        spring->deformation[i] = deformation[i];
        for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
            spring->force_upper[k][i] = force_at(components, groups, group, face_x + deformation[i],
                                                 (enum scenario_direction)k);
        }
    }
}

enum status spring_make(struct spring *spring, const struct component_list *components,
                        const struct group_list *groups, uint32_t group, double face_x,
                        struct error *error)
{
    const struct group *from = &groups->items[group];
    if (check_front(components, groups, group, face_x, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    const struct component_box *box = &from->box;
    *spring = (struct spring){
        .position = {box->max[AXIS_X], to_micrometres(0.5 * (box->min[AXIS_Y] + box->max[AXIS_Y]))},
        .length = to_micrometres(box->max[AXIS_X] - face_x),
        .height = to_micrometres(0.5 * (box->min[AXIS_Z] + box->max[AXIS_Z])),
        .forces = components->forces,
    };
    memcpy(spring->name, from->name, sizeof spring->name);
    g_autofree double *ends = g_new(double, 2 * (size_t)components->count);
    const uint32_t end_count = find_ends(components, groups, group, ends);
    spring->path = find_path(components, groups, group, ends, end_count);
    spring->point_count = end_count > 2 ? end_count - 1 : end_count;
    if (spring->point_count > SCENARIO_POINT_MAX) {
        return error_set(
            error, STATUS_INVALID,
            "%s: group %s: its components begin and end at %u places along x: expected "
            "at most %d",
            components->source, spring->name, spring->point_count, SCENARIO_POINT_MAX);
    }
    for (uint32_t i = 0; i < end_count; i++) {
        ends[i] = to_micrometres(ends[i] - face_x);
    }
    set_points(spring, components, groups, group, face_x, ends, spring->point_count);
    return STATUS_OK;
}

void spring_choose(struct spring *spring, const struct component_list *components,
                   const struct group_list *groups, uint32_t group, double face_x,
                   const struct points_choice *choice)
{
    spring->chosen = *choice;
    set_points(spring, components, groups, group, face_x, choice->deformation, choice->count);
}

void spring_of_curve(struct spring *spring, const char *name, const struct points_choice *choice)
{
    *spring = (struct spring){.length = NAN, .chosen = *choice, .point_count = choice->count};
    memcpy(spring->name, name, sizeof spring->name);
    memcpy(spring->deformation, choice->deformation, sizeof spring->deformation);
}
