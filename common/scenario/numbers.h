// Numbers of variables, as lists of the search section give them: one for all, one for each in
// order, or by name. A name is a spring (all its forces), SPRING.force_x or SPRING.force_y, or that
// of a single variable. What is given, and where it stands in the file, is kept apart from the
// value, so that a message names the place.
#ifndef SOBOX_COMMON_SCENARIO_NUMBERS_H
#define SOBOX_COMMON_SCENARIO_NUMBERS_H

#include "common/scenario/field.h"
#include "common/scenario/scenario.h"
#include "common/scenario/tree.h"

// Variables that stand side by side.
struct numbers_range {
    uint32_t first;
    uint32_t count;
};

struct numbers {
    double *values;                 // (variables) NAN where none is given
    const struct tree_node **nodes; // (variables) where each stands
};

// Finds the variables of a name. Returns false for a name that nothing has.
bool numbers_find(const struct scenario *scenario, const char *name, struct numbers_range *range);

// Says that `name` names no variable, and which do. Returns false.
bool numbers_unknown(const struct tree_node *name, const struct scenario *scenario,
                     struct error *error);

// The unit of the variables: those of the crash model are forces; of others it is not known, NULL.
const char *numbers_unit(const struct scenario *scenario);

// None is given yet. The caller releases them with numbers_fini().
void numbers_init(struct numbers *numbers, uint32_t count);
void numbers_fini(struct numbers *numbers);

// Reads the numbers of `node`, each within `range`. Returns false with `error` filled.
bool numbers_read(const struct tree_node *node, const struct scenario *scenario,
                  const struct field_range *range, const char *unit, struct numbers *numbers,
                  struct error *error);

// Gives the values away; what was not given becomes `otherwise`. The caller frees them.
double *numbers_take(struct numbers *numbers, uint32_t count, double otherwise);

// Reads numbers of which not all need be given. Returns NULL with `error` filled.
double *numbers_read_partial(const struct tree_node *node, const struct scenario *scenario,
                             const struct field_range *range, const char *unit, double otherwise,
                             struct error *error);

// Whether every given number lies in the design space; else `error` is filled.
bool numbers_inside_space(const struct numbers *numbers, const struct scenario *scenario,
                          struct error *error);

// Whether every free variable has a number, else `error` is filled; fixed ones get the one they
// have.
bool numbers_complete(struct numbers *numbers, const struct tree_node *node,
                      const struct scenario *scenario, struct error *error);

#endif
