#include "common/scenario/constraint.h"

#include "common/scenario/field.h"
#include "common/scenario/formula.h"

#include <assert.h>
#include <glib.h>

#define AT(structure, member) .offset = offsetof(struct structure, member)

struct bounds_document {
    double min;
    double max;
};

static const struct field bounds_fields[] = {
    {"min", FIELD_NUMBER, .optional = true, AT(bounds_document, min), .range = FIELD_ANY},
    {"max", FIELD_NUMBER, .optional = true, AT(bounds_document, max), .range = FIELD_ANY},
};

// A violation is measured in units of the greatest bound, so that metres and degrees compare; where
// that is zero, in units of what the outcome is made of.
static double constraint_scale(const struct scenario *scenario, uint32_t outcome, double min,
                               double max)
{
    double scale = fmax(isfinite(min) ? fabs(min) : 0.0, isfinite(max) ? fabs(max) : 0.0);
    if (scale > 0.0)
        return scale;
    return scenario->model == SCENARIO_MODEL_SMALL_OVERLAP
               ? 1.0
               : formula_outcome_scale(scenario, outcome);
}

void constraint_add(struct scenario *scenario, uint32_t outcome, double min, double max)
{
    if (scenario->constraints == NULL)
        scenario->constraints = g_new0(struct scenario_constraint, SCENARIO_CONSTRAINT_MAX);
    assert(scenario->constraint_count < SCENARIO_CONSTRAINT_MAX);
    scenario->constraints[scenario->constraint_count++] = (struct scenario_constraint){
        .outcome = outcome,
        .min = min,
        .max = max,
        .scale = constraint_scale(scenario, outcome, min, max),
    };
}

static bool unknown_outcome(const struct tree_node *key, const struct scenario *scenario,
                            struct error *error)
{
    uint32_t count = scenario_outcome_count(scenario);
    char(*names)[SCENARIO_OUTCOME_NAME_SIZE] = g_malloc_n(count, sizeof *names);
    const char **known = g_new0(const char *, count + 1);
    for (uint32_t i = 0; i < count; i++)
        known[i] = scenario_outcome_name(scenario, i, names[i]);
    field_unknown_key(key, "outcome", known, error);
    g_free(known);
    g_free(names);
    return false;
}

static bool read_constraint(const struct tree_node *key, const struct tree_node *node,
                            struct scenario *scenario, struct error *error)
{
    uint32_t outcome = scenario_outcome_find(scenario, key->text);
    if (outcome == scenario_outcome_count(scenario))
        return unknown_outcome(key, scenario, error);
    struct bounds_document bounds = {-INFINITY, INFINITY};
    if (!field_read(node, bounds_fields, G_N_ELEMENTS(bounds_fields), &bounds, error))
        return false;
    if (node->count == 0) {
        tree_error(node, error, "expected min, max or both, found neither");
        return false;
    }
    if (bounds.min > bounds.max) {
        tree_error(tree_child(node, "max"), error,
                   "expected at least the min of %.15g, found %.15g", bounds.min, bounds.max);
        return false;
    }
    constraint_add(scenario, outcome, bounds.min, bounds.max);
    return true;
}

static bool read_all(const struct tree_node *node, struct scenario *scenario, struct error *error)
{
    if (node->kind != TREE_MAPPING) {
        char shown[TREE_SHOWN_SIZE];
        tree_error(node, error, "expected a mapping from outcomes to min and max, found %s",
                   tree_shown(node, shown));
        return false;
    }
    uint32_t room = SCENARIO_CONSTRAINT_MAX - scenario->constraint_count;
    if (node->count > room) {
        tree_error(node, error,
                   "expected at most %u constraints beside those of the model, found %u", room,
                   node->count);
        return false;
    }
    for (uint32_t i = 0; i < node->count; i++) {
        if (!read_constraint(node->keys[i], node->items[i], scenario, error))
            return false;
    }
    return true;
}

bool constraint_read(const struct tree_node *node, struct scenario *scenario, struct error *error)
{
    return node == NULL || read_all(node, scenario, error);
}
