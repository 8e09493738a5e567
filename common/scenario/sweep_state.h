// How a sweep is kept: for the files that read one and tell its cases (sweep*.c), and nobody else.
#ifndef SOBOX_COMMON_SCENARIO_SWEEP_STATE_H
#define SOBOX_COMMON_SCENARIO_SWEEP_STATE_H

#include "common/scenario/sweep.h"
#include "common/scenario/tree.h"

#include <glib.h>

// A value of a column and where it was given.
struct sweep_cell {
    const char *text;             // YAML on one line
    const struct tree_node *node; // the value; NULL: a scalar of that text
    const char *source;
    uint32_t line, column;
    bool plain; // short enough and simple enough to stand in a name
};

// A key that changes.
struct sweep_column {
    struct tree_node path; // a scalar, at the place where the path was given
    char *resolved;        // the same path for the same value: tree_resolve()
    const char *label;     // how names call it
};

// One digit of a case's number: columns that change together.
struct sweep_axis {
    uint32_t first_column;
    uint32_t column_count;
    uint32_t row_count;
    GArray *cells;     // of struct sweep_cell (row_count x column_count)
    GPtrArray *labels; // (row_count) names given in a table's column `case`; NULL without one
};

struct sweep {
    char name[SCENARIO_NAME_SIZE];
    struct tree *tree;     // of the sweep file
    struct tree *base;     // of the base scenario, with the overrides
    GPtrArray *trees;      // of values that stand in tables
    GStringChunk *strings; // texts that live as long as the sweep
    GArray *axes;          // of struct sweep_axis
    GArray *columns;       // of struct sweep_column
    GPtrArray *paths;      // of the columns, ends with NULL
    uint32_t case_count;
};

// Adds a cell to an axis: a value whose text is `text`. `node` may be NULL, see above.
void sweep_cell_add(struct sweep *sweep, struct sweep_axis *axis, const char *text,
                    const struct tree_node *node, const struct tree_node *place);

// Adds a cell that is YAML in `text`. Returns false with `error` filled when it is broken.
bool sweep_cell_add_text(struct sweep *sweep, struct sweep_axis *axis, const char *text,
                         const struct tree_node *place, struct error *error);

// Adds a cell that is a node of the sweep file. Returns false with `error` filled.
bool sweep_cell_add_node(struct sweep *sweep, struct sweep_axis *axis, const struct tree_node *node,
                         struct error *error);

// Reads the list of axes. Returns false with `error` filled (STATUS_INVALID).
bool sweep_axes_read(struct sweep *sweep, const struct tree_node *node, struct error *error);

// Adds the axis of the replicates: `count` seeds from `seed` on, given at `place`.
bool sweep_axes_add_seeds(struct sweep *sweep, const struct tree_node *place, uint64_t seed,
                          uint32_t count, struct error *error);

// Takes a path for a new column of the axis. Returns false with `error` filled.
bool sweep_axes_add_column(struct sweep *sweep, struct sweep_axis *axis, const char *path,
                           const struct tree_node *place, struct error *error);

// Reads the axis that is the table named by `node`. Returns false with `error` filled.
bool sweep_table_read(struct sweep *sweep, struct sweep_axis *axis, const struct tree_node *node,
                      struct error *error);

// A path in the sweep file, as seen from that file's folder. Released with g_free().
char *sweep_table_path(const struct tree_node *node);

// Chooses how names call the columns, and refuses two cases that would have the same name.
bool sweep_case_label(struct sweep *sweep, struct error *error);

// What a case has in a column.
const struct sweep_cell *sweep_case_cell(const struct sweep *sweep, uint32_t index,
                                         uint32_t column);

#endif
