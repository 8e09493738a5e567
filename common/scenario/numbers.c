#include "common/scenario/numbers.h"

#include "common/scenario/field.h"

#include <glib.h>
#include <math.h>
#include <string.h>

static struct numbers_range spring_range(const struct scenario *scenario, uint32_t index)
{
    struct numbers_range range = {.count = SCENARIO_DIRECTION_COUNT *
                                           scenario->springs[index].point_count};
    for (uint32_t i = 0; i < index; i++)
        range.first += SCENARIO_DIRECTION_COUNT * scenario->springs[i].point_count;
    return range;
}

// "front" or "front.force_x" of a spring.
static bool find_in_spring(const struct scenario *scenario, uint32_t index, const char *name,
                           struct numbers_range *range)
{
    const char *spring = scenario->springs[index].name;
    if (!g_str_has_prefix(name, spring))
        return false;
    *range = spring_range(scenario, index);
    name += strlen(spring);
    if (*name == '\0')
        return true;
    range->count = scenario->springs[index].point_count;
    if (strcmp(name, ".force_x") == 0)
        return true;
    range->first += range->count;
    return strcmp(name, ".force_y") == 0;
}

bool numbers_find(const struct scenario *scenario, const char *name, struct numbers_range *range)
{
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        if (find_in_spring(scenario, i, name, range))
            return true;
    }
    for (uint32_t i = 0; i < scenario->design_space.count; i++) {
        if (strcmp(scenario->variables[i].name, name) == 0) {
            *range = (struct numbers_range){i, 1};
            return true;
        }
    }
    return false;
}

bool numbers_unknown(const struct tree_node *name, const struct scenario *scenario,
                     struct error *error)
{
    enum { SHOWN_MAX = 12 }; // names that a message has room for
    if (scenario->spring_count > 0) {
        tree_error(name, error,
                   "unknown variable '%s': expected a spring, SPRING.force_x, SPRING.force_y, or "
                   "one force as %s",
                   name->text, scenario->variables[0].name);
        return false;
    }
    const char *known[SHOWN_MAX + 1] = {NULL};
    for (uint32_t i = 0; i < scenario->design_space.count && i < SHOWN_MAX; i++)
        known[i] = scenario->variables[i].name;
    return field_unknown_key(name, "variable", known, error);
}

void numbers_init(struct numbers *numbers, uint32_t count)
{
    numbers->values = g_new(double, count);
    numbers->nodes = g_new0(const struct tree_node *, count);
    for (uint32_t i = 0; i < count; i++)
        numbers->values[i] = NAN;
}

void numbers_fini(struct numbers *numbers)
{
    g_free(numbers->values);
    g_free(numbers->nodes);
}

const char *numbers_unit(const struct scenario *scenario)
{
    return scenario->model == SCENARIO_MODEL_SMALL_OVERLAP ? "N" : NULL;
}

static bool read_range(const struct tree_node *node, struct numbers_range variables,
                       const struct field_range *range, const char *unit, struct numbers *numbers,
                       struct error *error)
{
    if (!field_read_numbers(node, range, unit, numbers->values + variables.first, variables.count,
                            error))
        return false;
    for (uint32_t i = 0; i < variables.count; i++)
        numbers->nodes[variables.first + i] = node->kind == TREE_SEQUENCE ? node->items[i] : node;
    return true;
}

static bool read_named(const struct tree_node *mapping, const struct scenario *scenario,
                       const struct field_range *range, const char *unit, struct numbers *numbers,
                       struct error *error)
{
    for (uint32_t i = 0; i < mapping->count; i++) {
        struct numbers_range variables;
        if (!numbers_find(scenario, mapping->keys[i]->text, &variables))
            return numbers_unknown(mapping->keys[i], scenario, error);
        for (uint32_t v = variables.first; v < variables.first + variables.count; v++) {
            if (numbers->nodes[v] == NULL)
                continue;
            tree_error(mapping->keys[i], error, "%s is given twice: expected it once",
                       scenario->variables[v].name);
            return false;
        }
        if (!read_range(mapping->items[i], variables, range, unit, numbers, error))
            return false;
    }
    return true;
}

bool numbers_read(const struct tree_node *node, const struct scenario *scenario,
                  const struct field_range *range, const char *unit, struct numbers *numbers,
                  struct error *error)
{
    const struct numbers_range all = {0, scenario->design_space.count};
    return node->kind == TREE_MAPPING ? read_named(node, scenario, range, unit, numbers, error)
                                      : read_range(node, all, range, unit, numbers, error);
}

double *numbers_take(struct numbers *numbers, uint32_t count, double otherwise)
{
    for (uint32_t i = 0; i < count; i++) {
        if (numbers->nodes[i] == NULL)
            numbers->values[i] = otherwise;
    }
    return g_steal_pointer(&numbers->values);
}

double *numbers_read_partial(const struct tree_node *node, const struct scenario *scenario,
                             const struct field_range *range, const char *unit, double otherwise,
                             struct error *error)
{
    const uint32_t count = scenario->design_space.count;
    struct numbers numbers;
    numbers_init(&numbers, count);
    double *values = NULL;
    if (numbers_read(node, scenario, range, unit, &numbers, error))
        values = numbers_take(&numbers, count, otherwise);
    numbers_fini(&numbers);
    return values;
}

bool numbers_inside_space(const struct numbers *numbers, const struct scenario *scenario,
                          struct error *error)
{
    const struct box *space = &scenario->design_space;
    for (uint32_t i = 0; i < space->count; i++) {
        if (numbers->nodes[i] == NULL ||
            (numbers->values[i] >= space->lower[i] && numbers->values[i] <= space->upper[i]))
            continue;
        tree_error(numbers->nodes[i], error,
                   "expected %s inside the design space, %.15g to %.15g, found %.15g",
                   scenario->variables[i].name, space->lower[i], space->upper[i],
                   numbers->values[i]);
        return false;
    }
    return true;
}

bool numbers_complete(struct numbers *numbers, const struct tree_node *node,
                      const struct scenario *scenario, struct error *error)
{
    const struct box *space = &scenario->design_space;
    for (uint32_t i = 0; i < space->count; i++) {
        if (numbers->nodes[i] != NULL)
            continue;
        if (space->lower[i] < space->upper[i]) {
            tree_error(node, error, "%s is missing: expected a number for every free variable",
                       scenario->variables[i].name);
            return false;
        }
        numbers->values[i] = space->lower[i];
    }
    return true;
}
