// Evaluates a table of designs, however long, on the workers of a wire, and writes what came of
// them in the table's order.
//
//     table --> piece --> read by a thread --> batches at workers --> written by a thread --> file
//               |<------------------ at most EVALUATE_PIECES_MAX at once ----------------->|
//
// Pieces go their way side by side; only the file is in order. So neither a slow worker nor a lost
// message stops the others, and memory is bounded by the pieces under way. What a design gives
// depends on nothing but the design: the file is the same for any workers, threads and losses.
#ifndef SOBOX_COORDINATOR_RUNTIME_EVALUATE_H
#define SOBOX_COORDINATOR_RUNTIME_EVALUATE_H

#include "coordinator/evaluation/evaluation.h"
#include "coordinator/evaluation/source.h"
#include "coordinator/runtime/coordinator.h"

enum {
    EVALUATE_PIECES_MAX = 16
}; // of a MiB of table each; a few MiB each with all that comes of it

// A table on its way through the workers.
struct evaluate {
    struct evaluation *evaluation; // begun or taken up again
    struct source *source;
    struct designs_layout layout; // what its header says
};

// Opens the table that the evaluation names, reads its header and, of an evaluation taken up again,
// all that was evaluated before, which must not have changed. Errors: STATUS_INVALID (with
// FILE:LINE:COLUMN), STATUS_IO.
enum status evaluate_open(struct evaluate *evaluate, struct evaluation *evaluation,
                          struct error *error) MUST_USE;
void evaluate_close(struct evaluate *evaluate);

// Works until all is evaluated, a signal ends it, or it fails: at a row that is none, all pieces
// before its own are written. The evaluation's state is written before it returns. As
// coordinator_run() it has the wire and the main loop for itself. Errors: STATUS_INVALID (a row,
// with FILE:LINE:COLUMN; designs too large for a message), STATUS_INTERRUPTED, STATUS_IO,
// STATUS_NETWORK, STATUS_FAILED.
enum status evaluate_run(struct evaluate *evaluate, struct wire *wire,
                         const struct coordinator_settings *settings, struct error *error) MUST_USE;

#endif
