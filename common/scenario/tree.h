// YAML as a small tree in which every node remembers where it stands, so that whoever finds it
// wrong can point at it. The text is untrusted: size, depth, number of nodes and keys are bounded,
// and whatever could surprise a reader is refused instead of interpreted: aliases and anchors,
// tags, directives, a second document, a key given twice, invalid UTF-8. What a scalar means is
// decided by the reader that asks for a number or a word, never by its looks.
#ifndef SOBOX_COMMON_SCENARIO_TREE_H
#define SOBOX_COMMON_SCENARIO_TREE_H

#include "common/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    TREE_TEXT_SIZE_MAX = 1 << 20, // [bytes] of YAML
    TREE_NODE_MAX = 1 << 17,      // scalars, sequences and mappings together
    TREE_DEPTH_MAX = 32,          // the root has depth 1
    TREE_KEY_MAX = 256,           // of one mapping
    TREE_PATH_SIZE = 512,         // [bytes] of a node's path with its NUL; longer ones are cut
    TREE_SHOWN_SIZE = 64,         // [bytes] of a value shown in a message
};

enum tree_kind { TREE_SCALAR, TREE_SEQUENCE, TREE_MAPPING };

// All of it belongs to the tree and is read-only to others.
struct tree_node {
    enum tree_kind kind;
    const char *source;             // the file, or "--set KEY=VALUE"
    uint32_t line;                  // 1 is the first
    uint32_t column;                // 1 is the first character
    const struct tree_node *parent; // NULL at the root
    const char *text;         // of a scalar, UTF-8 without NUL inside; "null" where it is empty
    bool quoted;              // the scalar stood in quotes or was a block: never a number
    uint32_t count;           // items of a sequence, entries of a mapping
    struct tree_node **items; // (count) values in file order
    struct tree_node **keys;  // (count) scalars; of a mapping only
};

struct tree;

// Builds the tree of one YAML document. `source` names the text in messages and is copied. Returns
// NULL and fills `error` (STATUS_INVALID) when the text is not acceptable. The caller frees it.
struct tree *tree_parse(const char *source, const char *text, size_t size, struct error *error);

// The same from a file. One that cannot be read is STATUS_INVALID too.
struct tree *tree_load(const char *path, struct error *error);

void tree_free(struct tree *tree);

const struct tree_node *tree_root(const struct tree *tree);

// Replaces or adds one value: "springs.0.length=1.3". The path consists of keys and, in sequences,
// of indexes from 0; what follows the first '=' is YAML. Mappings on the way that do not exist are
// made, items of sequences are not. A key with a dot in it can only be set with its whole mapping.
// Pointers to nodes that were replaced are no longer valid.
// Errors: STATUS_INVALID.
enum status tree_set(struct tree *tree, const char *assignment, struct error *error) MUST_USE;

// The value of that key, or NULL when the mapping has none or the node is not a mapping.
const struct tree_node *tree_child(const struct tree_node *node, const char *key);

// The same, or the mapping itself when it has no such key: where to point at.
const struct tree_node *tree_spot(const struct tree_node *mapping, const char *key);

// A copy of the tree with the mapping `overrides`, a node of it, laid over its root; keys given in
// `without` (ends with NULL) are left out of the copy. The first level's keys are paths as those of
// tree_set(): "vehicle.mass", "springs.0.position". A mapping is laid over a mapping key by key,
// and over a list item by item: its keys are indexes, or names that the items have under `name`.
// Anything else replaces what is there. Nodes keep their lines and columns, so messages point at
// the override. The copy borrows from `tree` and is freed before it. Returns NULL with `error`
// filled (STATUS_INVALID).
struct tree *tree_overlay(const struct tree *tree, const struct tree_node *overrides,
                          const char *const *without, struct error *error);

// The canonical text: block style, sequences of scalars on one line, comments gone, keys in file
// order. Parsing it gives the same tree and the same text again. With its NUL, which `size` does
// not count; released with g_free().
char *tree_emit(const struct tree *tree, size_t *size);

// Writes the node's path from the root, "springs.0.force_x"; empty at the root. A key
// has the path of its mapping. Returns `path`.
const char *tree_path(const struct tree_node *node, char path[TREE_PATH_SIZE]);

// Writes what a node is for a message: its text, cut when long, or "a list of 3", "a mapping",
// "nothing". Returns `shown`.
const char *tree_shown(const struct tree_node *node, char shown[TREE_SHOWN_SIZE]);

// Fills `error` with "SOURCE:LINE:COLUMN: PATH: " and the message, on one line whatever the texts
// in it contain. Returns STATUS_INVALID.
enum status tree_error(const struct tree_node *node, struct error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
