#include "worker/components/group.h"

#include <math.h>
#include <string.h>

enum { AXIS_Y = 1, AXIS_Z = 2 };

// Half of the smaller rectangle: two components that touch at their edges stay apart, and one that
// is set off by a bracket's width stays in line.
static const double in_line_share = 0.5;

static double shared_width(const struct component_box *one, const struct component_box *other,
                           int axis)
{
    return fmax(0.0,
                fmin(one->max[axis], other->max[axis]) - fmax(one->min[axis], other->min[axis]));
}

double group_shared_area(const struct component_box *one, const struct component_box *other)
{
    return shared_width(one, other, AXIS_Y) * shared_width(one, other, AXIS_Z);
}

static double area(const struct component_box *box)
{
    return group_shared_area(box, box);
}

static uint32_t find_named(const struct group_list *groups, const char *name)
{
    uint32_t at = 0;
    while (at < groups->count && strcmp(groups->items[at].name, name) != 0) {
        at++;
    }
    return at;
}

// The group in whose line the component stands, or groups->count.
static uint32_t find_in_line(const struct group_list *groups, const struct component_box *box)
{
    uint32_t best = groups->count;
    double best_shared = 0.0;
    for (uint32_t i = 0; i < groups->count; i++) {
        const struct component_box *patch = &groups->items[i].box;
        const double shared = group_shared_area(patch, box);
        if (shared >= in_line_share * fmin(area(patch), area(box)) && shared > best_shared) {
            best = i;
            best_shared = shared;
        }
    }
    return best;
}

static enum status found(struct group_list *groups, const struct component_list *components,
                         const char *name, uint32_t line, struct error *error)
{
    if (groups->count == GROUP_MAX) {
        return error_set(error, STATUS_INVALID,
                         "%s:%u:1: expected at most %d groups: %s would be another one",
                         components->source, line, GROUP_MAX, name);
    }
    struct group *group = &groups->items[groups->count++];
    memcpy(group->name, name, SCENARIO_NAME_SIZE);
    for (int axis = 0; axis < COMPONENT_AXIS_COUNT; axis++) {
        group->box.min[axis] = INFINITY;
        group->box.max[axis] = -INFINITY;
    }
    group->component_count = 0;
    return STATUS_OK;
}

static void join(struct group_list *groups, uint32_t at, const struct component_box *box)
{
    struct group *group = &groups->items[at];
    for (int axis = 0; axis < COMPONENT_AXIS_COUNT; axis++) {
        group->box.min[axis] = fmin(group->box.min[axis], box->min[axis]);
        group->box.max[axis] = fmax(group->box.max[axis], box->max[axis]);
    }
    group->component_count++;
}

// Puts a component into a group that is there or founds one. A component without a group takes its
// own name, which a named group may have too: then it belongs there.
static enum status place(struct group_list *groups, const struct component_list *components,
                         uint32_t index, struct error *error)
{
    const struct component *component = &components->items[index];
    const bool named = component->group[0] != '\0';
    const char *name = named ? component->group : component->name;
    uint32_t at = named ? groups->count : find_in_line(groups, &component->box);
    if (at == groups->count) {
        at = find_named(groups, name);
    }
    if (at == groups->count &&
        found(groups, components, name, component->line, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    join(groups, at, &component->box);
    groups->of[index] = at;
    return STATUS_OK;
}

enum status group_make(struct group_list *groups, const struct component_list *components,
                       struct error *error)
{
    groups->count = 0;
    for (int named = 1; named >= 0; named--) {
        for (uint32_t i = 0; i < components->count; i++) {
            const struct component *component = &components->items[i];
            if ((component->group[0] != '\0') == named &&
                place(groups, components, i, error) != STATUS_OK) {
                return STATUS_INVALID;
            }
        }
    }
    return STATUS_OK;
}
