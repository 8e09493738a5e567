// The files of the monitor's page, inside the program: nothing to install, nothing to lose, and the
// page fits the server that serves it.
#ifndef SOBOX_MONITOR_WEB_WEB_H
#define SOBOX_MONITOR_WEB_WEB_H

#include <stdbool.h>
#include <stddef.h>

struct web_file {
    const char *type; // Content-Type
    const void *bytes;
    size_t size;
};

// The file that browsers ask for under this path; false when there is none.
bool web_file(const char *path, struct web_file *file);

#endif
