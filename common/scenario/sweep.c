#include "common/scenario/sweep.h"

#include "common/scenario/field.h"
#include "common/scenario/plausibility.h"
#include "common/scenario/scenario_read.h"
#include "common/scenario/sweep_state.h"

#include <glib.h>
#include <string.h>

// What the top of the file holds.
struct document {
    char name[SCENARIO_NAME_SIZE];
    const struct tree_node *base;
    const struct tree_node *axes;
    uint32_t replicates;
};

// ---- Base and replicates ----

static bool read_base(struct sweep *sweep, const struct tree_node *node, struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind != TREE_SCALAR || node->text[0] == '\0') {
        tree_error(node, error, "expected the name of a scenario file, found %s",
                   tree_shown(node, shown));
        return false;
    }
    char *path = sweep_table_path(node);
    sweep->base = tree_load(path, error);
    const bool nested = sweep->base != NULL && tree_child(tree_root(sweep->base), "sweep") != NULL;
    if (nested)
        tree_error(node, error, "expected a scenario, found a sweep in %s", path);
    g_free(path);
    return sweep->base != NULL && !nested;
}

// Whether a path leads to the other's value or into it.
static bool leads_into(const char *path, const char *other)
{
    const size_t length = strlen(other);
    return strncmp(path, other, length) == 0 && (path[length] == '\0' || path[length] == '.');
}

// An option that an axis overrules would do nothing.
static bool check_override(const struct sweep *sweep, const char *assignment, struct error *error)
{
    char *path = g_strndup(assignment, strcspn(assignment, "="));
    char *resolved = tree_resolve(sweep->base, path);
    bool kept = true;
    for (guint i = 0; i < sweep->columns->len && kept; i++) {
        const struct sweep_column *column = &g_array_index(sweep->columns, struct sweep_column, i);
        kept = !leads_into(resolved, column->resolved);
        if (!kept)
            error_set(error, STATUS_INVALID,
                      "--set %s: %s is changed by the sweep: expected a key that is not",
                      assignment, column->path.text);
    }
    g_free(resolved);
    g_free(path);
    return kept;
}

// The seeds follow that of the base.
static bool read_replicates(struct sweep *sweep, uint32_t count, struct error *error)
{
    const struct tree_node *place = tree_child(tree_root(sweep->tree), "replicates");
    struct scenario scenario;
    if (scenario_read_tree(&scenario, sweep->base, error) != STATUS_OK)
        return false;
    const uint64_t seed = scenario.search.seed;
    scenario_fini(&scenario);
    return sweep_axes_add_seeds(sweep, place, seed, count, error);
}

// ---- Reading ----

bool sweep_detect(const char *path)
{
    struct error unread;
    struct tree *tree = tree_load(path, &unread);
    const bool found = tree != NULL && tree_child(tree_root(tree), "sweep") != NULL;
    tree_free(tree);
    return found;
}

static bool read_document(struct sweep *sweep, const char *const *overrides, size_t override_count,
                          struct error *error)
{
    static const struct field fields[] = {
        {"sweep", FIELD_NAME, false, offsetof(struct document, name), FIELD_ANY, NULL, NULL,
         "the sweep's name"},
        {"base", FIELD_NODE, false, offsetof(struct document, base), FIELD_ANY, NULL, NULL,
         "the name of a scenario file"},
        {"axes", FIELD_NODE, true, offsetof(struct document, axes), FIELD_ANY, NULL, NULL, NULL},
        {"replicates", FIELD_COUNT, true, offsetof(struct document, replicates),
         FIELD_FROM_TO(1, SWEEP_CASE_MAX), NULL, NULL, NULL},
    };
    const struct tree_node *root = tree_root(sweep->tree);
    struct document document = {0};
    if (!field_read(root, fields, G_N_ELEMENTS(fields), &document, error))
        return false;
    memcpy(sweep->name, document.name, sizeof sweep->name);
    if (document.axes == NULL && document.replicates == 0) {
        tree_error(root, error, "missing key 'axes': expected a list of axes, or `replicates`");
        return false;
    }
    bool read = read_base(sweep, document.base, error);
    for (size_t i = 0; i < override_count && read; i++)
        read = tree_set(sweep->base, overrides[i], error) == STATUS_OK;
    read = read && (document.axes == NULL || sweep_axes_read(sweep, document.axes, error)) &&
           (document.replicates == 0 || read_replicates(sweep, document.replicates, error));
    for (size_t i = 0; i < override_count && read; i++)
        read = check_override(sweep, overrides[i], error);
    return read && sweep_case_label(sweep, error);
}

static void free_tree(gpointer tree)
{
    tree_free(tree);
}

// Takes the tree of a sweep's document; NULL: `error` says why there is none.
static enum status read_tree(struct sweep **result, struct tree *tree, const char *const *overrides,
                             size_t override_count, struct error *error)
{
    struct sweep *sweep = g_new0(struct sweep, 1);
    sweep->strings = g_string_chunk_new(4096);
    sweep->trees = g_ptr_array_new_with_free_func(free_tree);
    sweep->axes = g_array_new(FALSE, FALSE, sizeof(struct sweep_axis));
    sweep->columns = g_array_new(FALSE, FALSE, sizeof(struct sweep_column));
    sweep->paths = g_ptr_array_new_null_terminated(0, NULL, TRUE);
    sweep->case_count = 1;
    sweep->tree = tree;
    if (sweep->tree == NULL || !read_document(sweep, overrides, override_count, error)) {
        sweep_free(sweep);
        return STATUS_INVALID;
    }
    *result = sweep;
    return STATUS_OK;
}

enum status sweep_read_file(struct sweep **sweep, const char *path, const char *const *overrides,
                            size_t override_count, struct error *error)
{
    struct error unread;
    error = error != NULL ? error : &unread;
    *sweep = NULL;
    return read_tree(sweep, tree_load(path, error), overrides, override_count, error);
}

enum status sweep_of_seeds(struct sweep **sweep, const char *path, const char *const *overrides,
                           size_t override_count, uint32_t count, struct error *error)
{
    struct error unread;
    error = error != NULL ? error : &unread;
    *sweep = NULL;
    struct scenario scenario;
    enum status status = scenario_read_file(&scenario, path, overrides, override_count, error);
    if (status != STATUS_OK)
        return status;
    // In single quotes a quote alone means something, and is doubled.
    g_auto(GStrv) parts = g_strsplit(path, "'", -1);
    g_autofree char *base = g_strjoinv("''", parts);
    g_autofree char *text =
        g_strdup_printf("{sweep: '%s', base: '%s', replicates: %u}", scenario.name, base, count);
    g_autofree char *source = g_strdup_printf("--seeds %u", count);
    scenario_fini(&scenario);
    return read_tree(sweep, tree_parse(source, text, strlen(text), error), overrides,
                     override_count, error);
}

void sweep_free(struct sweep *sweep)
{
    if (sweep == NULL)
        return;
    for (guint i = 0; i < sweep->axes->len; i++) {
        struct sweep_axis *axis = &g_array_index(sweep->axes, struct sweep_axis, i);
        g_array_unref(axis->cells);
        if (axis->labels != NULL)
            g_ptr_array_unref(axis->labels);
    }
    for (guint i = 0; i < sweep->columns->len; i++)
        g_free(g_array_index(sweep->columns, struct sweep_column, i).resolved);
    g_array_unref(sweep->axes);
    g_array_unref(sweep->columns);
    g_ptr_array_unref(sweep->paths);
    g_ptr_array_unref(sweep->trees);
    g_string_chunk_free(sweep->strings);
    tree_free(sweep->base);
    tree_free(sweep->tree);
    g_free(sweep);
}

// ---- Cases ----

const char *sweep_name(const struct sweep *sweep)
{
    return sweep->name;
}

uint32_t sweep_case_count(const struct sweep *sweep)
{
    return sweep->case_count;
}

const char *const *sweep_columns(const struct sweep *sweep)
{
    return (const char *const *)sweep->paths->pdata;
}

uint32_t sweep_column_count(const struct sweep *sweep)
{
    return sweep->columns->len;
}

const char *sweep_value(const struct sweep *sweep, uint32_t index, uint32_t column)
{
    return sweep_case_cell(sweep, index, column)->text;
}

static enum status lay_cell(const struct sweep *sweep, uint32_t index, uint32_t column,
                            struct tree *tree, struct error *error)
{
    const struct sweep_cell *cell = sweep_case_cell(sweep, index, column);
    const struct tree_node scalar = {.kind = TREE_SCALAR,
                                     .source = cell->source,
                                     .line = cell->line,
                                     .column = cell->column,
                                     .text = cell->text};
    return tree_overlay(tree, &g_array_index(sweep->columns, struct sweep_column, column).path,
                        cell->node != NULL ? cell->node : &scalar, TREE_REPLACE, error);
}

enum status sweep_scenario(const struct sweep *sweep, uint32_t index, struct scenario *scenario,
                           struct error *error)
{
    static const char *const nothing[] = {NULL};
    struct error reason = {0};
    *scenario = (struct scenario){0};
    struct tree *tree = tree_copy(sweep->base, nothing);
    enum status status = STATUS_OK;
    for (uint32_t c = 0; c < sweep->columns->len && status == STATUS_OK; c++)
        status = lay_cell(sweep, index, c, tree, &reason);
    if (status == STATUS_OK)
        status = scenario_read_tree(scenario, tree, &reason);
    tree_free(tree);
    if (status == STATUS_OK && plausibility_refused(scenario, &reason)) {
        status = reason.status;
        scenario_fini(scenario);
    }
    if (status == STATUS_OK)
        return STATUS_OK;
    char name[SWEEP_CASE_NAME_SIZE];
    return error_set(error, status, "%s (in the case %s of %s)", reason.text,
                     sweep_case_name(sweep, index, name), tree_root(sweep->tree)->source);
}
