#include "common/scenario/tree_node.h"

#include <glib.h>
#include <string.h>

// The deepest copy would otherwise be deeper than any text that can be read.
static bool copy_fits(const struct tree_node *node, uint32_t depth, struct error *error)
{
    if (depth <= TREE_DEPTH_MAX)
        return true;
    tree_error(node, error, "expected at most %d levels of nesting", TREE_DEPTH_MAX);
    return false;
}

static struct tree_node *copy_single(const struct tree_node *node, const struct tree_node *parent)
{
    struct tree_node *copy = g_new0(struct tree_node, 1);
    *copy = *node;
    copy->parent = parent;
    copy->count = 0;
    copy->items = NULL;
    copy->keys = NULL;
    return copy;
}

// A copy with everything below. Returns NULL with `error` filled.
static struct tree_node *copy_node(const struct tree_node *node, const struct tree_node *parent,
                                   uint32_t depth, struct error *error)
{
    if (!copy_fits(node, depth, error))
        return NULL;
    struct tree_node *copy = copy_single(node, parent);
    for (uint32_t i = 0; i < node->count; i++) {
        struct tree_node *item = copy_node(node->items[i], copy, depth + 1, error);
        if (item == NULL) {
            tree_node_free(copy);
            return NULL;
        }
        tree_node_append(copy, node->keys != NULL ? copy_single(node->keys[i], copy) : NULL, item);
    }
    return copy;
}

// The item of a list that an override's key means: its index, or the name it has.
static bool find_named(const struct tree_node *list, const struct tree_node *key, const char *step,
                       uint32_t *index, struct error *error)
{
    guint64 number;
    if (list->count > 0 &&
        g_ascii_string_to_unsigned(step, 10, 0, list->count - 1, &number, NULL)) {
        *index = (uint32_t)number;
        return true;
    }
    for (uint32_t i = 0; i < list->count; i++) {
        const struct tree_node *name = tree_child(list->items[i], "name");
        if (name != NULL && name->kind == TREE_SCALAR && strcmp(name->text, step) == 0) {
            *index = i;
            return true;
        }
    }
    tree_error(key, error, "expected the name of an item or an index below %u, found '%s'",
               list->count, step);
    return false;
}

// Finds or makes the place that `step` names in `node`; a place that is made stands at `key`.
static bool overlay_slot(struct tree_node *node, const struct tree_node *key, const char *step,
                         struct tree_slot *slot, struct error *error)
{
    slot->node = node;
    if (node->kind == TREE_SEQUENCE)
        return find_named(node, key, step, &slot->index, error);
    if (node->kind == TREE_SCALAR) {
        tree_error(key, error, "expected a key of a mapping, but what it is set in has none");
        return false;
    }
    if (tree_find_key(node, step, &slot->index))
        return true;
    slot->index = node->count;
    if (node->count < TREE_KEY_MAX)
        return true;
    tree_error(key, error, "expected at most %d keys in one mapping", TREE_KEY_MAX);
    return false;
}

// Puts `value` where the slot is; a new key has the text `step`, which the tree keeps.
static void overlay_fill(const struct tree_slot *slot, const struct tree_node *key,
                         const char *step, struct tree_node *value)
{
    struct tree_node *node = slot->node;
    if (slot->index < node->count) {
        tree_node_free(node->items[slot->index]);
        node->items[slot->index] = value;
        return;
    }
    struct tree_node *copy = copy_single(key, node);
    copy->text = step;
    tree_node_append(node, copy, value);
}

static bool overlay(struct tree_node *node, const struct tree_node *overrides, uint32_t depth,
                    struct error *error);

static bool overlay_value(const struct tree_slot *slot, const struct tree_node *key,
                          const char *step, const struct tree_node *value, uint32_t depth,
                          struct error *error)
{
    struct tree_node *there =
        slot->index < slot->node->count ? slot->node->items[slot->index] : NULL;
    if (there != NULL && there->kind != TREE_SCALAR && value->kind == TREE_MAPPING)
        return overlay(there, value, depth, error);
    struct tree_node *copy = copy_node(value, slot->node, depth, error);
    if (copy != NULL)
        overlay_fill(slot, key, step, copy);
    return copy != NULL;
}

// Lays a mapping over `node`, which stands at `depth`.
static bool overlay(struct tree_node *node, const struct tree_node *overrides, uint32_t depth,
                    struct error *error)
{
    for (uint32_t i = 0; i < overrides->count; i++) {
        const struct tree_node *key = overrides->keys[i];
        struct tree_slot slot;
        if (!overlay_slot(node, key, key->text, &slot, error) ||
            !overlay_value(&slot, key, key->text, overrides->items[i], depth + 1, error))
            return false;
    }
    return true;
}

// An empty mapping at the place of a key, to set what follows in the path in.
static struct tree_node *overlay_mapping(const struct tree_node *key,
                                         const struct tree_node *parent)
{
    struct tree_node *mapping = copy_single(key, parent);
    mapping->kind = TREE_MAPPING;
    mapping->text = NULL;
    mapping->quoted = false;
    return mapping;
}

// Lays one entry of the first level over the root: its key is a path.
static bool overlay_path(struct tree *tree, const struct tree_node *key,
                         const struct tree_node *value, struct error *error)
{
    char **steps = g_strsplit(key->text, ".", -1);
    struct tree_node *node = tree->root;
    uint32_t depth = 2;
    struct tree_slot slot;
    bool found = true;
    for (uint32_t i = 0; found && steps[i] != NULL; i++, depth++) {
        const char *step = g_string_chunk_insert_const(tree->strings, steps[i]);
        found = copy_fits(key, depth, error) && overlay_slot(node, key, step, &slot, error);
        if (found && steps[i + 1] == NULL)
            found = overlay_value(&slot, key, step, value, depth, error);
        else if (found) {
            if (slot.index == node->count)
                overlay_fill(&slot, key, step, overlay_mapping(key, node));
            node = node->items[slot.index];
        }
    }
    g_strfreev(steps);
    return found;
}

// The root and what is below it, but for the keys in `without`.
static struct tree_node *copy_root(const struct tree_node *root, const char *const *without,
                                   struct error *error)
{
    struct tree_node *copy = copy_single(root, NULL);
    for (uint32_t i = 0; i < root->count; i++) {
        if (root->keys != NULL && g_strv_contains(without, root->keys[i]->text))
            continue;
        struct tree_node *item = copy_node(root->items[i], copy, 2, error);
        g_assert(item != NULL); // it is no deeper than the tree
        tree_node_append(copy, root->keys != NULL ? copy_single(root->keys[i], copy) : NULL, item);
    }
    return copy;
}

struct tree *tree_overlay(const struct tree *tree, const struct tree_node *overrides,
                          const char *const *without, struct error *error)
{
    struct tree *copy = g_new0(struct tree, 1);
    copy->strings = g_string_chunk_new(256); // of steps only, the nodes' texts are borrowed
    copy->node_count = tree->node_count;
    copy->root = copy_root(tree->root, without, error);
    for (uint32_t i = 0; i < overrides->count; i++) {
        if (!overlay_path(copy, overrides->keys[i], overrides->items[i], error)) {
            tree_free(copy);
            return NULL;
        }
    }
    return copy;
}
