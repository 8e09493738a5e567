// A sweep: one scenario in many cases, as read from a YAML file with the key `sweep`.
//
//     sweep: masses
//     base: sedan-two-springs.yaml      # relative to this file
//     axes:
//       - {path: barrier.edge_y, values: [-0.61, -0.455]}
//       - {path: firewall_distance, linspace: [0.2, 0.3, 5]}   # from, to, how many
//       - {path: search.samples, range: [100, 300, 100]}       # from, to, step (optional, 1)
//       - zip:                                                 # go together, one by one
//           - {path: vehicle.mass, values: [1500, 1800]}
//           - {path: vehicle.yaw_inertia, values: [2700, 3300]}
//       - csv: cases.csv            # columns headed by paths, and perhaps one headed `case`
//     replicates: 20                # seeds: the base's search.seed and those that follow it
//
// The cases are the grid over all axes: the first axis changes slowest, the replicates fastest. A
// path may be any key of the scenario, as for --set, whole lists and mappings too. A case is named
// by what makes it: "mass=1500,response=any,seed=3", each path by its last key where that tells it
// apart; values that are long or no scalars by their place in their axis ("force_x=#2").
//
// The base is read once, as a tree. A case is a copy of it with the values laid over, made when it
// is asked for, so a sweep of many cases costs little memory, and a case means exactly what its
// base means with the same --set options: the same digest.
#ifndef SOBOX_COMMON_SCENARIO_SWEEP_H
#define SOBOX_COMMON_SCENARIO_SWEEP_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    SWEEP_CASE_MAX = 100000,              // more are refused
    SWEEP_COLUMN_MAX = PROTOCOL_AXIS_MAX, // keys that change, over all axes
    SWEEP_CASE_NAME_SIZE = 256            // [bytes] with its NUL
};

struct sweep;

// Whether the file holds a sweep rather than a scenario: a mapping with the key `sweep`. A file
// that cannot be read holds none; reading it as a scenario says why.
bool sweep_detect(const char *path);

// Reads a sweep file, its base and its tables. `overrides` (override_count) are "key.path=value" as
// given to --set: they change the base and may not name a key that an axis changes. The caller
// releases the sweep with sweep_free(). The cases' scenarios are checked one by one by
// sweep_scenario(). Errors: STATUS_INVALID, "FILE:LINE:COLUMN: ...".
enum status sweep_read_file(struct sweep **sweep, const char *path, const char *const *overrides,
                            size_t override_count, struct error *error) MUST_USE;

// A sweep of one scenario over `count` seeds, its own and those that follow it, under the
// scenario's name: the same as a file with `replicates` and no axes. Errors: as above.
enum status sweep_of_seeds(struct sweep **sweep, const char *path, const char *const *overrides,
                           size_t override_count, uint32_t count, struct error *error) MUST_USE;

// NULL is fine.
void sweep_free(struct sweep *sweep);

const char *sweep_name(const struct sweep *sweep);

// 1 .. SWEEP_CASE_MAX.
uint32_t sweep_case_count(const struct sweep *sweep);

// The paths that change, in the order of the file, ending with NULL.
const char *const *sweep_columns(const struct sweep *sweep);
uint32_t sweep_column_count(const struct sweep *sweep);

// What a case has in a column: the YAML text of the value. Borrowed for the life of the sweep.
const char *sweep_value(const struct sweep *sweep, uint32_t index, uint32_t column);

// Writes the name of a case; returns `name`. No two cases share one.
const char *sweep_case_name(const struct sweep *sweep, uint32_t index,
                            char name[SWEEP_CASE_NAME_SIZE]);

// Reads the scenario of a case. On success the caller releases it; else it is left zeroed. Errors:
// STATUS_INVALID; the message points at the value in the sweep file, or the line of the base, and
// names the case.
enum status sweep_scenario(const struct sweep *sweep, uint32_t index, struct scenario *scenario,
                           struct error *error) MUST_USE;

#endif
