#include "common/scenario/tree_node.h"

#include <glib.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

// The overlay in progress.
struct overlay {
    struct tree *tree;
    enum tree_manner manner;
    struct error *error;
};

static bool refuse(const struct overlay *overlay, const struct tree_node *place,
                   const struct tree_node *node, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

// Says what is wrong with a step, at the place where the path was given and with the path of the
// node at which it leads no further.
static bool refuse(const struct overlay *overlay, const struct tree_node *place,
                   const struct tree_node *node, const char *format, ...)
{
    char message[ERROR_TEXT_SIZE], path[TREE_PATH_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    tree_path(node, path);
    char *whole = g_strconcat(path, path[0] == '\0' ? "" : ": ", message, NULL);
    tree_error_at(overlay->error, place->source, place->line, place->column, whole);
    g_free(whole);
    return false;
}

static bool refuse_item(const struct overlay *overlay, const struct tree_node *place,
                        const struct tree_node *list, const char *step)
{
    if (list->count == 0)
        return refuse(overlay, place, list, "the list is empty: there is no item '%s'", step);
    return refuse(overlay, place, list,
                  "expected the name of an item or an index from 0 to %u, found '%s'",
                  list->count - 1, step);
}

// Finds the slot that one step leads to. Keys that are missing stand behind the last one.
static bool find_slot(const struct overlay *overlay, const struct tree_node *place,
                      struct tree_node *node, const char *step, struct tree_slot *slot)
{
    char shown[TREE_SHOWN_SIZE];
    *slot = (struct tree_slot){.node = node};
    if (node->kind == TREE_SEQUENCE)
        return tree_find_item(node, step, &slot->index) || refuse_item(overlay, place, node, step);
    if (node->kind == TREE_SCALAR)
        return refuse(overlay, place, node, "expected a mapping to set '%s' in, found %s", step,
                      tree_shown(node, shown));
    if (tree_find_key(node, step, &slot->index))
        return true;
    slot->index = node->count;
    return node->count < TREE_KEY_MAX ||
           refuse(overlay, place, node, "expected at most %d keys in one mapping", TREE_KEY_MAX);
}

// Puts `value` into the slot, in place of what is there or under a new key.
static void fill_slot(const struct overlay *overlay, const struct tree_slot *slot,
                      const struct tree_node *place, const char *step, struct tree_node *value)
{
    struct tree_node *node = slot->node;
    if (slot->index < node->count) {
        tree_node_free(node->items[slot->index]);
        node->items[slot->index] = value;
        return;
    }
    struct tree_node *key = tree_node_create(overlay->tree, TREE_SCALAR, place->source, place->line,
                                             place->column, node);
    key->text = g_string_chunk_insert_const(overlay->tree->strings, step);
    tree_node_append(node, key, value);
}

static bool merge(const struct overlay *overlay, struct tree_node *node,
                  const struct tree_node *changes);

// Lays the value over what is in the slot.
static bool lay(const struct overlay *overlay, const struct tree_slot *slot,
                const struct tree_node *place, const char *step, const struct tree_node *value)
{
    struct tree_node *there =
        slot->index < slot->node->count ? slot->node->items[slot->index] : NULL;
    if (overlay->manner == TREE_MERGE && there != NULL && there->kind != TREE_SCALAR &&
        value->kind == TREE_MAPPING)
        return merge(overlay, there, value);
    fill_slot(overlay, slot, place, step, tree_copy_node(value, slot->node));
    return true;
}

// Lays the entries of a mapping over `node`.
static bool merge(const struct overlay *overlay, struct tree_node *node,
                  const struct tree_node *changes)
{
    for (uint32_t i = 0; i < changes->count; i++) {
        const struct tree_node *key = changes->keys[i];
        struct tree_slot slot;
        if (!find_slot(overlay, key, node, key->text, &slot) ||
            !lay(overlay, &slot, key, key->text, changes->items[i]))
            return false;
    }
    return true;
}

static uint32_t depth_of(const struct tree_node *node)
{
    uint32_t deepest = 0;
    for (uint32_t i = 0; i < node->count; i++)
        deepest = MAX(deepest, depth_of(node->items[i]));
    return 1 + deepest;
}

// Walks all steps but the last, making mappings on the way, and lays the value at the last.
static bool walk(const struct overlay *overlay, char **steps, const struct tree_node *place,
                 const struct tree_node *value)
{
    struct tree_node *node = overlay->tree->root;
    struct tree_slot slot;
    for (;; steps++) {
        const char *step = tree_plain_text(steps[0]);
        if (!find_slot(overlay, place, node, step, &slot))
            return false;
        if (steps[1] == NULL)
            return lay(overlay, &slot, place, step, value);
        if (slot.index == node->count)
            fill_slot(overlay, &slot, place, step,
                      tree_node_create(overlay->tree, TREE_MAPPING, place->source, place->line,
                                       place->column, node));
        node = node->items[slot.index];
    }
}

enum status tree_overlay(struct tree *tree, const struct tree_node *path,
                         const struct tree_node *value, enum tree_manner manner,
                         struct error *error)
{
    const struct overlay overlay = {.tree = tree, .manner = manner, .error = error};
    char **steps = g_strsplit(path->text, ".", -1);
    bool laid = true;
    for (char **step = steps; *step != NULL && laid; step++)
        laid = **step != '\0' ||
               refuse(&overlay, path, tree->root,
                      "expected keys with single dots in between, found '%s'", path->text);
    // The whole depth is looked at first, so that no mapping is made for a value that does not fit.
    if (laid && g_strv_length(steps) + depth_of(value) > TREE_DEPTH_MAX)
        laid = refuse(&overlay, path, tree->root, "expected at most %d levels of nesting",
                      TREE_DEPTH_MAX);
    laid = laid && walk(&overlay, steps, path, value);
    g_strfreev(steps);
    return laid ? STATUS_OK : STATUS_INVALID;
}
