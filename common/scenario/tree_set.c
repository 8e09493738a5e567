#include "common/scenario/tree_node.h"

#include <glib.h>
#include <string.h>

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
    if (!g_utf8_validate(assignment, -1, NULL))
        return error_set(error, STATUS_INVALID, "--set: expected UTF-8");
    struct tree_node path = {.source = name_assignment(tree, assignment), .line = 1, .column = 1};
    const char *equals = strchr(assignment, '=');
    if (equals == NULL || equals == assignment || equals[1] == '\0')
        return tree_error(&path, error, "expected KEY.PATH=VALUE");
    struct tree_node *value =
        tree_parse_below(tree, &path, equals + 1, strlen(equals + 1), 1, error);
    if (value == NULL)
        return STATUS_INVALID;
    path.text = g_string_chunk_insert_len(tree->strings, assignment, equals - assignment);
    enum status status = tree_overlay(tree, &path, value, TREE_REPLACE, error);
    tree_node_free(value);
    return status;
}
