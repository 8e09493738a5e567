// What sobox-coordinator is asked on its command line: each option, and what goes with what.
#ifndef SOBOX_COORDINATOR_RUNTIME_COMMAND_LINE_H
#define SOBOX_COORDINATOR_RUNTIME_COMMAND_LINE_H

#include "common/base/error.h"
#include "coordinator/runtime/run.h"

#include <glib.h>

enum { COMMAND_LINE_NO_MTU = -1 }; // none was given

struct command_line {
    char *scenario;
    char *out;
    char *resume;
    char *url;
    char *key_file;
    char *new_key;
    char **set; // NULL-terminated
    char *seed;
    char *only;
    char *shard;
    char *evaluate;
    char *outcomes;
    char *certify;
    char *round;
    struct run_choice choice; // from only, shard, stop_after and keep_going
    int stop_after;
    gboolean keep_going;
    gboolean dry_run;
    int seeds; // 0: not asked for
    int workers;
    int threads;
    int mtu;
    gboolean quiet;
    gboolean verbose;
    gboolean version;
};

// Reads the command line; prints the help and ends the program where that is asked for. The caller
// releases it in any case. Errors: STATUS_INVALID (an option that is unknown, out of its range, or
// does not go with another; no scenario).
enum status command_line_parse(struct command_line *options, int argc, char **argv,
                               struct error *error) MUST_USE;

// Releases what it owns. A zeroed struct is fine.
void command_line_fini(struct command_line *options);

#endif
