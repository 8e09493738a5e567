// The folder that a run writes into: one that is there and empty, or a new one.
#ifndef SOBOX_COORDINATOR_JOURNAL_RUN_FOLDER_H
#define SOBOX_COORDINATOR_JOURNAL_RUN_FOLDER_H

#include "common/base/error.h"

#include <stdbool.h>

// Makes `path`, or where it is NULL the first of runs/NAME, runs/NAME-2, ... that does not exist.
// Returns the folder's path in `folder`, for the caller to free, and in `made` whether it was not
// there before. Errors: STATUS_INVALID (it is not empty, or cannot be made or written into).
enum status run_folder_make(const char *path, const char *name, char **folder, bool *made,
                            struct error *error) MUST_USE;

// Takes back a folder that was made and is empty, and `runs` with it where it was picked.
void run_folder_remove(const char *folder);

#endif
