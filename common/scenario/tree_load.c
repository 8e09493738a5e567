#include "common/scenario/tree_node.h"

#include <errno.h>
#include <glib.h>
#include <stdio.h>

// A file that cannot be read is invalid input like any other: whoever named it can name another.
static void unreadable(struct error *error, const char *path)
{
    char message[ERROR_TEXT_SIZE];
    snprintf(message, sizeof message, "expected a file that can be read: %s", g_strerror(errno));
    tree_error_at(error, path, 1, 1, message);
}

struct tree *tree_load(const char *path, struct error *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        unreadable(error, path);
        return NULL;
    }
    // One byte more than allowed tells a file that is too long, even one that never ends.
    char *text = g_malloc(TREE_TEXT_SIZE_MAX + 1);
    size_t size = fread(text, 1, TREE_TEXT_SIZE_MAX + 1, file);
    struct tree *tree = NULL;
    if (ferror(file))
        unreadable(error, path);
    else
        tree = tree_parse(path, text, size, error);
    g_free(text);
    fclose(file);
    return tree;
}
