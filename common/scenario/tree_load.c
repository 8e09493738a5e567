#include "common/base/whole_file.h"
#include "common/scenario/tree_node.h"

#include <glib.h>

struct tree *tree_load(const char *path, struct error *error)
{
    size_t size;
    char *text = whole_file_read(path, TREE_TEXT_SIZE_MAX, &size, error);
    struct tree *tree = text != NULL ? tree_parse(path, text, size, error) : NULL;
    g_free(text);
    return tree;
}
