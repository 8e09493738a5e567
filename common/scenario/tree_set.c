#include "common/scenario/tree_node.h"

#include <glib.h>
#include <string.h>

static bool find_item(const struct tree_node *node, const char *step, uint32_t *index,
                      const char *source, struct error *error)
{
    guint64 number;
    if (node->count > 0 &&
        g_ascii_string_to_unsigned(step, 10, 0, node->count - 1, &number, NULL)) {
        *index = (uint32_t)number;
        return true;
    }
    char path[TREE_PATH_SIZE];
    tree_path(node, path);
    if (node->count == 0)
        error_set(error, STATUS_INVALID, "%s:1:1: %s: the list is empty: there is no item '%s'",
                  source, path, step);
    else
        error_set(error, STATUS_INVALID, "%s:1:1: %s: expected an index from 0 to %u, found '%s'",
                  source, path, node->count - 1, step);
    return false;
}

// Finds the slot of one step of the path. Keys that are missing stand behind the last one.
static bool find_slot(struct tree_node *node, const char *step, const char *source,
                      struct tree_slot *slot, struct error *error)
{
    slot->node = node;
    step = tree_plain_text(step);
    if (node->kind == TREE_SEQUENCE)
        return find_item(node, step, &slot->index, source, error);
    char path[TREE_PATH_SIZE], shown[TREE_SHOWN_SIZE];
    if (node->kind == TREE_SCALAR) {
        error_set(error, STATUS_INVALID, "%s:1:1: %s: expected a mapping to set '%s' in, found %s",
                  source, tree_path(node, path), step, tree_shown(node, shown));
        return false;
    }
    if (tree_find_key(node, step, &slot->index))
        return true;
    slot->index = node->count;
    if (node->count < TREE_KEY_MAX)
        return true;
    error_set(error, STATUS_INVALID, "%s:1:1: %s: expected at most %d keys in one mapping", source,
              tree_path(node, path), TREE_KEY_MAX);
    return false;
}

// Puts `value` into the slot, in place of what is there or under a new key.
static void fill_slot(struct tree *tree, const struct tree_slot *slot, const char *step,
                      struct tree_node *value)
{
    struct tree_node *node = slot->node;
    if (slot->index < node->count) {
        tree_node_free(node->items[slot->index]);
        node->items[slot->index] = value;
        return;
    }
    struct tree_node *key = tree_node_create(tree, TREE_SCALAR, value->source, 1, 1, node);
    key->text = g_string_chunk_insert_const(tree->strings, tree_plain_text(step));
    tree_node_append(node, key, value);
}

// Walks all steps but the last, making mappings on the way; `slot` receives the last one's place.
static bool walk(struct tree *tree, char **steps, const char *source, struct tree_slot *slot,
                 struct error *error)
{
    struct tree_node *node = tree->root;
    for (; steps[1] != NULL; steps++) {
        if (!find_slot(node, steps[0], source, slot, error))
            return false;
        if (slot->index == node->count)
            fill_slot(tree, slot, steps[0],
                      tree_node_create(tree, TREE_MAPPING, source, 1, 1, node));
        node = node->items[slot->index];
    }
    return find_slot(node, steps[0], source, slot, error);
}

static enum status set_steps(struct tree *tree, char **steps, uint32_t depth, const char *value,
                             const char *source, struct error *error)
{
    if (depth >= TREE_DEPTH_MAX || tree->node_count + 2 * depth > TREE_NODE_MAX)
        return error_set(error, STATUS_INVALID, "%s:1:1: expected at most %d levels of nesting",
                         source, TREE_DEPTH_MAX);
    // The value is parsed first, so that a broken one leaves the tree as it was.
    struct tree_node *node =
        tree_parse_below(tree, source, value, strlen(value), NULL, depth + 1, error);
    if (node == NULL)
        return STATUS_INVALID;
    struct tree_slot slot;
    if (!walk(tree, steps, source, &slot, error)) {
        tree_node_free(node);
        return STATUS_INVALID;
    }
    node->parent = slot.node;
    fill_slot(tree, &slot, steps[depth - 1], node);
    return STATUS_OK;
}

// An assignment stands for itself in messages; of a long one the beginning does.
static const char *name_assignment(struct tree *tree, const char *assignment)
{
    char *source =
        strlen(assignment) <= TREE_SHOWN_SIZE
            ? g_strdup_printf("--set %s", assignment)
            : g_strdup_printf("--set %.*s...", tree_shown_length(assignment, TREE_SHOWN_SIZE),
                              assignment);
    tree_one_line(source);
    const char *kept = g_string_chunk_insert_const(tree->strings, source);
    g_free(source);
    return kept;
}

enum status tree_set(struct tree *tree, const char *assignment, struct error *error)
{
    const char *equals = strchr(assignment, '=');
    if (!g_utf8_validate(assignment, -1, NULL))
        return error_set(error, STATUS_INVALID, "--set: expected UTF-8");
    const char *kept = name_assignment(tree, assignment);
    if (equals == NULL || equals == assignment || equals[1] == '\0')
        return error_set(error, STATUS_INVALID, "%s:1:1: expected KEY.PATH=VALUE", kept);

    char *path = g_strndup(assignment, (gsize)(equals - assignment));
    char **steps = g_strsplit(path, ".", -1);
    enum status status = STATUS_OK;
    for (char **step = steps; *step != NULL && status == STATUS_OK; step++) {
        if (**step == '\0')
            status = error_set(error, STATUS_INVALID,
                               "%s:1:1: expected keys with single dots in between, found '%s'",
                               kept, path);
    }
    if (status == STATUS_OK)
        status = set_steps(tree, steps, g_strv_length(steps), equals + 1, kept, error);
    if (status != STATUS_OK && error != NULL)
        tree_one_line(error->text);
    g_strfreev(steps);
    g_free(path);
    return status;
}
