#include "common/scenario/sweep_state.h"

#include <glib.h>
#include <string.h>

enum { LABEL_MAX = 32 }; // [bytes] of a value in a name

// What YAML reads as the same plain scalar wherever it stands.
static bool plain_scalar(const char *text)
{
    return text[0] != '\0' && strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                           "0123456789_.+-") == strlen(text);
}

// A scalar in double quotes. One that is not plain_scalar() is no number, so quotes change nothing.
static void put_quoted(GString *text, const char *scalar)
{
    g_string_append_c(text, '"');
    for (const char *c = scalar; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\')
            g_string_append_printf(text, "\\%c", *c);
        else if ((unsigned char)*c < 0x20 || *c == 0x7f)
            g_string_append_printf(text, "\\x%02x", (unsigned char)*c);
        else
            g_string_append_c(text, *c);
    }
    g_string_append_c(text, '"');
}

// A node on one line: "[1, 2]", "{lower: 0}". Depth is bounded by the tree's.
static void put_node(GString *text, const struct tree_node *node)
{
    if (node->kind == TREE_SCALAR) {
        if (!node->quoted && plain_scalar(node->text))
            g_string_append(text, node->text);
        else
            put_quoted(text, node->text);
        return;
    }
    const bool mapping = node->kind == TREE_MAPPING;
    g_string_append_c(text, mapping ? '{' : '[');
    for (uint32_t i = 0; i < node->count; i++) {
        g_string_append(text, i > 0 ? ", " : "");
        if (mapping) {
            put_node(text, node->keys[i]);
            g_string_append(text, ": ");
        }
        put_node(text, node->items[i]);
    }
    g_string_append_c(text, mapping ? '}' : ']');
}

// Whether the node's text on one line is read as the same node again. A plain scalar of several
// words needs quotes there, and --set would get it with them.
static bool reads_back(const struct tree_node *node)
{
    bool same = node->kind != TREE_SCALAR || node->quoted || plain_scalar(node->text);
    for (uint32_t i = 0; i < node->count && same; i++)
        same = reads_back(node->items[i]) && (node->keys == NULL || reads_back(node->keys[i]));
    return same;
}

void sweep_cell_add(struct sweep *sweep, struct sweep_axis *axis, const char *text,
                    const struct tree_node *node, const struct tree_node *place)
{
    const struct sweep_cell cell = {
        .text = g_string_chunk_insert_const(sweep->strings, text),
        .node = node,
        .source = place->source,
        .line = place->line,
        .column = place->column,
        .plain = strlen(text) <= LABEL_MAX && strpbrk(text, "[]{},/\"") == NULL,
    };
    g_array_append_val(axis->cells, cell);
}

bool sweep_cell_add_text(struct sweep *sweep, struct sweep_axis *axis, const char *text,
                         const struct tree_node *place, struct error *error)
{
    const struct tree_node *node = NULL;
    if (!plain_scalar(text)) { // most need no tree
        struct tree *tree = tree_parse_at(place, text, strlen(text), error);
        if (tree == NULL)
            return false;
        g_ptr_array_add(sweep->trees, tree);
        node = tree_root(tree);
    }
    sweep_cell_add(sweep, axis, text, node, place);
    return true;
}

bool sweep_cell_add_node(struct sweep *sweep, struct sweep_axis *axis, const struct tree_node *node,
                         struct error *error)
{
    GString *text = g_string_new(NULL);
    put_node(text, node);
    bool added = true;
    if (reads_back(node))
        sweep_cell_add(sweep, axis, text->str, node, node);
    else
        added = sweep_cell_add_text(sweep, axis, text->str, node, error);
    g_string_free(text, TRUE);
    return added;
}
