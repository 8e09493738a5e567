#include "common/scenario/scenario_read.h"

#include "common/scenario/constraint.h"
#include "common/scenario/crash_read.h"
#include "common/scenario/field.h"
#include "common/scenario/formula_read.h"
#include "common/scenario/plausibility.h"
#include "common/scenario/search_read.h"
#include "common/scenario/tree.h"
#include "common/scenario/words.h"

#include <glib.h>
#include <stdio.h>
#include <string.h>

_Static_assert((int)SCENARIO_TEXT_SIZE_MAX == (int)TREE_TEXT_SIZE_MAX,
               "a scenario that can be read from a file can be read from the network");
_Static_assert(sizeof(enum scenario_response) == sizeof(int), "FIELD_WORD writes an int");

#define AT(structure, member) .offset = offsetof(struct structure, member)

// ------------------------------------------------------------------------------------------------
// One scenario

struct document {
    struct scenario scenario;
    struct crash_document crash;
    struct formula_document formula;
    const struct tree_node *constraints;
    const struct tree_node *search;
    const struct tree_node *cases;
};

static const struct field crash_fields[] = {
    {"name", FIELD_NAME, AT(document, scenario.name)},
    {"model", FIELD_WORD, .optional = true, AT(document, scenario.model),
     .words = scenario_model_words},
    {"vehicle", FIELD_NODE, AT(document, crash.vehicle),
     .expected = "a mapping with mass, yaw_inertia and speed"},
    {"barrier", FIELD_NODE, AT(document, crash.barrier),
     .expected = "a mapping with face_x and edge_y"},
    {"springs", FIELD_NODE, AT(document, crash.springs), .expected = "a list of springs"},
    {"simulation", FIELD_NODE, .optional = true, AT(document, crash.simulation)},
    {"response", FIELD_WORD, AT(document, scenario.response), .words = scenario_response_words},
    {"firewall_distance", FIELD_NUMBER, AT(document, scenario.firewall_distance),
     .range = FIELD_NOT_NEGATIVE, .unit = "m"},
    {"constraints", FIELD_NODE, .optional = true, AT(document, constraints)},
    {"search", FIELD_NODE, .optional = true, AT(document, search)},
    {"cases", FIELD_NODE, .optional = true, AT(document, cases)},
};

static const struct field formula_fields[] = {
    {"name", FIELD_NAME, AT(document, scenario.name)},
    {"model", FIELD_WORD, .optional = true, AT(document, scenario.model),
     .words = scenario_model_words},
    {"variables", FIELD_NODE, AT(document, formula.variables),
     .expected = "a list of variables with name, lower and upper"},
    {"parameters", FIELD_NODE, .optional = true, AT(document, formula.parameters)},
    {"constraints", FIELD_NODE, .optional = true, AT(document, constraints)},
    {"search", FIELD_NODE, .optional = true, AT(document, search)},
    {"cases", FIELD_NODE, .optional = true, AT(document, cases)},
};

// Which keys there are depends on the model, so its word is read first.
static bool read_keys(const struct tree_node *root, struct document *document, struct error *error)
{
    static const struct field model_field = {.kind = FIELD_WORD, .words = scenario_model_words};
    const struct tree_node *model = tree_child(root, "model");
    if (model != NULL && !field_read_value(model, &model_field, &document->scenario.model, error))
        return false;
    return document->scenario.model == SCENARIO_MODEL_SMALL_OVERLAP
               ? field_read(root, crash_fields, G_N_ELEMENTS(crash_fields), document, error)
               : field_read(root, formula_fields, G_N_ELEMENTS(formula_fields), document, error);
}

// Without a constraint every design is good, and nobody asks for that on purpose.
static bool require_constraint(const struct tree_node *root, const struct scenario *scenario,
                               struct error *error)
{
    char name[SCENARIO_OUTCOME_NAME_SIZE];
    if (scenario->constraint_count > 0)
        return true;
    const struct tree_node *node = tree_spot(root, "constraints");
    tree_error(node, error, "%sexpected at least one constraint, as %s: {max: 0}",
               node == root ? "missing key 'constraints': " : "",
               scenario_outcome_name(scenario, 0, name));
    return false;
}

// Sections in an order in which each finds what it depends on.
static bool read_document(const struct tree_node *root, struct document *document,
                          struct error *error)
{
    struct scenario *scenario = &document->scenario;
    scenario_init(scenario);
    if (!read_keys(root, document, error))
        return false;
    document->formula.root = root;
    document->crash.firewall_distance = tree_child(root, "firewall_distance");
    // Real parts are whole curves; a formula's variables are what they are.
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP)
        scenario->search.promise = PROMISE_POINTS;
    bool read = scenario->model == SCENARIO_MODEL_SMALL_OVERLAP
                    ? crash_read(&document->crash, scenario, error)
                    : formula_read(&document->formula, scenario, error);
    if (!read || !constraint_read(document->constraints, scenario, error) ||
        !require_constraint(root, scenario, error) ||
        (document->search != NULL && !search_read(document->search, scenario, error)))
        return false;
    plausibility_constraints(document->constraints, scenario);
    return true;
}

// ------------------------------------------------------------------------------------------------
// Cases

// A case may change what happens to the designs, not which designs there are or how to search.
static bool refuse_keys_of_all_cases(const struct tree_node *node, struct error *error)
{
    static const char *const refused[] = {"model", "variables", "search", "cases"};
    for (uint32_t i = 0; i < node->count; i++) {
        for (size_t k = 0; k < G_N_ELEMENTS(refused); k++) {
            const char *key = node->keys[i]->text;
            const size_t length = strlen(refused[k]);
            if (strncmp(key, refused[k], length) != 0 ||
                (key[length] != '\0' && key[length] != '.'))
                continue;
            tree_error(node->keys[i], error, "expected no '%s' in a case: it is that of all cases",
                       refused[k]);
            return false;
        }
    }
    return true;
}

static bool read_case_name(const struct tree_node *node, struct scenario *scenario, uint32_t index,
                           struct error *error)
{
    static const struct field field = {.kind = FIELD_IDENTIFIER};
    char name[SCENARIO_NAME_SIZE] = "";
    const struct tree_node *value = tree_child(node, "name");
    if (node->kind != TREE_MAPPING || value == NULL) {
        tree_error(node, error, "expected a mapping with the case's name and what it overrides");
        return false;
    }
    if (!field_read_value(value, &field, name, error))
        return false;
    for (uint32_t i = 0; i < index; i++) {
        if (strcmp(scenario->cases[i].name, name) != 0)
            continue;
        tree_error(value, error,
                   "expected a name that no other case has, found %s, the name of "
                   "cases.%u",
                   name, i);
        return false;
    }
    return true;
}

// The structure that all cases share is what the search is for.
static bool same_structure(const struct tree_node *node, const struct scenario *scenario,
                           const struct scenario *of_case, struct error *error)
{
    const struct box *one = &scenario->design_space, *other = &of_case->design_space;
    if (other->count != one->count) {
        tree_error(node, error, "expected the %u variables of all cases, found %u", one->count,
                   other->count);
        return false;
    }
    for (uint32_t i = 0; i < one->count; i++) {
        const char *name = scenario->variables[i].name;
        const struct scenario_variable *variable = &scenario->variables[i];
        if (strcmp(of_case->variables[i].name, name) != 0) {
            tree_error(node, error, "expected the variable %s of all cases, found %s", name,
                       of_case->variables[i].name);
            return false;
        }
        if (other->lower[i] != one->lower[i] || other->upper[i] != one->upper[i]) {
            tree_error(node, error,
                       "expected the bounds of %s in all cases, %.15g to %.15g, found %.15g to "
                       "%.15g",
                       name, one->lower[i], one->upper[i], other->lower[i], other->upper[i]);
            return false;
        }
        if (variable->spring != SCENARIO_NO_SPRING &&
            scenario->springs[variable->spring].deformation[variable->point] !=
                of_case->springs[variable->spring].deformation[variable->point]) {
            tree_error(node, error, "expected %s at the deformation of all cases", name);
            return false;
        }
    }
    return true;
}

// The rest of a message about a value that may have come from outside the case.
static void name_case(struct error *error, const char *name)
{
    char suffix[SCENARIO_NAME_SIZE + 16];
    snprintf(suffix, sizeof suffix, " (in case %s)", name);
    if (strlen(error->text) + strlen(suffix) < sizeof error->text)
        g_strlcat(error->text, suffix, sizeof error->text);
}

static bool read_case(const struct tree *tree, const struct tree_node *node,
                      struct scenario *scenario, uint32_t index, struct error *error)
{
    static const char *const without[] = {"cases", "search", NULL};
    if (!read_case_name(node, scenario, index, error) || !refuse_keys_of_all_cases(node, error))
        return false;
    struct tree *overlaid = tree_copy(tree, without);
    struct document document = {0};
    bool read = true;
    for (uint32_t i = 0; i < node->count && read; i++)
        read =
            tree_overlay(overlaid, node->keys[i], node->items[i], TREE_MERGE, error) == STATUS_OK;
    read = read && read_document(tree_root(overlaid), &document, error);
    if (!read)
        name_case(error, tree_child(node, "name")->text);
    tree_free(overlaid);
    // Even a broken one is the scenario's to release.
    scenario->cases[index] = document.scenario;
    scenario->case_count = index + 1;
    return read && same_structure(node, scenario, &scenario->cases[index], error);
}

// The outer scenario's constraints become those of its cases, their outcomes counted through.
static bool join_constraints(const struct tree_node *node, struct scenario *scenario,
                             struct error *error)
{
    uint32_t outcomes = 0, count = 0;
    for (uint32_t i = 0; i < scenario->case_count; i++) {
        const struct scenario *of_case = &scenario->cases[i];
        if (of_case->constraint_count > SCENARIO_CONSTRAINT_MAX - count) {
            tree_error(node, error, "expected at most %d constraints in all cases together",
                       SCENARIO_CONSTRAINT_MAX);
            return false;
        }
        for (uint32_t k = 0; k < of_case->constraint_count; k++) {
            scenario->constraints[count] = of_case->constraints[k];
            scenario->constraints[count++].outcome += outcomes;
        }
        outcomes += scenario_outcome_count(of_case);
    }
    scenario->constraint_count = count;
    return true;
}

static bool read_cases(const struct tree *tree, const struct tree_node *node,
                       struct scenario *scenario, struct error *error)
{
    if (node->kind != TREE_SEQUENCE || node->count < 1 || node->count > SCENARIO_CASE_MAX) {
        char shown[TREE_SHOWN_SIZE];
        tree_error(node, error, "expected a list of 1 to %d cases, found %s", SCENARIO_CASE_MAX,
                   tree_shown(node, shown));
        return false;
    }
    scenario->cases = g_new0(struct scenario, node->count);
    for (uint32_t i = 0; i < node->count; i++) {
        if (!read_case(tree, node->items[i], scenario, i, error))
            return false;
    }
    plausibility_join_cases(scenario);
    return join_constraints(node, scenario, error);
}

// ------------------------------------------------------------------------------------------------
// The whole

// The text that travels and is hashed. Block style can be longer than what was read.
static bool keep_text(const struct tree *tree, struct scenario *scenario, struct error *error)
{
    scenario->text = tree_emit(tree, &scenario->text_size);
    scenario->digest = digest_of(scenario->text, scenario->text_size);
    if (scenario->text_size <= SCENARIO_TEXT_SIZE_MAX)
        return true;
    tree_error(tree_root(tree), error, "expected at most %d bytes in block style, found %zu",
               SCENARIO_TEXT_SIZE_MAX, scenario->text_size);
    return false;
}

enum status scenario_read_tree(struct scenario *scenario, const struct tree *tree,
                               struct error *error)
{
    struct error unread;
    error = error != NULL ? error : &unread;
    struct document document = {0};
    const bool read =
        read_document(tree_root(tree), &document, error) &&
        (document.cases == NULL || read_cases(tree, document.cases, &document.scenario, error)) &&
        keep_text(tree, &document.scenario, error);
    if (!read)
        scenario_fini(&document.scenario);
    *scenario = document.scenario;
    return read ? STATUS_OK : error->status;
}

// Reads the scenario out of the tree, which is freed; a NULL tree is an error that is told already.
static enum status read_overridden(struct scenario *scenario, struct tree *tree,
                                   const char *const *overrides, size_t override_count,
                                   struct error *error)
{
    *scenario = (struct scenario){0};
    enum status status = tree != NULL ? STATUS_OK : STATUS_INVALID;
    for (size_t i = 0; i < override_count && status == STATUS_OK; i++)
        status = tree_set(tree, overrides[i], error);
    if (status == STATUS_OK)
        status = scenario_read_tree(scenario, tree, error);
    tree_free(tree);
    return status;
}

enum status scenario_read_file(struct scenario *scenario, const char *path,
                               const char *const *overrides, size_t override_count,
                               struct error *error)
{
    enum status status =
        read_overridden(scenario, tree_load(path, error), overrides, override_count, error);
    if (status == STATUS_OK && plausibility_refused(scenario, error)) {
        scenario_fini(scenario);
        status = STATUS_INVALID;
    }
    return status;
}

enum status scenario_read_text(struct scenario *scenario, const char *source, const char *text,
                               size_t text_size, const char *const *overrides,
                               size_t override_count, struct error *error)
{
    return read_overridden(scenario, tree_parse(source, text, text_size, error), overrides,
                           override_count, error);
}
