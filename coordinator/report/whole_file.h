// Files that are whole or absent: written beside their place, then renamed into it.
#ifndef SOBOX_COORDINATOR_REPORT_WHOLE_FILE_H
#define SOBOX_COORDINATOR_REPORT_WHOLE_FILE_H

#include "common/base/error.h"

#include <stddef.h>

// Writes `size` bytes as the file `path`, replacing one that is there. Errors: STATUS_IO.
enum status whole_file_write(const char *path, const void *bytes, size_t size,
                             struct error *error) MUST_USE;

#endif
