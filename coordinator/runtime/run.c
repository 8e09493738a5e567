#include "coordinator/runtime/run.h"

#include "common/sampling/box_text.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/numeric/identity.h"
#include "common/scenario/scenario_read.h"
#include "coordinator/journal/run_folder.h"

#include <assert.h>
#include <fnmatch.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <string.h>

// ---- Beginning ----

static enum status begin(struct run *run, const char *directory, const char *name, int threads,
                         int64_t now_ns, struct error *error)
{
    *run = (struct run){.started_ns = now_ns, .threads = threads};
    run->record = (struct journal_run){
        .state = RUN_STATE_RUNNING,
        .id = identity_random(),
        .started_ns = clock_calendar_ns(),
    };
    g_strlcpy(run->record.name, name, sizeof run->record.name);
    g_strlcpy(run->record.version, SOBOX_VERSION, sizeof run->record.version);
    return run_folder_make(directory, name, &run->directory, &run->folder_made, error);
}

// Room for the searches of the record, all of them waiting and chosen.
static void make_room(struct run *run)
{
    const uint32_t count = run->record.search_count;
    run->open = g_new0(struct run_search *, count);
    run->standings = g_new0(uint8_t, count);
    run->chosen = g_malloc(count);
    memset(run->chosen, 1, count);
    run->chosen_count = count;
    // Of many searches each is trimmed by one thread, several at once.
    if (count > 1)
        run->threads = 1;
}

// Takes back the choice of all but the first `count` chosen searches.
static void limit_choice(struct run *run, uint32_t count)
{
    if (count == 0 || count >= run->chosen_count)
        return;
    uint32_t left = count;
    for (uint32_t i = 0; i < run->record.search_count; i++) {
        if (run->chosen[i] != 0 && left > 0)
            left--;
        else
            run->chosen[i] = 0;
    }
    run->chosen_count = count;
}

static struct journal_search record_of(const struct scenario *scenario)
{
    return (struct journal_search){
        .text = scenario->text,
        .text_size = scenario->text_size,
        .scenario = scenario->digest,
        .seed = scenario->search.seed,
    };
}

static void discard(struct run *run)
{
    run_abandon(run);
    run_fini(run);
}

enum status run_create(struct run *run, const char *directory, const struct scenario *scenario,
                       int threads, int64_t now_ns, struct error *error)
{
    enum status status = begin(run, directory, scenario->name, threads, now_ns, error);
    if (status != STATUS_OK)
        return status;
    const struct journal_search search = record_of(scenario);
    run->record.search_count = 1;
    status = journal_create(&run->journal, run->directory, &run->record, &search, error);
    if (status != STATUS_OK)
        discard(run);
    else
        make_room(run);
    return status;
}

// ---- A sweep ----

void run_cases_init(struct run_cases *cases, const struct sweep *sweep,
                    const struct run_choice *choice)
{
    *cases = (struct run_cases){.sweep = sweep, .choice = choice};
}

static bool choose_name(const struct run_choice *choice, const char *name)
{
    return choice->only == NULL || fnmatch(choice->only, name, 0) == 0;
}

// Whether the verdicts of a scenario depend on barrier.overlap: it changes no crash, only by what
// length two of the outcomes are measured.
static bool judged_by_overlap(const struct scenario *scenario)
{
    for (uint32_t i = 0; i < scenario->case_count; i++)
        if (judged_by_overlap(&scenario->cases[i]))
            return true;
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP || scenario->case_count > 0)
        return false;
    for (uint32_t i = 0; i < scenario->constraint_count; i++) {
        const uint32_t outcome = scenario->constraints[i].outcome;
        if (outcome == OUTCOME_ABWAP || outcome == OUTCOME_ABWP)
            return true;
    }
    return false;
}

// Says when searches will be the same for each value of an axis whose name promises another crash.
static void note_overlap(const struct run_cases *cases)
{
    if (cases->without_overlap > 0 &&
        g_strv_contains(sweep_columns(cases->sweep), "barrier.overlap"))
        log_note(
            "barrier.overlap changes nothing in %u of %u cases: it only scales AbWAP and AbWP, "
            "which no constraint bounds there; barrier.edge_y moves the end of the face",
            cases->without_overlap, cases->count);
}

static bool told_already(const struct run_cases *cases, uint32_t hash)
{
    for (uint32_t i = 0; i < cases->told_count; i++)
        if (cases->told[i] == hash)
            return true;
    return false;
}

// One warning a place and row of the table: the same place in the base is that of all cases.
static void tell_warnings(struct run_cases *cases, const struct scenario *scenario,
                          const char *name)
{
    cases->implausible += scenario->finding_count > 0;
    for (uint32_t i = 0; i < scenario->finding_count; i++) {
        const struct scenario_finding *finding = &scenario->findings[i];
        const uint32_t hash = g_str_hash(finding->place) ^ (uint32_t)finding->check;
        if (cases->told_count == RUN_WARNINGS_MAX || told_already(cases, hash))
            continue;
        cases->told[cases->told_count++] = hash;
        char *text = g_strdup_printf("%s (in the case %s)", finding->text, name);
        log_warning(finding->place, text);
        g_free(text);
    }
}

static void note_warnings(const struct run_cases *cases)
{
    if (cases->implausible > 0)
        log_note(
            "%u of %u cases are unlikely to be meant as they are: result.json has the warnings "
            "of each",
            cases->implausible, cases->count);
}

enum status run_cases_next(struct run_cases *cases, uint32_t *index, struct scenario *scenario,
                           struct error *error)
{
    const struct run_choice *choice = cases->choice;
    while (cases->next < sweep_case_count(cases->sweep)) {
        *index = cases->next++;
        char name[SWEEP_CASE_NAME_SIZE];
        if (*index % choice->shard_count != choice->shard - 1 ||
            !choose_name(choice, sweep_case_name(cases->sweep, *index, name)))
            continue;
        struct error reason = {0};
        if (sweep_scenario(cases->sweep, *index, scenario, &reason) == STATUS_OK) {
            cases->count++;
            tell_warnings(cases, scenario, name);
            cases->without_overlap += !judged_by_overlap(scenario);
            return STATUS_OK;
        }
        if (!choice->keep_going)
            return error_set(error, reason.status, "%s", reason.text);
        cases->invalid++;
        log_failure(&reason);
    }
    *index = UINT32_MAX;
    return STATUS_OK;
}

enum status run_cases_check(const struct run_cases *cases, struct error *error)
{
    const struct run_choice *choice = cases->choice;
    if (cases->invalid > 0)
        log_note("%u case%s left out because of an invalid scenario", cases->invalid,
                 cases->invalid == 1 ? " is" : "s are");
    note_overlap(cases);
    note_warnings(cases);
    if (cases->count > 0)
        return STATUS_OK;
    if (cases->invalid > 0)
        return error_set(error, STATUS_INVALID, "none of the cases is valid");
    char name[SWEEP_CASE_NAME_SIZE];
    return error_set(error, STATUS_INVALID,
                     "--only '%s' --shard %u/%u: no case of the sweep %s is chosen: expected a "
                     "pattern of names like '%s'",
                     choice->only != NULL ? choice->only : "*", choice->shard, choice->shard_count,
                     sweep_name(cases->sweep), sweep_case_name(cases->sweep, 0, name));
}

// The cases on their way into the journal.
struct intake {
    struct run_cases cases;
    struct scenario scenario; // of the case at hand
    const char **values;
};

static enum status next_search(void *user, struct journal_search *search, bool *more,
                               struct error *error)
{
    struct intake *intake = user;
    const struct sweep *sweep = intake->cases.sweep;
    uint32_t index;
    scenario_fini(&intake->scenario);
    enum status status = run_cases_next(&intake->cases, &index, &intake->scenario, error);
    *more = status == STATUS_OK && index != UINT32_MAX;
    if (!*more)
        return status;
    for (uint32_t c = 0; c < sweep_column_count(sweep); c++)
        intake->values[c] = sweep_value(sweep, index, c);
    *search = record_of(&intake->scenario);
    search->index = intake->cases.count - 1;
    search->values = intake->values;
    sweep_case_name(sweep, index, search->name);
    return STATUS_OK;
}

enum status run_create_sweep(struct run *run, const char *directory, const struct sweep *sweep,
                             const struct run_choice *choice, int threads, int64_t now_ns,
                             struct error *error)
{
    _Static_assert((int)SWEEP_CASE_NAME_SIZE <= (int)JOURNAL_NAME_SIZE, "raise JOURNAL_NAME_SIZE");
    enum status status = begin(run, directory, sweep_name(sweep), threads, now_ns, error);
    if (status != STATUS_OK)
        return status;
    const uint32_t columns = sweep_column_count(sweep);
    struct intake intake = {.values = g_new0(const char *, columns)};
    run_cases_init(&intake.cases, sweep, choice);
    status = journal_create_from(&run->journal, run->directory, &run->record, sweep_columns(sweep),
                                 columns, next_search, &intake, error);
    if (status == STATUS_OK)
        status = run_cases_check(&intake.cases, error);
    scenario_fini(&intake.scenario);
    g_free(intake.values);
    if (status != STATUS_OK) {
        discard(run);
        return status;
    }
    run->record.search_count = intake.cases.count;
    make_room(run);
    limit_choice(run, choice->stop_after);
    return STATUS_OK;
}

// ---- Taking up again ----

static bool journal_present(const char *directory)
{
    char *path = g_build_filename(directory, "run.db", NULL);
    const bool present = g_file_test(path, G_FILE_TEST_EXISTS);
    g_free(path);
    return present;
}

static bool found_corridors(const char *status)
{
    return strcmp(status, protocol_status_name(SEARCH_STATUS_NO_GOOD_DESIGN)) != 0;
}

// A search as the earlier sessions left it.
struct taking_up {
    struct run *run;
    const struct run_choice *choice;
};

static enum status take_standing(void *user, const struct journal_standing *standing,
                                 struct error *error)
{
    (void)error;
    const struct taking_up *taking_up = user;
    struct run *run = taking_up->run;
    if (standing->finished) {
        run->standings[standing->index] = SEARCH_STANDING_DONE;
        run->done_count++;
        run->found_count += found_corridors(standing->status);
    }
    if (standing->finished || !choose_name(taking_up->choice, standing->name)) {
        run->chosen[standing->index] = 0;
        run->chosen_count--;
    }
    return STATUS_OK;
}

static enum status check_resumable(const struct run *run, struct error *error)
{
    if (run->record.state == RUN_STATE_DONE)
        return error_set(error, STATUS_REFUSED, "this run is done: see it with 'sobox-report %s'",
                         run->directory);
    if (strcmp(run->record.version, SOBOX_VERSION) != 0)
        return error_set(error, STATUS_REFUSED,
                         "begun by sobox %s, which may search otherwise than this one (%s): "
                         "continue it with that version",
                         run->record.version, SOBOX_VERSION);
    return STATUS_OK;
}

enum status run_resume(struct run *run, const char *directory, const struct run_choice *choice,
                       int threads, int64_t now_ns, struct error *error)
{
    *run = (struct run){.started_ns = now_ns, .directory = g_strdup(directory), .threads = threads};
    if (!journal_present(directory)) {
        run_fini(run);
        return error_set(
            error, STATUS_INVALID,
            "%s: there is no run to continue: expected a run folder, which has a run.db",
            directory);
    }
    struct taking_up taking_up = {.run = run, .choice = choice};
    enum status status = journal_open(&run->journal, directory, JOURNAL_RESUME, error);
    if (status != STATUS_OK) {
        run_fini(run);
        return status; // names the folder
    }
    status = journal_read_run(run->journal, &run->record, error);
    if (status == STATUS_OK)
        status = check_resumable(run, error);
    if (status == STATUS_OK) {
        make_room(run);
        status = journal_read_standings(run->journal, take_standing, &taking_up, error);
    }
    if (status == STATUS_OK && run->chosen_count == 0 && choice->only != NULL)
        status =
            error_set(error, STATUS_INVALID,
                      "--only '%s' matches no search that is missing in this run", choice->only);
    if (status != STATUS_OK) {
        error_wrap(error, "%s", directory);
        run_fini(run);
        return status;
    }
    limit_choice(run, choice->stop_after);
    return STATUS_OK;
}

// ---- A search's life ----

bool run_waiting(struct run *run, uint32_t *index)
{
    while (run->next < run->record.search_count &&
           (run->standings[run->next] != SEARCH_STANDING_WAITING || run->chosen[run->next] == 0))
        run->next++;
    *index = run->next;
    return run->next < run->record.search_count;
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

static void search_release(struct run_search *search)
{
    search_free(search->search);
    scenario_fini(&search->scenario);
    box_fini(&search->sampled);
    g_clear_pointer(&search->text, g_byte_array_unref);
    g_free(search->verdicts);
    g_free(search);
}

// The scenario comes from the journal, as it does for whoever looks at the run later.
static enum status search_read(struct run *run, struct run_search *search, struct error *error)
{
    struct journal_search record;
    enum status status = journal_read_search(run->journal, search->index, &record, error);
    if (status != STATUS_OK)
        return status;
    char *source = g_strdup_printf("%s/run.db, search %u", run->directory, search->index);
    status = scenario_read_text(&search->scenario, source, record.text, record.text_size, NULL, 0,
                                error);
    g_free(source);
    journal_search_fini(&record);
    return status;
}

enum status run_open(struct run *run, uint32_t index, int64_t now_ns, struct error *error)
{
    assert(run->standings[index] == SEARCH_STANDING_WAITING);
    struct run_search *search = g_new0(struct run_search, 1);
    *search = (struct run_search){.index = index, .started_ns = now_ns};
    enum status status = search_read(run, search, error);
    if (status == STATUS_OK) {
        const struct scenario *scenario = &search->scenario;
        search->search = search_create(scenario, scenario->search.seed, run->threads);
        search->text = g_byte_array_new();
        box_init(&search->sampled, scenario->design_space.count);
        status = journal_read_steps(run->journal, index, replay, search->search, error);
    }
    if (status != STATUS_OK) {
        error_wrap(error, "%s", run->directory);
        search_release(search);
        // A journal that cannot even say so has told why it could not be read.
        (void)!journal_fail_search(run->journal, index, NULL);
        run->standings[index] = SEARCH_STANDING_FAILED;
        run->failed_count++;
        run->finished_count++;
        return status;
    }
    run->open[index] = search;
    run->standings[index] = SEARCH_STANDING_OPEN;
    run->open_count++;
    return STATUS_OK;
}

// Whether the step of search.round is too coarse for some interval of the box.
static bool is_coarse(const struct scenario *scenario, const struct search_result *result)
{
    for (uint32_t v = 0; v < result->box->count; v++) {
        if (result->status != SEARCH_STATUS_NO_GOOD_DESIGN &&
            !scenario_is_rounded(scenario, result->box, v))
            return true;
    }
    return false;
}

static enum status write_result(struct run *run, struct run_search *search, int64_t now_ns,
                                struct error *error)
{
    struct search_result result;
    search_result(search->search, &result);
    // A run of one search has taken as long as its sessions; a case of a sweep as long as this one.
    const int64_t before_ns = run->record.search_count == 1 ? run->record.elapsed_ns : 0;
    struct journal_search record = {
        .index = search->index,
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
        .wall_ns = before_ns + now_ns - search->started_ns,
        .digest = result.digest,
    };
    if (result.holders != NULL) {
        record.holders = (uint8_t *)result.holders; // borrowed for the call
        record.gains = (double *)result.gains;
        record.gain_count = search->scenario.constraint_count;
    }
    if (result.worst != NULL)
        record.worst = (struct box){.count = result.box->count,
                                    .lower = (double *)result.worst, // borrowed as well
                                    .upper = (double *)result.worst};
    g_strlcpy(record.status, protocol_status_name(result.status), sizeof record.status);
    if (result.status == SEARCH_STATUS_NO_GOOD_DESIGN) {
        uint32_t blocking = result.blocking_constraint;
        scenario_outcome_name(&search->scenario, search->scenario.constraints[blocking].outcome,
                              record.blocking_constraint);
    }
    enum status status = journal_finish_search(run->journal, &record, error);
    if (status == STATUS_OK) {
        run->standings[search->index] = SEARCH_STANDING_DONE;
        run->done_count++;
        run->finished_count++;
        run->found_count += found_corridors(record.status);
        run->coarse_count += is_coarse(&search->scenario, &result);
    }
    return status;
}

enum status run_next(struct run *run, uint32_t index, int64_t now_ns, bool *wanted,
                     struct error *error)
{
    struct run_search *search = run->open[index];
    *wanted = false;
    search->active = false;
    if (run->standings[index] == SEARCH_STANDING_DONE)
        return STATUS_OK;
    if (!search_request(search->search, &search->request))
        return write_result(run, search, now_ns, error);
    box_assign(&search->sampled, search->request.box);
    g_byte_array_set_size(search->text, 0);
    box_text_put(search->text, search->request.box, search->request.sampling.moves);
    search->box = digest_of(search->text->data, search->text->len);
    search->verdicts = g_renew(struct verdict, search->verdicts, search->request.sampling.samples);
    search->active = *wanted = true;
    return STATUS_OK;
}

void run_trim(struct run_search *search)
{
    search_complete(search->search, search->verdicts);
}

enum status run_record(struct run *run, uint32_t index, struct error *error)
{
    const struct run_search *search = run->open[index];
    const struct search_step *step = search_last_step(search->search);
    struct journal_step record = {
        .search = index,
        .step = step->step,
        .samples = step->samples,
        .good = step->good,
        .growth = step->growth,
        .log_volume = step->log_volume,
        .box = &search->sampled,
        .detail = search->request.detail,
        .verdicts = search->verdicts,
        .sampling = search->request.sampling.method,
    };
    g_strlcpy(record.phase, protocol_phase_name(step->phase), sizeof record.phase);
    run->steps++;
    return journal_append(run->journal, &record, error);
}

void run_close(struct run *run, uint32_t index)
{
    assert(run->standings[index] == SEARCH_STANDING_DONE);
    search_release(run->open[index]);
    run->open[index] = NULL;
    run->open_count--;
}

bool run_finished(const struct run *run)
{
    return run->finished_count == run->chosen_count;
}

// ---- Ending ----

int64_t run_elapsed_ns(const struct run *run, int64_t now_ns)
{
    return run->record.elapsed_ns + now_ns - run->started_ns;
}

enum status run_end(struct run *run, enum run_state state, int64_t now_ns, struct error *error)
{
    return journal_state(run->journal, state, run_elapsed_ns(run, now_ns), error);
}

void run_fini(struct run *run)
{
    for (uint32_t i = 0; run->open != NULL && i < run->record.search_count; i++) {
        if (run->open[i] != NULL)
            search_release(run->open[i]);
    }
    g_free(run->open);
    g_free(run->standings);
    g_free(run->chosen);
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
    if (run->folder_made)
        run_folder_remove(run->directory);
}
