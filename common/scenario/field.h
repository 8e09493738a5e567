// Mappings as tables: a reader lists the fields of a struct with their keys, types and ranges, and
// field_read() fills the struct from a node of the tree, refusing unknown keys, missing keys, wrong
// types and values out of range with a message that points at the spot.
#ifndef SOBOX_COMMON_SCENARIO_FIELD_H
#define SOBOX_COMMON_SCENARIO_FIELD_H

#include "common/scenario/tree.h"

#include <math.h>

// Greater numbers are refused: no quantity of a crash comes near, and sums of squares stay finite.
#define FIELD_NUMBER_MAX 1e15

// The greatest whole number: greater ones are not exact in every reader of JSON.
#define FIELD_COUNT_MAX 9007199254740991.0

enum field_kind {
    FIELD_NUMBER,      // double
    FIELD_NUMBER_PAIR, // double[2], a list of two
    FIELD_COUNT,       // uint32_t
    FIELD_COUNT_64,    // uint64_t, up to FIELD_COUNT_MAX
    FIELD_WORD,        // int-sized enum: the index in `words`
    FIELD_NAME,        // char[SCENARIO_NAME_SIZE]: printable, without '/', not starting with '.'
    FIELD_IDENTIFIER,  // char[SCENARIO_NAME_SIZE]: letters, digits, '_' and '-'
    FIELD_NODE,        // const struct tree_node *: read by other means, or NULL when absent
};

// Which numbers are allowed. Bounds may be infinite.
struct field_range {
    double min;
    double max;
    bool open; // the bounds themselves are not allowed
};

// Initializers of a range.
#define FIELD_ANY                  \
    {                              \
        -INFINITY, INFINITY, false \
    }
#define FIELD_POSITIVE      \
    {                       \
        0.0, INFINITY, true \
    }
#define FIELD_NOT_NEGATIVE   \
    {                        \
        0.0, INFINITY, false \
    }
#define FIELD_FROM_TO(from, to) \
    {                           \
        from, to, false         \
    }
#define FIELD_BETWEEN(low, high) \
    {                            \
        low, high, true          \
    }

struct field {
    const char *key;
    enum field_kind kind;
    bool optional;            // left as it is when the key is absent
    size_t offset;            // of the value in the struct
    struct field_range range; // of numbers and counts
    const char *unit;         // "kg"; NULL where there is none
    const char *const *words; // of a FIELD_WORD, in the order of the enum, ends with NULL
    const char *expected;     // what a missing key should hold; NULL: told by kind and range
};

// Reads a mapping into the struct at `target`. Unknown keys are reported before missing ones, both
// before values. Returns false with `error` filled (STATUS_INVALID).
bool field_read(const struct tree_node *mapping, const struct field *fields, size_t field_count,
                void *target, struct error *error);

// Reads one value as field_read() would, from a node that may be an item of a list.
bool field_read_value(const struct tree_node *node, const struct field *field, void *value,
                      struct error *error);

// Reads a number for all `count` places or a list of `count` numbers. `unit` may be NULL.
bool field_read_numbers(const struct tree_node *node, const struct field_range *range,
                        const char *unit, double *numbers, uint32_t count, struct error *error);

// Says that `key`, which is none of the `known` ones (ends with NULL), is unknown, and which was
// meant when one is close or else which there are. Returns false.
bool field_unknown_key(const struct tree_node *key, const char *what, const char *const *known,
                       struct error *error);

#endif
