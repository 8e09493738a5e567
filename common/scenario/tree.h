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

// The same of a text that stands at a node's place, where messages are to point at.
struct tree *tree_parse_at(const struct tree_node *place, const char *text, size_t size,
                           struct error *error);

// The same from a file. One that cannot be read is STATUS_INVALID too.
struct tree *tree_load(const char *path, struct error *error);

void tree_free(struct tree *tree);

const struct tree_node *tree_root(const struct tree *tree);

// How a value is laid over a mapping or a list that is there already.
enum tree_manner {
    TREE_REPLACE, // The value takes its place.
    TREE_MERGE    // A mapping changes it key by key; any other value takes its place.
};

// Lays a value over the tree: the one way in which anything is changed, be it by --set, by a case
// or by a sweep. `path` is a scalar with the path in it, "springs.front.length", and messages about
// the path point at it. A path consists of keys and, in lists, of names that the items have under
// `name`, or of indexes from 0. Mappings on the way that do not exist are made, items of lists are
// not. A key with a dot in it can only be set with its whole mapping. Merging, the keys of the
// mappings within `value` lead on in the same way.
//
// The value is copied and its nodes keep their places, so that messages about it point at where it
// was given; its texts are borrowed for the life of the tree. Pointers to nodes that were replaced
// are no longer valid. A refused path leaves the tree as it was; of a value that is merged the part
// before the refused one may be in place. Errors: STATUS_INVALID.
enum status tree_overlay(struct tree *tree, const struct tree_node *path,
                         const struct tree_node *value, enum tree_manner manner,
                         struct error *error) MUST_USE;

// Replaces or adds one value as given to --set: "springs.front.length=1.3". What follows the first
// '=' is YAML. Errors: STATUS_INVALID; the tree is as it was.
enum status tree_set(struct tree *tree, const char *assignment, struct error *error) MUST_USE;

// A copy without those keys of the root that are given in `without` (ends with NULL). It borrows
// the texts of `tree` and is freed before it.
struct tree *tree_copy(const struct tree *tree, const char *const *without);

// The path with indexes in place of the names of items, as far as the tree has what it leads to:
// two paths of one value give the same text. Released with g_free().
char *tree_resolve(const struct tree *tree, const char *path);

// The value of that key, or NULL when the mapping has none or the node is not a mapping.
const struct tree_node *tree_child(const struct tree_node *node, const char *key);

// The same, or the mapping itself when it has no such key: where to point at.
const struct tree_node *tree_spot(const struct tree_node *mapping, const char *key);

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
