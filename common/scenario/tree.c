#include "common/scenario/tree_node.h"

#include <assert.h>
#include <glib.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

// ---- Messages ----

void tree_one_line(char *text)
{
    for (; *text != '\0'; text++) {
        if ((unsigned char)*text < 0x20 || *text == 0x7f)
            *text = '?';
    }
}

enum status tree_error_at(struct error *error, const char *source, uint32_t line, uint32_t column,
                          const char *message)
{
    enum status status =
        error_set(error, STATUS_INVALID, "%s:%u:%u: %s", source, line, column, message);
    if (error != NULL)
        tree_one_line(error->text);
    return status;
}

enum status tree_error(const struct tree_node *node, struct error *error, const char *format, ...)
{
    char message[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    char path[TREE_PATH_SIZE];
    tree_path(node, path);
    char *whole = g_strconcat(path, path[0] == '\0' ? "" : ": ", message, NULL);
    tree_error_at(error, node->source, node->line, node->column, whole);
    g_free(whole);
    return STATUS_INVALID;
}

// Which item of its parent a node is; the parent's count for a key.
static uint32_t index_in_parent(const struct tree_node *node)
{
    uint32_t index = 0;
    while (index < node->parent->count && node->parent->items[index] != node)
        index++;
    return index;
}

const char *tree_path(const struct tree_node *node, char path[TREE_PATH_SIZE])
{
    const struct tree_node *nodes[TREE_DEPTH_MAX + 1];
    uint32_t depth = 0;
    for (; node->parent != NULL; node = node->parent) {
        assert(depth <= TREE_DEPTH_MAX);
        nodes[depth++] = node;
    }
    GString *text = g_string_new(NULL);
    while (depth-- > 0) {
        const struct tree_node *parent = nodes[depth]->parent;
        uint32_t index = index_in_parent(nodes[depth]);
        if (index == parent->count)
            break;
        if (text->len > 0)
            g_string_append_c(text, '.');
        if (parent->kind == TREE_MAPPING)
            g_string_append(text, parent->keys[index]->text);
        else
            g_string_append_printf(text, "%u", index);
    }
    g_strlcpy(path, text->str, TREE_PATH_SIZE);
    g_string_free(text, TRUE);
    return path;
}

int tree_shown_length(const char *text, size_t size)
{
    const char *end;
    g_utf8_validate(text, (gssize)size, &end);
    return (int)(end - text);
}

const char *tree_shown(const struct tree_node *node, char shown[TREE_SHOWN_SIZE])
{
    if (node->kind == TREE_SEQUENCE)
        snprintf(shown, TREE_SHOWN_SIZE, "a list of %u", node->count);
    else if (node->kind == TREE_MAPPING)
        g_strlcpy(shown, "a mapping", TREE_SHOWN_SIZE);
    else if (!node->quoted && strcmp(node->text, "null") == 0)
        g_strlcpy(shown, "nothing", TREE_SHOWN_SIZE);
    else if (strlen(node->text) + 3 <= TREE_SHOWN_SIZE)
        snprintf(shown, TREE_SHOWN_SIZE, node->quoted ? "'%s'" : "%s", node->text);
    else
        snprintf(shown, TREE_SHOWN_SIZE, "'%.*s...'",
                 tree_shown_length(node->text, TREE_SHOWN_SIZE - 6), node->text);
    return shown;
}

// ---- Nodes ----

void tree_node_free(struct tree_node *node)
{
    if (node == NULL)
        return;
    for (uint32_t i = 0; i < node->count; i++) {
        tree_node_free(node->items[i]);
        if (node->keys != NULL)
            tree_node_free(node->keys[i]);
    }
    g_free(node->items);
    g_free(node->keys);
    g_free(node);
}

struct tree_node *tree_node_create(struct tree *tree, enum tree_kind kind, const char *source,
                                   uint32_t line, uint32_t column, const struct tree_node *parent)
{
    tree->node_count++;
    struct tree_node *node = g_new0(struct tree_node, 1);
    *node = (struct tree_node){
        .kind = kind,
        .source = source,
        .line = line,
        .column = column,
        .parent = parent,
    };
    return node;
}

// Room grows by doubling; `count` is what is in use.
static void append(struct tree_node ***nodes, uint32_t count, struct tree_node *node)
{
    if (count == 0 || (count & (count - 1)) == 0)
        *nodes = g_renew(struct tree_node *, *nodes, count == 0 ? 1 : 2 * count);
    (*nodes)[count] = node;
}

void tree_node_append(struct tree_node *node, struct tree_node *key, struct tree_node *value)
{
    if (key != NULL)
        append(&node->keys, node->count, key);
    append(&node->items, node->count, value);
    node->count++;
}

const char *tree_plain_text(const char *text)
{
    return text[0] == '\0' || strcmp(text, "~") == 0 ? "null" : text;
}

void tree_free(struct tree *tree)
{
    if (tree == NULL)
        return;
    tree_node_free(tree->root);
    g_string_chunk_free(tree->strings);
    g_free(tree);
}

const struct tree_node *tree_root(const struct tree *tree)
{
    return tree->root;
}

// ---- Looking up ----

bool tree_find_key(const struct tree_node *node, const char *key, uint32_t *index)
{
    if (node->kind != TREE_MAPPING)
        return false;
    for (uint32_t i = 0; i < node->count; i++) {
        if (strcmp(node->keys[i]->text, key) == 0) {
            *index = i;
            return true;
        }
    }
    return false;
}

bool tree_find_item(const struct tree_node *node, const char *step, uint32_t *index)
{
    guint64 number;
    if (node->kind != TREE_SEQUENCE || node->count == 0)
        return false;
    if (g_ascii_string_to_unsigned(step, 10, 0, node->count - 1, &number, NULL)) {
        *index = (uint32_t)number;
        return true;
    }
    for (uint32_t i = 0; i < node->count; i++) {
        const struct tree_node *name = tree_child(node->items[i], "name");
        if (name != NULL && name->kind == TREE_SCALAR && strcmp(name->text, step) == 0) {
            *index = i;
            return true;
        }
    }
    return false;
}

char *tree_resolve(const struct tree *tree, const char *path)
{
    const struct tree_node *node = tree->root;
    GString *resolved = g_string_new(NULL);
    char **steps = g_strsplit(path, ".", -1);
    for (char **step = steps; *step != NULL; step++) {
        uint32_t index = 0;
        const bool item = node != NULL && tree_find_item(node, *step, &index);
        g_string_append(resolved, step > steps ? "." : "");
        if (item)
            g_string_append_printf(resolved, "%u", index);
        else
            g_string_append(resolved, *step);
        if (node != NULL)
            node = item ? node->items[index] : tree_child(node, *step);
    }
    g_strfreev(steps);
    return g_string_free(resolved, FALSE);
}

const struct tree_node *tree_child(const struct tree_node *node, const char *key)
{
    uint32_t index;
    return tree_find_key(node, key, &index) ? node->items[index] : NULL;
}

const struct tree_node *tree_spot(const struct tree_node *mapping, const char *key)
{
    const struct tree_node *node = tree_child(mapping, key);
    return node != NULL ? node : mapping;
}
