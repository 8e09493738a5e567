// The command line, read alike by all programs: GLib's options, with --help, --version, one
// argument that is no option at most, and sentences about what is wrong. Wrong usage is
// STATUS_INVALID, exit status 2.
#ifndef SOBOX_COMMON_BASE_OPTIONS_H
#define SOBOX_COMMON_BASE_OPTIONS_H

#include "common/base/error.h"
#include "common/base/log.h"

#include <glib.h>
#include <stddef.h>

// Where a whole number of an option goes, and which are allowed.
struct options_number {
    const char *name; // "--threads"; its first letter may be its short name
    size_t offset;    // of a long in the program's options
    long min;
    long max;
};

// What a program takes. Strings and tables are borrowed for the call.
struct options_program {
    const char *argument; // what the one argument is called, "SCENARIO.yaml"; NULL: there is none
    const char *summary;  // in front of the options in --help
    const char *description;              // behind them
    const GOptionEntry *entries;          // ends with G_OPTION_ENTRY_NULL; without --version
    const char *version;                  // what --version says it prints; NULL: the version
    const struct options_number *numbers; // of the entries that have options_number(), then {0}
    void *options;                        // the program's, in which the numbers are
};

// What there is on every command line.
struct options_common {
    char *argument;   // the one that is no option, for the caller to free; NULL: none was given
    gboolean version; // --version: print it, and nothing else
};

// Reads the command line into what the entries point at. --help prints and ends the program.
// Errors: STATUS_INVALID.
enum status options_read(const struct options_program *program, int argc, char **argv,
                         struct options_common *common, struct error *error) MUST_USE;

// For entries with G_OPTION_ARG_CALLBACK: a whole number within its range.
gboolean options_number(const char *name, const char *value, gpointer program, GError **error);

// How much is told with --quiet, --verbose, or neither.
enum log_level options_log_level(gboolean quiet, gboolean verbose);

#endif
