// The folder of an evaluation: outcomes.csv, the outcomes of a table of designs in its order, and
// evaluation.json, which says what is evaluated and how far it has come, so that it can be taken up
// again. It is read anew up to that place then, and must be the same up to there; behind it the
// table may have been mended.
//
// evaluation.json: {name, version, state, designs (the path), outcomes [names], rows, good,
// non_finite, elapsed_s, bytes_read, bytes_written, digest (of what was read), scenario (its
// text)}; state is running, interrupted, failed or done.
#ifndef SOBOX_COORDINATOR_EVALUATION_EVALUATION_H
#define SOBOX_COORDINATOR_EVALUATION_EVALUATION_H

#include "common/numeric/digest.h"
#include "common/protocol/protocol.h"
#include "coordinator/evaluation/outcomes.h"
#include "coordinator/journal/journal_lock.h"

#include <stdbool.h>
#include <stdint.h>

struct evaluation {
    char *directory;
    bool folder_made; // by its creation
    struct journal_lock lock;
    int file; // outcomes.csv, written at its end; -1: not open

    char *designs;            // path of the table as given; "-": standard input
    struct scenario scenario; // as it was begun with
    struct outcomes_layout outcomes;
    enum run_state state;
    uint64_t rows; // designs whose outcomes are written
    struct outcomes_sums sums;
    uint64_t bytes_read;    // of the table, up to the end of the last of them
    uint64_t bytes_written; // of outcomes.csv
    struct digest digest;   // chain over the pieces read: evaluation_digest()
    int64_t elapsed_ns;     // of earlier sessions
    int64_t started_ns;     // monotonic, of this session
    uint64_t noted_rows;    // that evaluation.json tells of
};

// What a piece of the table has become.
struct evaluation_piece {
    const char *text; // (size) rows of outcomes
    size_t size;
    uint64_t rows;
    struct outcomes_sums sums;
    uint64_t end;         // bytes of the table up to the end of the piece
    struct digest digest; // of the piece
};

// Begins one in the folder `directory`, absent or empty; NULL picks runs/NAME-outcomes. `names` are
// the outcomes wanted, separated by commas; NULL: all. Takes the scenario over, which is left
// zeroed. Errors: STATUS_INVALID (the folder; no such outcome), STATUS_IO. Nothing is left behind
// then.
enum status evaluation_create(struct evaluation *evaluation, const char *directory,
                              struct scenario *scenario, const char *designs, const char *names,
                              int64_t now_ns, struct error *error) MUST_USE;

// Whether the folder is one of an evaluation.
bool evaluation_present(const char *directory);

// Takes one up again. What outcomes.csv holds beyond what evaluation.json tells of is cut off.
// Errors: STATUS_INVALID (no evaluation, or a damaged one), STATUS_IO, STATUS_REFUSED (it is done;
// it is being written; another version began it).
enum status evaluation_resume(struct evaluation *evaluation, const char *directory, int64_t now_ns,
                              struct error *error) MUST_USE;

// Writes the next piece's rows. Errors: STATUS_IO.
enum status evaluation_append(struct evaluation *evaluation, const struct evaluation_piece *piece,
                              struct error *error) MUST_USE;

// Notes in evaluation.json how far it has come, if further than noted: what was written since is
// done again after a kill. Errors: STATUS_IO.
enum status evaluation_note(struct evaluation *evaluation, int64_t now_ns,
                            struct error *error) MUST_USE;

// Writes the state in which it ends for now. Errors: STATUS_IO.
enum status evaluation_end(struct evaluation *evaluation, enum run_state state, int64_t now_ns,
                           struct error *error) MUST_USE;

// The digest of all pieces up to one, from that of those before it.
struct digest evaluation_digest(const struct digest *before, const struct digest *piece);

// Removes a folder that nothing was written into but its beginning.
void evaluation_abandon(struct evaluation *evaluation);

// Releases everything and gives the folder free. A zeroed struct is not fine: `file` is -1 there.
void evaluation_fini(struct evaluation *evaluation);

#endif
