// The run's truth: run.db, an SQLite database in the run folder, written before anything is acted
// on. It holds the scenario as it was read, one row a search and one row a finished step with the
// step's verdicts, so that a killed run is resumed by replaying them; it survives kill -9 and a
// full disk, and can be read while the run goes on.
//
//   meta        schema version
//   run         one row: id, name, program version, state, how many searches, times
//   axis        of a sweep: number, path of the key that changes
//   search      index, name of its case, scenario text and digest, seed, state and result
//   axis_value  (search, axis), what the case has there
//   step        (search, step), phase, samples, good, growth, log_volume, bounds, packed verdicts,
//               how they were sampled
//
// Schema 1 had no axes, schema 2 no samplings. Files of both are still read and continued.
#ifndef SOBOX_COORDINATOR_JOURNAL_JOURNAL_H
#define SOBOX_COORDINATOR_JOURNAL_JOURNAL_H

#include "common/base/error.h"
#include "common/numeric/box.h"
#include "common/numeric/digest.h"
#include "common/numeric/verdict.h"
#include "common/protocol/protocol.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    JOURNAL_SCHEMA = 4,          // older files are read and continued as they are:
    JOURNAL_SCHEMA_AXES = 2,     // from this one on a sweep has axes,
    JOURNAL_SCHEMA_SAMPLING = 3, // from this one on a step says how it was sampled
    JOURNAL_SCHEMA_WORST = 4,    // from this one on a result has its worst design
    JOURNAL_AXIS_MAX = PROTOCOL_AXIS_MAX,
    JOURNAL_NAME_SIZE = 256, // [bytes] of a case's name with its NUL
};

enum journal_mode {
    JOURNAL_READ,   // any number of readers, also beside a running coordinator
    JOURNAL_RESUME, // the one writer
};

struct journal_run {
    char name[64];
    char version[32]; // of sobox
    enum run_state state;
    uint64_t id; // the run's random number on the network
    uint32_t search_count;
    int64_t started_ns; // calendar
    int64_t elapsed_ns; // running time over all its sessions
};

// One search. On writing, text is borrowed; on reading it is owned by the struct.
struct journal_search {
    uint32_t index;
    char name[JOURNAL_NAME_SIZE]; // of its case in a sweep; "" otherwise
    const char *const *values;    // (the run's axes) of its case; borrowed, not read back
    char *text;                   // canonical YAML of its scenario
    size_t text_size;
    struct digest scenario;
    uint64_t seed;
    // The result: meaningful once `finished`.
    bool finished;
    char status[32]; // protocol_status_name()
    struct box box;  // owned; count 0 until finished
    double log_volume;
    uint64_t purity_samples, purity_bad;
    double purity_estimate, purity_lower95;
    uint64_t evaluations, non_finite;
    uint32_t steps;
    char blocking_constraint[160]; // "" unless no good design was found
    int64_t wall_ns;
    struct digest digest;
    struct box worst; // the worst design of the box that was found, lower equal to upper; owned;
                      // count 0: none is known
    uint8_t *holders; // (2 x variables) what holds each bound, and
    double *gains;    // (constraints) what relaxing each is worth (search.h); owned, or both NULL
    uint32_t gain_count;
};

struct journal_step {
    uint32_t search;
    uint32_t step;
    char phase[16]; // protocol_phase_name()
    uint32_t samples;
    uint32_t good;
    double growth;
    double log_volume;
    const struct box *box; // that was sampled, all bounds finite; borrowed
    enum verdict_detail detail;
    const struct verdict *verdicts; // (samples) borrowed
    enum sampling_method sampling;  // how they were drawn,
    bool sampling_known;            // which an old file does not say; not looked at on writing
};

struct journal;

// Creates run.db in the existing folder `directory` with the run and its searches in one
// transaction. Errors: STATUS_IO (folder not writable, file exists, disk full).
enum status journal_create(struct journal **journal, const char *directory,
                           const struct journal_run *run, const struct journal_search *searches,
                           struct error *error) MUST_USE;

// Gives the next search of a run, or ends them with `more` false. What `search` points to is
// borrowed until the next call.
typedef enum status journal_source(void *user, struct journal_search *search, bool *more,
                                   struct error *error);

// The same for any number of searches, which `next` gives one after the other, and `axes`
// (axis_count) of a sweep. run->search_count is not looked at. Another status than STATUS_OK from
// `next` ends the creation and is returned; nothing is left behind.
enum status journal_create_from(struct journal **journal, const char *directory,
                                const struct journal_run *run, const char *const *axes,
                                uint32_t axis_count, journal_source *next, void *user,
                                struct error *error) MUST_USE;

// Opens the run.db of a run folder. JOURNAL_RESUME takes the folder for this process alone, as
// journal_create() does; JOURNAL_READ shows the run as it is at this moment, whatever comes later.
// Errors: STATUS_IO (none there, not a database, disk), STATUS_REFUSED (another schema version;
// another coordinator is writing it).
enum status journal_open(struct journal **journal, const char *directory, enum journal_mode mode,
                         struct error *error) MUST_USE;

// Whether the run was written before searches could promise more than points.
bool journal_is_of_points(const struct journal *journal);

// Closes it. NULL is fine.
void journal_close(struct journal *journal);

// Writes a finished step. When it returns STATUS_OK the step survives kill -9 of this process.
// Errors: STATUS_IO (disk full or broken; the file was removed or moved away).
enum status journal_append(struct journal *journal, const struct journal_step *step,
                           struct error *error) MUST_USE;

// Writes the result of a search (everything but text, scenario and seed).
enum status journal_finish_search(struct journal *journal, const struct journal_search *search,
                                  struct error *error) MUST_USE;

// Says that a search could not be carried out; it stays unfinished.
enum status journal_fail_search(struct journal *journal, uint32_t index,
                                struct error *error) MUST_USE;

// What is written between the two is written as one, and survives kill -9 when journal_commit()
// returns STATUS_OK: thousands of small steps a second cost one write each few. After a failure in
// between, too, journal_commit() is to be called.
enum status journal_begin(struct journal *journal, struct error *error) MUST_USE;
enum status journal_commit(struct journal *journal, struct error *error) MUST_USE;

// Writes how the run stands.
enum status journal_state(struct journal *journal, enum run_state state, int64_t elapsed_ns,
                          struct error *error) MUST_USE;

// Readers. journal_read_search() fills a struct to be released with journal_search_fini().
enum status journal_read_run(struct journal *journal, struct journal_run *run,
                             struct error *error) MUST_USE;
enum status journal_read_search(struct journal *journal, uint32_t index,
                                struct journal_search *search, struct error *error) MUST_USE;
void journal_search_fini(struct journal_search *search);

// The paths of a sweep's axes, ending with NULL; none but the NULL when the run is no sweep. The
// caller frees them with g_strfreev().
enum status journal_read_axes(struct journal *journal, char ***axes, struct error *error) MUST_USE;

// What a case has on each axis, ending with NULL, likewise.
enum status journal_read_values(struct journal *journal, uint32_t index, char ***values,
                                struct error *error) MUST_USE;

// How a search stands, without its texts and numbers.
struct journal_standing {
    uint32_t index;
    char name[JOURNAL_NAME_SIZE];
    bool finished;
    char status[32];
};

// Calls `visit` for each search of the run in order, as journal_read_steps() does for steps.
typedef enum status journal_stand_visitor(void *user, const struct journal_standing *standing,
                                          struct error *error);
enum status journal_read_standings(struct journal *journal, journal_stand_visitor *visit,
                                   void *user, struct error *error) MUST_USE;

// Calls `visit` for each finished step of a search in order; what the step points to is borrowed
// until it returns. Another status than STATUS_OK from `visit` ends the reading and is returned.
// The journal knows no scenario: whoever replays a step checks first that its number, its samples
// and its box are those the search asked for and its constraints are below the scenario's count.
typedef enum status journal_visitor(void *user, const struct journal_step *step,
                                    struct error *error);
enum status journal_read_steps(struct journal *journal, uint32_t search, journal_visitor *visit,
                               void *user, struct error *error) MUST_USE;

#endif
