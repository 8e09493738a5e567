#include "common/scenario/tie_read.h"

#include "common/scenario/numbers.h"

#include <glib.h>

// Two tied springs stand for each other point by point, so they must have the same ones.
static bool same_points(const struct scenario *scenario, struct numbers_range a,
                        struct numbers_range b)
{
    if (a.count != b.count)
        return false;
    for (uint32_t i = 0; a.count > 1 && i < a.count; i++) {
        const struct scenario_variable *one = &scenario->variables[a.first + i];
        const struct scenario_variable *other = &scenario->variables[b.first + i];
        if (scenario->springs[one->spring].deformation[one->point] !=
            scenario->springs[other->spring].deformation[other->point])
            return false;
    }
    return true;
}

static bool tie_variable(const struct tree_node *node, const struct scenario *scenario,
                         uint32_t variable, uint32_t first, uint32_t *tie, struct error *error)
{
    const struct box *space = &scenario->design_space;
    if (space->lower[variable] != space->lower[first] ||
        space->upper[variable] != space->upper[first]) {
        tree_error(node, error,
                   "expected the design space of %s for %s too, %.15g to %.15g, found %.15g to "
                   "%.15g",
                   scenario->variables[first].name, scenario->variables[variable].name,
                   space->lower[first], space->upper[first], space->lower[variable],
                   space->upper[variable]);
        return false;
    }
    tie[variable] = first;
    return true;
}

// One list of names that share a corridor. `taken` marks variables of lists before.
static bool tie_list(const struct tree_node *list, const struct scenario *scenario, bool *taken,
                     uint32_t *tie, struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (list->kind != TREE_SEQUENCE || list->count < 2) {
        tree_error(list, error, "expected a list of at least 2 names, found %s",
                   tree_shown(list, shown));
        return false;
    }
    struct numbers_range first = {0};
    for (uint32_t i = 0; i < list->count; i++) {
        const struct tree_node *name = list->items[i];
        struct numbers_range range;
        if (name->kind != TREE_SCALAR) {
            tree_error(name, error, "expected a name, found %s", tree_shown(name, shown));
            return false;
        }
        if (!numbers_find(scenario, name->text, &range))
            return numbers_unknown(name, scenario, error);
        if (i == 0)
            first = range;
        if (!same_points(scenario, first, range)) {
            tree_error(name, error, "expected the discretization points of %s for %s too",
                       list->items[0]->text, name->text);
            return false;
        }
        for (uint32_t k = 0; k < range.count; k++) {
            if (taken[range.first + k]) {
                tree_error(name, error, "%s is tied twice: expected it once",
                           scenario->variables[range.first + k].name);
                return false;
            }
            taken[range.first + k] = true;
            if (i > 0 &&
                !tie_variable(name, scenario, range.first + k, first.first + k, tie, error))
                return false;
        }
    }
    return true;
}

// Lists name variables in any order; the struct points at the lowest of each.
static void point_at_lowest(uint32_t *tie, uint32_t count)
{
    uint32_t *lowest = g_new(uint32_t, count);
    for (uint32_t i = 0; i < count; i++)
        lowest[i] = UINT32_MAX;
    for (uint32_t i = 0; i < count; i++)
        lowest[tie[i]] = MIN(lowest[tie[i]], i);
    for (uint32_t i = 0; i < count; i++)
        tie[i] = lowest[tie[i]];
    g_free(lowest);
}

bool tie_read(const struct tree_node *node, const struct scenario *scenario,
              struct scenario_search *search, struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    const uint32_t count = scenario->design_space.count;
    if (node->kind != TREE_SEQUENCE || node->count < 1) {
        tree_error(node, error, "expected a list of lists of names that share a corridor, found %s",
                   tree_shown(node, shown));
        return false;
    }
    search->tie = g_new(uint32_t, count);
    for (uint32_t i = 0; i < count; i++)
        search->tie[i] = i;
    bool *taken = g_new0(bool, count), read = true;
    for (uint32_t i = 0; i < node->count && read; i++)
        read = tie_list(node->items[i], scenario, taken, search->tie, error);
    g_free(taken);
    point_at_lowest(search->tie, count);
    return read;
}
