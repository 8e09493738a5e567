#include "common/scenario/tree_node.h"

#include <glib.h>

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

struct tree_node *tree_copy_node(const struct tree_node *node, const struct tree_node *parent)
{
    struct tree_node *copy = copy_single(node, parent);
    for (uint32_t i = 0; i < node->count; i++)
        tree_node_append(copy, node->keys != NULL ? copy_single(node->keys[i], copy) : NULL,
                         tree_copy_node(node->items[i], copy));
    return copy;
}

// The root and what is below it, but for the keys in `without`.
static struct tree_node *copy_root(const struct tree_node *root, const char *const *without)
{
    struct tree_node *copy = copy_single(root, NULL);
    for (uint32_t i = 0; i < root->count; i++) {
        const struct tree_node *key = root->keys != NULL ? root->keys[i] : NULL;
        if (key != NULL && g_strv_contains(without, key->text))
            continue;
        tree_node_append(copy, key != NULL ? copy_single(key, copy) : NULL,
                         tree_copy_node(root->items[i], copy));
    }
    return copy;
}

struct tree *tree_copy(const struct tree *tree, const char *const *without)
{
    struct tree *copy = g_new0(struct tree, 1);
    copy->strings = g_string_chunk_new(256); // of the steps of paths only
    copy->node_count = tree->node_count;
    copy->root = copy_root(tree->root, without);
    return copy;
}
