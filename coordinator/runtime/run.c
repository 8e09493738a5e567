#include "coordinator/runtime/run.h"

#include "common/base/clock.h"
#include "common/scenario/scenario_read.h"

#include <errno.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FOLDER_TRIES = 100000 }; // runs/NAME-2 .. runs/NAME-100000

static bool folder_empty(const char *path)
{
    GDir *dir = g_dir_open(path, 0, NULL);
    if (dir == NULL)
        return false;
    bool empty = g_dir_read_name(dir) == NULL;
    g_dir_close(dir);
    return empty;
}

// The first of runs/NAME, runs/NAME-2, ... that does not exist.
static char *folder_pick(const char *name)
{
    char *path = g_build_filename("runs", name, NULL);
    for (int number = 2; number < FOLDER_TRIES && g_file_test(path, G_FILE_TEST_EXISTS); number++) {
        g_free(path);
        path = g_strdup_printf("runs/%s-%d", name, number);
    }
    return path;
}

static enum status folder_make(const char *path, struct error *error)
{
    if (g_mkdir_with_parents(path, 0777) != 0)
        return error_set(error, STATUS_INVALID, "%s: cannot make the run folder: %s", path,
                         g_strerror(errno));
    if (!folder_empty(path))
        return error_set(error, STATUS_INVALID,
                         "%s: the run folder is not empty: name another with --out, or continue "
                         "the run in it with --resume",
                         path);
    if (access(path, W_OK | X_OK) != 0)
        return error_set(error, STATUS_INVALID, "%s: cannot write into the run folder: %s", path,
                         g_strerror(errno));
    return STATUS_OK;
}

// Gives a search its working memory. The scenario is in place.
static void search_start(struct run_search *search, uint32_t index, int threads, int64_t now_ns)
{
    const struct scenario *scenario = &search->scenario;
    search->search = search_create(scenario, index, scenario->search.seed, threads);
    search->bounds = g_new(double, 2 * (size_t)scenario->design_space.count);
    search->started_ns = now_ns;
}

static uint64_t random_id(void)
{
    // Positive as the signed number that travels, and never 0.
    uint64_t id;
    do {
        randombytes_buf(&id, sizeof id);
        id >>= 1;
    } while (id == 0);
    return id;
}

enum status run_create(struct run *run, const char *directory, struct scenario *scenario,
                       int threads, int64_t now_ns, struct error *error)
{
    *run = (struct run){.started_ns = now_ns};
    run->directory = directory ? g_strdup(directory) : folder_pick(scenario->name);
    run->folder_made = !g_file_test(run->directory, G_FILE_TEST_IS_DIR);
    enum status status = folder_make(run->directory, error);
    if (status != STATUS_OK) {
        run_fini(run);
        return status;
    }
    run->record = (struct journal_run){
        .state = JOURNAL_STATE_RUNNING,
        .id = random_id(),
        .search_count = 1,
        .started_ns = clock_calendar_ns(),
    };
    g_strlcpy(run->record.name, scenario->name, sizeof run->record.name);
    g_strlcpy(run->record.version, SOBOX_VERSION, sizeof run->record.version);
    const struct journal_search search = {
        .index = 0,
        .text = scenario->text,
        .text_size = scenario->text_size,
        .scenario = scenario->digest,
        .seed = scenario->search.seed,
    };
    status = journal_create(&run->journal, run->directory, &run->record, &search, error);
    if (status != STATUS_OK) {
        run_abandon(run);
        run_fini(run);
        return status;
    }
    run->searches = g_new0(struct run_search, 1);
    run->searches[0].scenario = *scenario;
    *scenario = (struct scenario){0};
    search_start(&run->searches[0], 0, threads, now_ns);
    return STATUS_OK;
}

// Gives the search the verdicts of a step again. They must answer what it asks for now.
static enum status replay(void *user, const struct journal_step *step, struct error *error)
{
    struct search *search = user;
    struct search_request request;
    if (!search_request(search, &request) || request.sampling.step != step->step ||
        request.sampling.samples != step->samples || request.detail != step->detail ||
        !box_equal(request.box, step->box))
        return error_set(error, STATUS_REFUSED,
                         "step %u of the journal is not what the search asks for: it was written "
                         "by another version of sobox, or changed",
                         step->step);
    search_complete(search, step->verdicts);
    return STATUS_OK;
}

static bool journal_present(const char *directory)
{
    char *path = g_build_filename(directory, "run.db", NULL);
    const bool present = g_file_test(path, G_FILE_TEST_EXISTS);
    g_free(path);
    return present;
}

static enum status resume_search(struct run *run, uint32_t index, int threads, int64_t now_ns,
                                 struct error *error)
{
    struct run_search *search = &run->searches[index];
    struct journal_search record;
    enum status status = journal_read_search(run->journal, index, &record, error);
    if (status != STATUS_OK)
        return status;
    char *source = g_strdup_printf("%s/run.db, search %u", run->directory, index);
    status = scenario_read_text(&search->scenario, source, record.text, record.text_size, NULL, 0,
                                error);
    g_free(source);
    if (status == STATUS_OK) {
        search_start(search, index, threads, now_ns);
        status = journal_read_steps(run->journal, index, replay, search->search, error);
    }
    if (record.finished) {
        search->done = true;
        run->done_count++;
    }
    journal_search_fini(&record);
    return status;
}

enum status run_resume(struct run *run, const char *directory, int threads, int64_t now_ns,
                       struct error *error)
{
    *run = (struct run){.started_ns = now_ns, .directory = g_strdup(directory)};
    if (!journal_present(directory)) {
        run_fini(run);
        return error_set(
            error, STATUS_INVALID,
            "%s: there is no run to continue: expected a run folder, which has a run.db",
            directory);
    }
    enum status status = journal_open(&run->journal, directory, JOURNAL_RESUME, error);
    if (status == STATUS_OK)
        status = journal_read_run(run->journal, &run->record, error);
    if (status == STATUS_OK && run->record.state == JOURNAL_STATE_DONE)
        status = error_set(error, STATUS_REFUSED, "this run is done: see it with 'sobox-report %s'",
                           directory);
    if (status == STATUS_OK && strcmp(run->record.version, SOBOX_VERSION) != 0)
        status = error_set(error, STATUS_REFUSED,
                           "begun by sobox %s, which may search otherwise than this one (%s): "
                           "continue it with that version",
                           run->record.version, SOBOX_VERSION);
    if (status == STATUS_OK)
        run->searches = g_new0(struct run_search, run->record.search_count);
    for (uint32_t i = 0; status == STATUS_OK && i < run->record.search_count; i++)
        status = resume_search(run, i, threads, now_ns, error);
    if (status != STATUS_OK) {
        error_wrap(error, "%s", directory);
        run_fini(run);
    }
    return status;
}

static enum status write_result(struct run *run, uint32_t index, int64_t now_ns,
                                struct error *error)
{
    struct run_search *search = &run->searches[index];
    struct search_result result;
    search_result(search->search, &result);
    search->finished_ns = now_ns;
    struct journal_search record = {
        .index = index,
        .finished = true,
        .box = *result.box, // borrowed for the call
        .log_volume = result.log_volume,
        .purity_samples = result.purity.samples,
        .purity_bad = result.purity.bad,
        .purity_estimate = result.purity.estimate,
        .purity_lower95 = result.purity.lower95,
        .evaluations = result.evaluations,
        .non_finite = result.non_finite,
        .steps = result.steps,
        .wall_ns = run->record.elapsed_ns + now_ns - search->started_ns,
        .digest = result.digest,
    };
    g_strlcpy(record.status, search_status_name(result.status), sizeof record.status);
    if (result.status == SEARCH_STATUS_NO_GOOD_DESIGN) {
        uint32_t blocking = result.blocking_constraint;
        scenario_outcome_name(&search->scenario, search->scenario.constraints[blocking].outcome,
                              record.blocking_constraint);
    }
    return journal_finish_search(run->journal, &record, error);
}

enum status run_next(struct run *run, uint32_t index, int64_t now_ns, bool *wanted,
                     struct error *error)
{
    struct run_search *search = &run->searches[index];
    *wanted = false;
    search->active = false;
    if (search->done)
        return STATUS_OK;
    if (!search_request(search->search, &search->request)) {
        enum status status = write_result(run, index, now_ns, error);
        search->done = status == STATUS_OK;
        run->done_count += search->done;
        return status;
    }
    const struct box *box = search->request.box;
    memcpy(search->bounds, box->lower, box->count * sizeof(double));
    memcpy(search->bounds + box->count, box->upper, box->count * sizeof(double));
    search->box = digest_of(search->bounds, 2 * (size_t)box->count * sizeof(double));
    search->verdicts = g_renew(struct verdict, search->verdicts, search->request.sampling.samples);
    search->active = *wanted = true;
    return STATUS_OK;
}

enum status run_complete(struct run *run, uint32_t index, struct error *error)
{
    struct run_search *search = &run->searches[index];
    const uint32_t count = search->scenario.design_space.count;
    const enum verdict_detail detail = search->request.detail;
    search_complete(search->search, search->verdicts);
    search->active = false;

    const struct search_step *step = search_last_step(search->search);
    const struct box sampled = {
        .count = count, .lower = search->bounds, .upper = search->bounds + count};
    struct journal_step record = {
        .search = index,
        .step = step->step,
        .samples = step->samples,
        .good = step->good,
        .growth = step->growth,
        .log_volume = step->log_volume,
        .box = &sampled,
        .detail = detail,
        .verdicts = search->verdicts,
    };
    g_strlcpy(record.phase, search_phase_name(step->phase), sizeof record.phase);
    return journal_append(run->journal, &record, error);
}

int64_t run_elapsed_ns(const struct run *run, int64_t now_ns)
{
    return run->record.elapsed_ns + now_ns - run->started_ns;
}

enum status run_end(struct run *run, enum journal_state state, int64_t now_ns, struct error *error)
{
    return journal_state(run->journal, state, run_elapsed_ns(run, now_ns), error);
}

void run_fini(struct run *run)
{
    for (uint32_t i = 0; run->searches != NULL && i < run->record.search_count; i++) {
        struct run_search *search = &run->searches[i];
        search_free(search->search);
        scenario_fini(&search->scenario);
        g_free(search->bounds);
        g_free(search->verdicts);
    }
    g_free(run->searches);
    journal_close(run->journal);
    g_free(run->directory);
    *run = (struct run){0};
}

void run_abandon(struct run *run)
{
    journal_close(run->journal);
    run->journal = NULL;
    static const char *const files[] = {"run.db-wal", "run.db-shm", "run.db.lock", "run.db"};
    for (size_t i = 0; i < G_N_ELEMENTS(files); i++) {
        char *path = g_build_filename(run->directory, files[i], NULL);
        g_unlink(path);
        g_free(path);
    }
    if (!run->folder_made)
        return;
    g_rmdir(run->directory);
    // The folder of picked folders too, when it was made for this run: it goes only if it is empty.
    if (g_str_has_prefix(run->directory, "runs/"))
        g_rmdir("runs");
}
