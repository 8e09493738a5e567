// From YAML to a checked struct scenario. Nothing is guessed: an unknown key, a wrong type, a value
// out of range is an error that names file, line, column, path, and what would be right.
#ifndef SOBOX_COMMON_SCENARIO_SCENARIO_READ_H
#define SOBOX_COMMON_SCENARIO_SCENARIO_READ_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"
#include "common/scenario/tree.h"

// Reads a scenario file. `overrides` (override_count) are "key.path=value" as given to --set: a
// path of keys and names or indexes of list items ("springs.front.length=1.3"), and a YAML value;
// they may add optional keys. On success the scenario is filled and the caller releases it; else it
// is left zeroed. What is unlikely is among the scenario's findings; what no crash can mean is an
// error as any other (plausibility.h). Errors: STATUS_INVALID, also for a file that cannot be read:
// to the user a wrong name is one more wrong input.
enum status scenario_read_file(struct scenario *scenario, const char *path,
                               const char *const *overrides, size_t override_count,
                               struct error *error) MUST_USE;

// The same from memory; `source` stands for the file in messages. The text is as untrusted as any
// file: it may come from the network. What is not plausible is among the findings and no error
// here: whoever wrote the text has been told, and a run of an older version that let it pass can be
// shown.
enum status scenario_read_text(struct scenario *scenario, const char *source, const char *text,
                               size_t text_size, const char *const *overrides,
                               size_t override_count, struct error *error) MUST_USE;

// The same from a tree, which stays the caller's.
enum status scenario_read_tree(struct scenario *scenario, const struct tree *tree,
                               struct error *error) MUST_USE;

#endif
