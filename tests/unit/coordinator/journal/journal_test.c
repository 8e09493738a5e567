#include "coordinator/journal/journal_inside.h"

#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <glib/gstdio.h>
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

// ---- a folder for each test ----

static int folder_make(void **state)
{
    char *folder = g_dir_make_tmp("sobox-journal-XXXXXX", NULL);
    *state = folder;
    return folder != NULL ? 0 : -1;
}

static void folder_empty(const char *folder)
{
    GDir *dir = g_dir_open(folder, 0, NULL);
    for (const char *name; dir != NULL && (name = g_dir_read_name(dir)) != NULL;) {
        char *path = g_build_filename(folder, name, NULL);
        unlink(path);
        g_free(path);
    }
    g_dir_close(dir);
}

static int folder_remove(void **state)
{
    folder_empty(*state);
    rmdir(*state);
    g_free(*state);
    return 0;
}

// ---- what the tests write ----

static char scenario_text[] = "name: test\nvehicle:\n  mass: 1650\n";

static struct journal_run run_of(uint32_t search_count)
{
    return (struct journal_run){.name = "sedan",
                                .version = "1.2.3",
                                .id = UINT64_C(0xfedcba9876543210),
                                .search_count = search_count,
                                .started_ns = INT64_C(1700000000123456789)};
}

static struct journal_search search_of(uint32_t index)
{
    struct journal_search search = {.index = index,
                                    .text = scenario_text,
                                    .text_size = sizeof scenario_text - 1,
                                    .scenario = digest_of("scenario", 8),
                                    .seed = UINT64_MAX - index};
    g_snprintf(search.name, sizeof search.name, "case %" PRIu32, index);
    return search;
}

static struct journal *create(const char *folder, uint32_t search_count)
{
    struct journal_run run = run_of(search_count);
    struct journal_search searches[4];
    for (uint32_t i = 0; i < search_count; i++)
        searches[i] = search_of(i);
    struct journal *journal;
    struct error error = {0};
    enum status status = journal_create(&journal, folder, &run, searches, &error);
    if (status != STATUS_OK)
        print_error("%s\n", error.text);
    assert_int_equal(status, STATUS_OK);
    return journal;
}

// A step whose numbers follow from its place, so that a reader can tell whether it is whole.
enum { SAMPLES = 200, VARIABLES = 18 };

struct sample_step {
    struct journal_step step;
    struct box box;
    struct verdict verdicts[SAMPLES];
};

static void sample_step_init(struct sample_step *sample, uint32_t search, uint32_t number)
{
    *sample = (struct sample_step){0};
    box_init(&sample->box, VARIABLES);
    for (uint32_t i = 0; i < VARIABLES; i++) {
        sample->box.lower[i] = number + i / 3.0;
        sample->box.upper[i] = number + i + 1.0 / (number + 1);
    }
    for (uint32_t i = 0; i < SAMPLES; i++)
        if ((i + number) % 4 == 0)
            sample->verdicts[i] = (struct verdict){.violation = (uint16_t)(1 + 300 * i),
                                                   .constraint = (uint8_t)(i % 3)};
    sample->step = (struct journal_step){.search = search,
                                         .step = number,
                                         .phase = "explore",
                                         .samples = SAMPLES,
                                         .good = verdict_good_count(sample->verdicts, SAMPLES),
                                         .growth = 0.1 * number,
                                         .log_volume = -1.0 / 3 * number,
                                         .box = &sample->box,
                                         .sampling = (enum sampling_method)(number % 3),
                                         .verdicts = sample->verdicts};
}

static enum status append(struct journal *journal, uint32_t search, uint32_t number,
                          struct error *error)
{
    struct sample_step sample;
    sample_step_init(&sample, search, number);
    enum status status = journal_append(journal, &sample.step, error);
    box_fini(&sample.box);
    return status;
}

static void append_ok(struct journal *journal, uint32_t search, uint32_t number)
{
    assert_int_equal(append(journal, search, number, NULL), STATUS_OK);
}

// ---- what the tests read ----

static bool same_bits(const double *a, const double *b, size_t count)
{
    return memcmp(a, b, count * sizeof *a) == 0;
}

struct reading {
    uint32_t search;
    uint32_t count; // steps seen, which are numbered from 0
    bool old;       // of a file that does not say how a step was sampled
};

static enum status check_sample_step(void *user, const struct journal_step *step,
                                     struct error *error)
{
    (void)error;
    struct reading *reading = user;
    struct sample_step sample;
    sample_step_init(&sample, reading->search, reading->count++);
    assert_int_equal(step->search, sample.step.search);
    assert_int_equal(step->step, sample.step.step);
    assert_string_equal(step->phase, sample.step.phase);
    assert_int_equal(step->samples, SAMPLES);
    assert_int_equal(step->good, sample.step.good);
    assert_true(same_bits(&step->growth, &sample.step.growth, 1));
    assert_true(same_bits(&step->log_volume, &sample.step.log_volume, 1));
    assert_true(box_equal(step->box, &sample.box));
    for (uint32_t i = 0; i < SAMPLES; i++) {
        assert_int_equal(step->verdicts[i].violation, sample.verdicts[i].violation);
        assert_int_equal(step->verdicts[i].constraint, sample.verdicts[i].constraint);
    }
    assert_int_equal(step->sampling_known, !reading->old);
    if (!reading->old)
        assert_int_equal(step->sampling, sample.step.sampling);
    box_fini(&sample.box);
    return STATUS_OK;
}

// Opens the folder's journal, checks every step of a search and returns how many there are.
static uint32_t count_steps(const char *folder, uint32_t search)
{
    struct journal *journal;
    struct error error = {0};
    enum status status = journal_open(&journal, folder, JOURNAL_READ, &error);
    if (status != STATUS_OK)
        print_error("%s\n", error.text);
    assert_int_equal(status, STATUS_OK);
    struct reading reading = {.search = search};
    assert_int_equal(journal_read_steps(journal, search, check_sample_step, &reading, NULL),
                     STATUS_OK);
    journal_close(journal);
    return reading.count;
}

static enum status pass_over(void *user, const struct journal_step *step, struct error *error)
{
    (void)error;
    // Touches all that the step points to, for the address sanitizer.
    uint64_t *sum = user;
    for (uint32_t i = 0; i < step->samples; i++)
        *sum += step->verdicts[i].violation;
    for (uint32_t i = 0; i < step->box->count; i++)
        *sum += step->box->lower[i] < step->box->upper[i];
    return STATUS_OK;
}

// Reads all there is; the status of the first thing that cannot be read.
static enum status read_all(const char *folder, struct error *error)
{
    struct journal *journal;
    enum status status = journal_open(&journal, folder, JOURNAL_READ, error);
    if (status != STATUS_OK)
        return status;
    struct journal_run run = {0};
    uint64_t sum = 0;
    status = journal_read_run(journal, &run, error);
    char **texts = NULL;
    if (status == STATUS_OK)
        status = journal_read_axes(journal, &texts, error);
    g_strfreev(texts);
    for (uint32_t i = 0; i < run.search_count && status == STATUS_OK; i++) {
        struct journal_search search;
        status = journal_read_search(journal, i, &search, error);
        if (status == STATUS_OK)
            journal_search_fini(&search);
        texts = NULL;
        if (status == STATUS_OK)
            status = journal_read_values(journal, i, &texts, error);
        g_strfreev(texts);
        if (status == STATUS_OK)
            status = journal_read_steps(journal, i, pass_over, &sum, error);
    }
    journal_close(journal);
    return status;
}

static void assert_error(const struct error *error, enum status status, const char *contains)
{
    assert_int_equal(error->status, status);
    if (strstr(error->text, contains) == NULL)
        fail_msg("expected \"%s\" in \"%s\"", contains, error->text);
}

static char *database_path(const char *folder)
{
    return g_build_filename(folder, "run.db", NULL);
}

// Changes the database behind the journal's back.
static void tamper(const char *folder, const char *sql)
{
    char *path = database_path(folder);
    sqlite3 *database;
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    char *message = NULL;
    if (sqlite3_exec(database, sql, NULL, NULL, &message) != SQLITE_OK)
        fail_msg("%s: %s", sql, message);
    sqlite3_close(database);
    g_free(path);
}

// ---- round trips ----

// Everything written at the start is read back as it was; 64-bit numbers above INT64_MAX could
// lose their sign in SQLite's signed integers.
static void run_and_searches_come_back(void **state)
{
    struct journal *journal = create(*state, 3);
    assert_int_equal(journal_state(journal, RUN_STATE_INTERRUPTED, 42, NULL), STATUS_OK);
    struct journal_run run, expected = run_of(3);
    assert_int_equal(journal_read_run(journal, &run, NULL), STATUS_OK);
    assert_string_equal(run.name, expected.name);
    assert_string_equal(run.version, expected.version);
    assert_true(run.id == expected.id);
    assert_int_equal(run.state, RUN_STATE_INTERRUPTED);
    assert_int_equal(run.search_count, 3);
    assert_int_equal(run.started_ns, expected.started_ns);
    assert_int_equal(run.elapsed_ns, 42);

    struct journal_search search, original = search_of(2);
    assert_int_equal(journal_read_search(journal, 2, &search, NULL), STATUS_OK);
    assert_string_equal(search.name, "case 2");
    assert_string_equal(search.text, scenario_text);
    assert_int_equal(search.text_size, sizeof scenario_text - 1);
    assert_true(digest_equal(&search.scenario, &original.scenario));
    assert_true(search.seed == original.seed);
    assert_false(search.finished);
    assert_int_equal(search.box.count, 0);
    journal_search_fini(&search);
    journal_close(journal);
}

// Steps of two searches that were appended in turn are read apart and in order, to the same bits.
static void steps_come_back_in_order(void **state)
{
    struct journal *journal = create(*state, 2);
    for (uint32_t i = 0; i < 20; i++) {
        append_ok(journal, 1, i);
        append_ok(journal, 0, i);
    }
    journal_close(journal);
    assert_int_equal(count_steps(*state, 0), 20);
    assert_int_equal(count_steps(*state, 1), 20);
}

// SQLite's REAL would turn -0.0 into 0 and a text would round: bounds and volumes keep every bit.
static void awkward_numbers_keep_their_bits(void **state)
{
    double lower[] = {-0.0, -DBL_MAX, 4.9406564584124654e-324, -2.2250738585072009e-308, 0.1};
    double upper[] = {0.0, DBL_MAX, DBL_MIN, -4.9406564584124654e-324, nextafter(0.1, 1)};
    enum { COUNT = G_N_ELEMENTS(lower) };
    struct journal *journal = create(*state, 1);
    struct journal_search search = {.status = "purity_missed",
                                    .box = {COUNT, lower, upper},
                                    .log_volume = -0.0,
                                    .purity_samples = 10000,
                                    .purity_bad = 17,
                                    .purity_estimate = 0.9983,
                                    .purity_lower95 = 5e-324,
                                    .evaluations = UINT64_C(1) << 40,
                                    .non_finite = 3,
                                    .steps = 207,
                                    .blocking_constraint = "s_L",
                                    .wall_ns = 123456789,
                                    .digest = digest_of("result", 6)};
    assert_int_equal(journal_finish_search(journal, &search, NULL), STATUS_OK);

    struct journal_search back;
    assert_int_equal(journal_read_search(journal, 0, &back, NULL), STATUS_OK);
    assert_true(back.finished);
    assert_string_equal(back.status, search.status);
    assert_int_equal(back.box.count, COUNT);
    assert_true(same_bits(back.box.lower, lower, COUNT));
    assert_true(same_bits(back.box.upper, upper, COUNT));
    assert_true(same_bits(&back.log_volume, &search.log_volume, 1));
    assert_true(same_bits(&back.purity_estimate, &search.purity_estimate, 1));
    assert_true(same_bits(&back.purity_lower95, &search.purity_lower95, 1));
    assert_int_equal(back.purity_samples, 10000);
    assert_int_equal(back.purity_bad, 17);
    assert_true(back.evaluations == search.evaluations);
    assert_int_equal(back.non_finite, 3);
    assert_int_equal(back.steps, 207);
    assert_string_equal(back.blocking_constraint, "s_L");
    assert_int_equal(back.wall_ns, 123456789);
    assert_true(digest_equal(&back.digest, &search.digest));
    journal_search_fini(&back);
    journal_close(journal);
}

struct large_step {
    struct box box;
    struct verdict verdicts[10000];
    bool seen;
};

static enum status check_large_step(void *user, const struct journal_step *step,
                                    struct error *error)
{
    (void)error;
    struct large_step *large = user;
    large->seen = true;
    assert_true(box_equal(step->box, &large->box));
    assert_int_equal(step->samples, 10000);
    assert_int_equal(step->detail, VERDICT_DETAIL_SHARE);
    assert_true(step->log_volume == -INFINITY);
    assert_true(isnan(step->growth));
    for (uint32_t i = 0; i < step->samples; i++)
        assert_int_equal(step->verdicts[i].violation == VERDICT_GOOD,
                         large->verdicts[i].violation == VERDICT_GOOD);
    return STATUS_OK;
}

// The largest scenario has 4096 variables, and a certificate keeps good or bad only: blobs of many
// pages, a NaN (NULL to SQLite) and an infinity.
static void large_box_and_shares_round_trip(void **state)
{
    struct large_step *large = g_new0(struct large_step, 1);
    box_init(&large->box, 4096);
    for (uint32_t i = 0; i < 4096; i++) {
        large->box.lower[i] = i * 0.1;
        large->box.upper[i] = i * 0.3;
    }
    for (uint32_t i = 0; i < 10000; i += 97)
        large->verdicts[i].violation = 7;
    struct journal_step step = {.phase = "certify",
                                .samples = 10000,
                                .good = verdict_good_count(large->verdicts, 10000),
                                .growth = NAN,
                                .log_volume = -INFINITY,
                                .box = &large->box,
                                .detail = VERDICT_DETAIL_SHARE,
                                .verdicts = large->verdicts};
    struct journal *journal = create(*state, 1);
    assert_int_equal(journal_append(journal, &step, NULL), STATUS_OK);
    assert_int_equal(journal_read_steps(journal, 0, check_large_step, large, NULL), STATUS_OK);
    assert_true(large->seen);
    journal_close(journal);
    box_fini(&large->box);
    g_free(large);
}

static enum status stop_at_third(void *user, const struct journal_step *step, struct error *error)
{
    uint32_t *visited = user;
    ++*visited;
    return step->step == 2 ? error_set(error, STATUS_INTERRUPTED, "enough") : STATUS_OK;
}

// A replay that finds something wrong must be able to stop the reading with its own message.
static void visitor_ends_the_reading(void **state)
{
    struct journal *journal = create(*state, 1);
    for (uint32_t i = 0; i < 5; i++)
        append_ok(journal, 0, i);
    uint32_t visited = 0;
    struct error error = {0};
    assert_int_equal(journal_read_steps(journal, 0, stop_at_third, &visited, &error),
                     STATUS_INTERRUPTED);
    assert_int_equal(visited, 3);
    assert_error(&error, STATUS_INTERRUPTED, "enough");
    journal_close(journal);
}

// A step that is appended twice would be replayed twice: the second one is refused.
static void step_is_appended_once(void **state)
{
    struct journal *journal = create(*state, 1);
    append_ok(journal, 0, 0);
    struct error error = {0};
    assert_int_equal(append(journal, 0, 0, &error), STATUS_IO);
    assert_error(&error, STATUS_IO, "UNIQUE");
    append_ok(journal, 0, 1);
    journal_close(journal);
    assert_int_equal(count_steps(*state, 0), 2);
}

// ---- death and full disks ----

// Appends steps from `first` on until it is killed, and says through the pipe when each is written.
static void append_until_killed(const char *folder, uint32_t first, int acknowledge)
{
    struct journal *journal;
    if (first == 0)
        journal = create(folder, 1);
    else if (journal_open(&journal, folder, JOURNAL_RESUME, NULL) != STATUS_OK)
        _exit(1);
    for (uint32_t i = first;; i++) {
        if (append(journal, 0, i, NULL) != STATUS_OK || write(acknowledge, "", 1) != 1)
            _exit(1);
    }
}

static pid_t start_appending(const char *folder, uint32_t first, int *acknowledged)
{
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        close(ends[0]);
        append_until_killed(folder, first, ends[1]);
    }
    close(ends[1]);
    *acknowledged = ends[0];
    return child;
}

// Kills the child after some acknowledged steps; returns how many it acknowledged in all.
static uint32_t kill_after(pid_t child, int acknowledged, uint32_t steps)
{
    uint32_t count = 0;
    char byte;
    while (count < steps && read(acknowledged, &byte, 1) == 1)
        count++;
    assert_int_equal(count, steps);
    kill(child, SIGKILL);
    while (read(acknowledged, &byte, 1) == 1)
        count++;
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status));
    close(acknowledged);
    return count;
}

// A coordinator that is killed at any moment, again and again, loses no step whose append had
// returned; a step kept in a buffer of the process would be lost, a torn one would be damage.
static void appended_steps_survive_kill(void **state)
{
    unsigned seed = (unsigned)time(NULL);
    print_message("seed %u\n", seed);
    srand(seed);
    uint32_t written = 0;
    for (int round = 0; round < 12; round++) {
        int acknowledged;
        pid_t child = start_appending(*state, written, &acknowledged);
        uint32_t least = written + kill_after(child, acknowledged, 1 + (uint32_t)rand() % 60);
        written = count_steps(*state, 0);
        assert_in_range(written, least, least + 1); // the one whose append did not return
    }
}

struct file_bytes {
    char *path, *bytes;
    gsize size;
};

static struct file_bytes file_keep(const char *folder, const char *name)
{
    struct file_bytes file = {.path = g_build_filename(folder, name, NULL)};
    assert_true(g_file_get_contents(file.path, &file.bytes, &file.size, NULL));
    return file;
}

static void file_put_back(const struct file_bytes *file, gsize size)
{
    assert_true(g_file_set_contents(file->path, file->bytes, (gssize)size, NULL));
}

static void file_forget(struct file_bytes *file)
{
    g_free(file->path);
    g_free(file->bytes);
}

// The log beside run.db, cut anywhere as a crashed file system may do, is read up to the cut.
static void cut_log_loses_only_the_last_steps(void **state)
{
    int acknowledged;
    pid_t child = start_appending(*state, 0, &acknowledged);
    kill_after(child, acknowledged, 20);
    struct file_bytes database = file_keep(*state, "run.db");
    struct file_bytes log = file_keep(*state, "run.db-wal");
    uint32_t last = count_steps(*state, 0);
    for (gsize size = log.size; size > log.size / 2; size -= 1777) {
        folder_empty(*state);
        file_put_back(&database, database.size);
        file_put_back(&log, size);
        uint32_t count = count_steps(*state, 0);
        assert_true(count <= last);
        last = count;
    }
    assert_true(last > 0);
    file_forget(&log);
    file_forget(&database);
}

// With no page left an append fails and says why; what was there is whole, and once there is space
// the same step can be written. The page limit stands for the disk.
static void full_disk_fails_the_append_only(void **state)
{
    struct journal *journal = create(*state, 1);
    append_ok(journal, 0, 0);
    sqlite3_exec(journal->database, "PRAGMA max_page_count = 12", NULL, NULL, NULL);
    struct error error = {0};
    uint32_t count = 1;
    while (append(journal, 0, count, &error) == STATUS_OK)
        count++;
    assert_error(&error, STATUS_IO, "the disk is full");
    assert_int_equal(count_steps(*state, 0), count);

    sqlite3_exec(journal->database, "PRAGMA max_page_count = 100000", NULL, NULL, NULL);
    append_ok(journal, 0, count);
    journal_close(journal);
    assert_int_equal(count_steps(*state, 0), count + 1);
}

// Writing into a file that has no name any more succeeds, and hours of work would be gone at the
// end.
static void removed_journal_fails_the_append(void **state)
{
    struct journal *journal = create(*state, 1);
    append_ok(journal, 0, 0);
    char *path = database_path(*state);
    assert_int_equal(unlink(path), 0);
    g_free(path);
    struct error error = {0};
    assert_int_equal(append(journal, 0, 1, &error), STATUS_IO);
    assert_error(&error, STATUS_IO, "was removed or moved away");
    journal_close(journal);
}

// Files may grow to `size` bytes only: the nearest thing to a full disk that needs no mount.
static void limit_files(rlim_t size)
{
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = size;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

// A creation that runs out of space, wherever that happens, leaves no file that looks like a run.
static void failed_creation_leaves_nothing(void **state)
{
    signal(SIGXFSZ, SIG_IGN);
    uint32_t failures = 0;
    struct journal_run run = run_of(1);
    struct journal_search search = search_of(0);
    for (rlim_t size = 0; size < 40000; size += 999) {
        struct journal *journal;
        limit_files(size);
        enum status status = journal_create(&journal, *state, &run, &search, NULL);
        limit_files(RLIM_INFINITY);
        if (status == STATUS_OK) {
            journal_close(journal);
            folder_empty(*state);
            continue;
        }
        assert_int_equal(status, STATUS_IO);
        failures++;
        GDir *dir = g_dir_open(*state, 0, NULL);
        assert_null(g_dir_read_name(dir));
        g_dir_close(dir);
    }
    assert_true(failures > 10);
}

// ---- readers and writers ----

// A report on a running search must neither wait nor make the search wait, and shows one moment of
// it from beginning to end.
static void reader_sees_one_moment_beside_the_writer(void **state)
{
    struct journal *writer = create(*state, 1);
    append_ok(writer, 0, 0);
    struct journal *reader;
    assert_int_equal(journal_open(&reader, *state, JOURNAL_READ, NULL), STATUS_OK);
    append_ok(writer, 0, 1);
    struct reading reading = {0};
    assert_int_equal(journal_read_steps(reader, 0, check_sample_step, &reading, NULL), STATUS_OK);
    assert_int_equal(reading.count, 1);
    assert_int_equal(count_steps(*state, 0), 2);
    journal_close(writer);
    journal_close(reader);
    assert_int_equal(count_steps(*state, 0), 2);
}

// Looking at a run folder leaves nothing behind in it.
static void readers_leave_no_files(void **state)
{
    struct journal *journal = create(*state, 1);
    append_ok(journal, 0, 0);
    journal_close(journal);
    assert_int_equal(read_all(*state, NULL), STATUS_OK);
    GDir *dir = g_dir_open(*state, 0, NULL);
    assert_string_equal(g_dir_read_name(dir), "run.db");
    assert_null(g_dir_read_name(dir));
    g_dir_close(dir);
}

// Two coordinators on one folder would mix their steps: the second is told who the first is, and
// gets its turn when that one has ended.
static void second_writer_is_refused(void **state)
{
    struct journal *first = create(*state, 1), *second;
    struct error error = {0};
    assert_int_equal(journal_open(&second, *state, JOURNAL_RESUME, &error), STATUS_REFUSED);
    assert_null(second);
    char process[32];
    g_snprintf(process, sizeof process, "process %ld on ", (long)getpid());
    assert_error(&error, STATUS_REFUSED, process);
    append_ok(first, 0, 0);
    journal_close(first);
    assert_int_equal(journal_open(&second, *state, JOURNAL_RESUME, &error), STATUS_OK);
    append_ok(second, 0, 1);
    journal_close(second);
    assert_int_equal(count_steps(*state, 0), 2);
}

// The lock file that a killed coordinator leaves does not lock its folder for ever.
static void dead_writer_holds_no_lock(void **state)
{
    int acknowledged;
    pid_t child = start_appending(*state, 0, &acknowledged);
    uint32_t least = kill_after(child, acknowledged, 1);
    char *lock = g_build_filename(*state, "run.db.lock", NULL);
    assert_int_equal(access(lock, F_OK), 0);
    struct journal *journal;
    assert_int_equal(journal_open(&journal, *state, JOURNAL_RESUME, NULL), STATUS_OK);
    journal_close(journal);
    assert_int_not_equal(access(lock, F_OK), 0);
    assert_true(count_steps(*state, 0) >= least);
    g_free(lock);
}

// A finished run is kept on read-only media or in someone else's folder, where SQLite cannot make
// the files it wants beside a WAL database.
static void finished_run_reads_from_read_only_folder(void **state)
{
    struct journal *journal = create(*state, 1);
    append_ok(journal, 0, 0);
    journal_close(journal);
    assert_int_equal(chmod(*state, 0555), 0);
    pid_t child = fork();
    if (child == 0) {
        if (geteuid() == 0 && setuid(65534) != 0)
            _exit(1);
        struct error error = {0};
        enum status status = read_all(*state, &error);
        if (status != STATUS_OK)
            fprintf(stderr, "%s\n", error.text);
        _exit(status == STATUS_OK ? 0 : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(chmod(*state, 0755), 0);
    assert_int_equal(status, 0);
}

// ---- files that are not what they should be ----

static void write_bytes(const char *folder, const char *bytes, size_t size)
{
    char *path = database_path(folder);
    assert_true(g_file_set_contents(path, bytes, (gssize)size, NULL));
    g_free(path);
}

// Each wrong file has its own sentence, because each asks for something else from the user.
static void wrong_files_are_told_apart(void **state)
{
    struct error error = {0};
    struct journal *journal;
    read_all(*state, &error);
    assert_error(&error, STATUS_IO, "there is none");
    read_all("/nowhere/at/all", &error);
    assert_error(&error, STATUS_IO, "there is none");
    write_bytes(*state, "", 0);
    read_all(*state, &error);
    assert_error(&error, STATUS_IO, "stopped before it began");
    static const char prose[] = "This is a letter to my aunt. It is long enough to be read as the "
                                "hundred bytes of a database's header, and it is none.";
    write_bytes(*state, prose, sizeof prose);
    read_all(*state, &error);
    assert_error(&error, STATUS_IO, "not an SQLite database");
    folder_empty(*state);

    tamper(*state, "CREATE TABLE run (name TEXT)");
    read_all(*state, &error);
    assert_error(&error, STATUS_IO, "not the journal of a run");
    struct journal_run run = run_of(0);
    assert_int_equal(journal_create(&journal, *state, &run, NULL, &error), STATUS_IO);
    assert_error(&error, STATUS_IO, "there is a run already");
    assert_int_equal(journal_create(&journal, "/nowhere", &run, NULL, &error), STATUS_IO);
    assert_error(&error, STATUS_IO, "cannot be created");
    folder_empty(*state);

    journal_close(create(*state, 1));
    tamper(*state, "UPDATE meta SET schema = 5");
    read_all(*state, &error);
    assert_error(&error, STATUS_REFUSED, "version 5");
    assert_int_equal(journal_open(&journal, *state, JOURNAL_RESUME, &error), STATUS_REFUSED);
}

// A database that SQLite finds sound may still lie about sizes and counts; each lie is found before
// it is used.
static void lies_are_found(void **state)
{
    static const char *const LIES[] = {
        "UPDATE run SET state = 'sleeping'",
        "UPDATE run SET search_count = 1000000",
        "UPDATE run SET search_count = -1",
        "UPDATE run SET name = printf('%.100c', 'x')",
        "UPDATE run SET name = CAST(x'ff' AS TEXT)",
        "UPDATE run SET name = CAST(x'610062' AS TEXT)",
        "DELETE FROM run",
        "UPDATE search SET number = 7",
        "UPDATE search SET scenario_digest = x'00'",
        "UPDATE search SET finished = 2",
        "UPDATE search SET finished = 1",
        "UPDATE step SET samples = 4000000000",
        "UPDATE step SET samples = -1",
        "UPDATE step SET samples = 1, good = 1",
        "UPDATE step SET samples = 199",
        "UPDATE step SET good = good + 1",
        "UPDATE step SET detail = 1",
        "UPDATE step SET detail = 99",
        "UPDATE step SET sampling = 99",
        "UPDATE step SET sampling = -1",
        "UPDATE step SET bounds = zeroblob(17)",
        "UPDATE step SET bounds = zeroblob(60000000)",
        "UPDATE step SET bounds = CAST(x'0000000000000040' || zeroblob(8) AS BLOB)",
        "UPDATE step SET bounds = CAST(x'000000000000f87f000000000000f87f' AS BLOB)",
        "UPDATE step SET exact = x''",
        "UPDATE step SET verdicts = zeroblob(2000)",
        "UPDATE step SET phase = printf('%.100c', 'x')",
        "UPDATE step SET search = 1",
        "INSERT INTO axis VALUES (1, 'vehicle.mass')",
        "INSERT INTO axis_value VALUES (0, 0, CAST(x'ff' AS TEXT))",
        "DROP TABLE step",
        "ALTER TABLE step RENAME COLUMN verdicts TO opinions",
    };
    for (size_t i = 0; i < G_N_ELEMENTS(LIES); i++) {
        struct journal *journal = create(*state, 1);
        append_ok(journal, 0, 0);
        journal_close(journal);
        assert_int_equal(read_all(*state, NULL), STATUS_OK);
        tamper(*state, LIES[i]);
        struct error error = {0};
        if (read_all(*state, &error) != STATUS_IO)
            fail_msg("not found: %s", LIES[i]);
        assert_non_null(strstr(error.text, "run.db: "));
        folder_empty(*state);
    }
}

static char *finished_database(const char *folder, gsize *size)
{
    struct journal *journal = create(folder, 2);
    for (uint32_t i = 0; i < 30; i++)
        append_ok(journal, i % 2, i / 2);
    journal_close(journal);
    char *path = database_path(folder), *bytes;
    assert_true(g_file_get_contents(path, &bytes, size, NULL));
    g_free(path);
    return bytes;
}

// A copy that broke off is an error at every length, not a shorter run.
static void truncated_file_is_an_error(void **state)
{
    gsize size;
    char *bytes = finished_database(*state, &size);
    for (gsize cut = 0; cut < size; cut += cut < 200 ? 7 : 1021) {
        folder_empty(*state);
        write_bytes(*state, bytes, cut);
        assert_int_equal(read_all(*state, NULL), STATUS_IO);
    }
    g_free(bytes);
}

// Whatever a damaged file says, reading ends with a status; sanitizers watch for the rest.
static void random_damage_never_crashes(void **state)
{
    unsigned seed = (unsigned)time(NULL);
    print_message("seed %u\n", seed);
    srand(seed);
    gsize size;
    char *bytes = finished_database(*state, &size);
    char *damaged = g_malloc(size);
    for (int round = 0; round < 150; round++) {
        memcpy(damaged, bytes, size);
        for (int i = 0; i < 1 + round % 20; i++)
            damaged[(gsize)rand() % size] = (char)rand();
        folder_empty(*state);
        write_bytes(*state, damaged, size);
        struct error error = {0};
        enum status status = read_all(*state, &error);
        assert_true(status == STATUS_OK || status == STATUS_IO || status == STATUS_REFUSED);
        assert_int_equal(status == STATUS_OK, error.text[0] == '\0');
    }
    g_free(damaged);
    g_free(bytes);
}

// ---- sweeps ----

static const char *const AXES[] = {"vehicle.mass", "springs.0.force_x"};

// A source of `left` cases; where `failing` is met it fails.
struct cases {
    uint32_t next, count, failing;
};

static enum status next_case(void *user, struct journal_search *search, bool *more,
                             struct error *error)
{
    static char mass[32];
    static const char *values[2] = {mass, "[1, 'two']"};
    struct cases *cases = user;
    *more = cases->next < cases->count;
    if (!*more)
        return STATUS_OK;
    if (cases->next == cases->failing)
        return error_set(error, STATUS_INVALID, "this case is wrong");
    *search = search_of(cases->next);
    g_snprintf(mass, sizeof mass, "%" PRIu32, 1500 + cases->next++);
    search->values = values;
    return STATUS_OK;
}

static enum status count_standing(void *user, const struct journal_standing *standing,
                                  struct error *error)
{
    (void)error;
    uint32_t *count = user;
    assert_int_equal(standing->index, *count);
    assert_int_equal(standing->finished, standing->index == 1);
    assert_string_equal(standing->status, standing->index == 1   ? "done"
                                          : standing->index == 2 ? "failed"
                                                                 : "running");
    ++*count;
    return STATUS_OK;
}

// What the cases are made of is in the file, so that a report needs nothing else.
static void axes_and_values_of_a_sweep_come_back(void **state)
{
    struct cases cases = {.count = 300, .failing = UINT32_MAX};
    struct journal_run run = run_of(0);
    struct journal *journal;
    struct error error = {0};
    assert_int_equal(
        journal_create_from(&journal, *state, &run, AXES, 2, next_case, &cases, &error), STATUS_OK);
    struct journal_search result = search_of(1);
    g_strlcpy(result.status, "done", sizeof result.status);
    assert_int_equal(journal_finish_search(journal, &result, &error), STATUS_OK);
    assert_int_equal(journal_fail_search(journal, 2, &error), STATUS_OK);
    journal_close(journal);

    assert_int_equal(journal_open(&journal, *state, JOURNAL_READ, &error), STATUS_OK);
    assert_int_equal(journal_read_run(journal, &run, &error), STATUS_OK);
    assert_int_equal(run.search_count, 300);
    char **axes, **values;
    assert_int_equal(journal_read_axes(journal, &axes, &error), STATUS_OK);
    assert_string_equal(axes[0], AXES[0]);
    assert_string_equal(axes[1], AXES[1]);
    assert_null(axes[2]);
    assert_int_equal(journal_read_values(journal, 299, &values, &error), STATUS_OK);
    assert_string_equal(values[0], "1799");
    assert_string_equal(values[1], "[1, 'two']");
    assert_null(values[2]);
    uint32_t count = 0;
    assert_int_equal(journal_read_standings(journal, count_standing, &count, &error), STATUS_OK);
    assert_int_equal(count, 300);
    g_strfreev(values);
    g_strfreev(axes);
    journal_close(journal);
}

// The hundredth case of a sweep may be the wrong one: the ninety-nine before it are no run.
static void failing_source_leaves_nothing(void **state)
{
    struct cases cases = {.count = 300, .failing = 99};
    struct journal_run run = run_of(0);
    struct journal *journal;
    struct error error = {0};
    assert_int_equal(
        journal_create_from(&journal, *state, &run, AXES, 2, next_case, &cases, &error),
        STATUS_INVALID);
    assert_string_equal(error.text, "this case is wrong");
    assert_null(journal);
    GDir *dir = g_dir_open(*state, 0, NULL);
    assert_null(g_dir_read_name(dir));
    g_dir_close(dir);
}

// Runs that were begun before there were sweeps go on.
static void journal_without_axes_is_still_read(void **state)
{
    struct journal *journal = create(*state, 1);
    append_ok(journal, 0, 0);
    journal_close(journal);
    tamper(*state, "UPDATE meta SET schema = 1; DROP TABLE axis; DROP TABLE axis_value;"
                   "ALTER TABLE step DROP COLUMN sampling");
    struct error error = {0};
    char **axes, **values;
    assert_int_equal(journal_open(&journal, *state, JOURNAL_RESUME, &error), STATUS_OK);
    assert_int_equal(journal_read_axes(journal, &axes, &error), STATUS_OK);
    assert_int_equal(journal_read_values(journal, 0, &values, &error), STATUS_OK);
    assert_null(axes[0]);
    assert_null(values[0]);
    append_ok(journal, 0, 1);
    journal_close(journal);
    g_strfreev(axes);
    g_strfreev(values);
}

// Runs whose steps do not say how they were sampled go on, and nobody makes a guess of it.
static void journal_without_samplings_is_still_read(void **state)
{
    struct journal *journal = create(*state, 1);
    append_ok(journal, 0, 0);
    journal_close(journal);
    tamper(*state, "UPDATE meta SET schema = 2; ALTER TABLE step DROP COLUMN sampling");
    struct error error = {0};
    assert_int_equal(journal_open(&journal, *state, JOURNAL_RESUME, &error), STATUS_OK);
    append_ok(journal, 0, 1);
    struct reading reading = {.old = true};
    assert_int_equal(journal_read_steps(journal, 0, check_sample_step, &reading, &error),
                     STATUS_OK);
    assert_int_equal(reading.count, 2);
    journal_close(journal);
}

// Steps written as one are all there or none, and a reader sees them once they are committed.
static void steps_between_begin_and_commit_are_written_as_one(void **state)
{
    struct journal *journal = create(*state, 2), *reader;
    struct error error = {0};
    for (int round = 0; round < 2; round++) {
        assert_int_equal(journal_begin(journal, &error), STATUS_OK);
        append_ok(journal, 0, (uint32_t)round);
        append_ok(journal, 1, (uint32_t)round);
        if (round == 0)
            assert_int_equal(journal_commit(journal, &error), STATUS_OK);
    }
    assert_int_equal(journal_open(&reader, *state, JOURNAL_READ, &error), STATUS_OK);
    sqlite3_stmt *count = journal_prepare(reader, "SELECT count(*) FROM step", &error);
    assert_int_equal(sqlite3_step(count), SQLITE_ROW);
    assert_int_equal(sqlite3_column_int(count, 0), 2);
    sqlite3_finalize(count);
    journal_close(reader);
    assert_int_equal(journal_commit(journal, &error), STATUS_OK);
    assert_int_equal(journal_commit(journal, &error), STATUS_OK); // nothing left to write
    journal_close(journal);
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, folder_make, folder_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(run_and_searches_come_back),
        IN_FOLDER(steps_come_back_in_order),
        IN_FOLDER(awkward_numbers_keep_their_bits),
        IN_FOLDER(large_box_and_shares_round_trip),
        IN_FOLDER(visitor_ends_the_reading),
        IN_FOLDER(step_is_appended_once),
        IN_FOLDER(appended_steps_survive_kill),
        IN_FOLDER(cut_log_loses_only_the_last_steps),
        IN_FOLDER(full_disk_fails_the_append_only),
        IN_FOLDER(removed_journal_fails_the_append),
        IN_FOLDER(failed_creation_leaves_nothing),
        IN_FOLDER(reader_sees_one_moment_beside_the_writer),
        IN_FOLDER(readers_leave_no_files),
        IN_FOLDER(second_writer_is_refused),
        IN_FOLDER(dead_writer_holds_no_lock),
        IN_FOLDER(finished_run_reads_from_read_only_folder),
        IN_FOLDER(wrong_files_are_told_apart),
        IN_FOLDER(lies_are_found),
        IN_FOLDER(truncated_file_is_an_error),
        IN_FOLDER(random_damage_never_crashes),
        IN_FOLDER(axes_and_values_of_a_sweep_come_back),
        IN_FOLDER(failing_source_leaves_nothing),
        IN_FOLDER(journal_without_axes_is_still_read),
        IN_FOLDER(journal_without_samplings_is_still_read),
        IN_FOLDER(steps_between_begin_and_commit_are_written_as_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
