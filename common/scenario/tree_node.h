// How a tree is kept: for the files that parse, change and print one (tree*.c), and nobody else.
#ifndef SOBOX_COMMON_SCENARIO_TREE_NODE_H
#define SOBOX_COMMON_SCENARIO_TREE_NODE_H

#include "common/scenario/tree.h"

#include <glib.h>

struct tree {
    struct tree_node *root;
    GStringChunk *strings; // texts and sources of all nodes
    uint32_t node_count;   // made so far: nodes that were replaced still count
};

// Where a step of a path leads: item `index` of `node`, which is there or can be appended.
struct tree_slot {
    struct tree_node *node;
    uint32_t index;
};

// A node without items, at this place of `source`, which the tree keeps.
struct tree_node *tree_node_create(struct tree *tree, enum tree_kind kind, const char *source,
                                   uint32_t line, uint32_t column, const struct tree_node *parent);

// Releases a node and all below it. NULL is fine.
void tree_node_free(struct tree_node *node);

// A copy with all that is below. Texts are borrowed.
struct tree_node *tree_copy_node(const struct tree_node *node, const struct tree_node *parent);

// Adds an item, which the node owns from now on. `key` is NULL in sequences.
void tree_node_append(struct tree_node *node, struct tree_node *key, struct tree_node *value);

// Which entry of a mapping has this key. False when none has, or `node` is not a mapping.
bool tree_find_key(const struct tree_node *node, const char *key, uint32_t *index);

// Which item of a list `step` means: one that has it as `name`, or as index. False when none has,
// or `node` is not a list.
bool tree_find_item(const struct tree_node *node, const char *step, uint32_t *index);

// Parses `text`, which stands at `place`, into nodes that belong to `tree` and will hang at
// `depth`. NULL with `error` filled (STATUS_INVALID).
struct tree_node *tree_parse_below(struct tree *tree, const struct tree_node *place,
                                   const char *text, size_t size, uint32_t depth,
                                   struct error *error);

// A plain scalar's text as the tree keeps it: YAML has three spellings of nothing, and the
// canonical text needs one.
const char *tree_plain_text(const char *text);

// How many bytes of a long text to show, at most `size`, so that no character is cut.
int tree_shown_length(const char *text, size_t size);

// A message is one line: control characters from names and values become question marks.
void tree_one_line(char *text);

// Fills `error` with "SOURCE:LINE:COLUMN: " and the message. Returns STATUS_INVALID.
enum status tree_error_at(struct error *error, const char *source, uint32_t line, uint32_t column,
                          const char *message);

#endif
