// sobox-coordinator: reads a scenario or a sweep, runs its searches on the workers, writes the run
// folder. Or it evaluates a table of designs on them.

#include "common/base/arithmetic.h"
#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/processors.h"
#include "common/base/streams.h"
#include "common/base/wait_policy.h"
#include "common/numeric/identity.h"
#include "common/scenario/plausibility.h"
#include "common/scenario/scenario_read.h"
#include "common/scenario/sweep.h"
#include "common/wire/key.h"
#include "coordinator/evaluation/corridors.h"
#include "coordinator/report/report.h"
#include "coordinator/runtime/children.h"
#include "coordinator/runtime/command_line.h"
#include "coordinator/runtime/coordinator.h"
#include "coordinator/runtime/evaluate.h"
#include "coordinator/runtime/preview.h"
#include "coordinator/runtime/run.h"
#include "worker/runtime/worker.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <inttypes.h>
#include <sodium.h>
#include <stdio.h>
#include <string.h>

enum {
    // Between processes of one machine frames have no say. Of this size six fit the receive buffer
    // that a kernel grants everyone, and larger ones make nothing faster.
    MTU_LOCAL = 32000, // [bytes]
};

static enum status begin_scenario(struct run *run, const struct command_line *options,
                                  const GPtrArray *overrides, int threads, struct error *error)
{
    struct scenario scenario;
    enum status status = scenario_read_file(
        &scenario, options->scenario, (const char *const *)overrides->pdata, overrides->len, error);
    if (status == STATUS_OK)
        plausibility_tell(&scenario);
    if (status == STATUS_OK)
        status = run_create(run, options->out, &scenario, threads, clock_monotonic_ns(), error);
    scenario_fini(&scenario);
    return status;
}

// With --dry-run nothing is begun, and `run` stays zeroed.
static enum status begin_sweep(struct run *run, const struct command_line *options,
                               const GPtrArray *overrides, int threads, struct error *error)
{
    struct sweep *sweep;
    const char *const *texts = (const char *const *)overrides->pdata;
    enum status status =
        options->seeds > 0
            ? sweep_of_seeds(&sweep, options->scenario, texts, overrides->len,
                             (uint32_t)options->seeds, error)
            : sweep_read_file(&sweep, options->scenario, texts, overrides->len, error);
    if (status != STATUS_OK)
        return status;
    if (options->dry_run)
        status = preview_print(sweep, &options->choice, threads, stdout, error);
    else
        status = run_create_sweep(run, options->out, sweep, &options->choice, threads,
                                  clock_monotonic_ns(), error);
    sweep_free(sweep);
    return status;
}

// The scenario of a sweep's first case: its springs are those of all cases, or their own say which
// differ.
static enum status read_first_case(struct scenario *scenario, const char *path,
                                   const GPtrArray *overrides, struct error *error)
{
    struct sweep *sweep;
    *scenario = (struct scenario){0};
    enum status status =
        sweep_read_file(&sweep, path, (const char *const *)overrides->pdata, overrides->len, error);
    if (status == STATUS_OK)
        status = sweep_scenario(sweep, 0, scenario, error);
    sweep_free(sweep);
    return status;
}

// Adds the box that is to be certified as one more key of the scenario, which says what its
// variables are.
static enum status add_box(GPtrArray *overrides, const struct command_line *options,
                           struct error *error)
{
    struct scenario scenario;
    struct box box;
    enum status status =
        sweep_detect(options->scenario)
            ? read_first_case(&scenario, options->scenario, overrides, error)
            : scenario_read_file(&scenario, options->scenario,
                                 (const char *const *)overrides->pdata, overrides->len, error);
    if (status == STATUS_OK)
        status = corridors_read(&box, &scenario, options->certify, error);
    scenario_fini(&scenario);
    if (status != STATUS_OK)
        return status;
    g_autofree char *text = corridors_text(&box);
    g_ptr_array_add(overrides, g_strconcat("search.box=", text, NULL));
    box_fini(&box);
    return STATUS_OK;
}

// Begins a run of the scenario or sweep, or takes up the one in the folder to be resumed.
static enum status open_run(struct run *run, const struct command_line *options, int threads,
                            struct error *error)
{
    *run = (struct run){0};
    if (options->resume != NULL)
        return run_resume(run, options->resume, &options->choice, threads, clock_monotonic_ns(),
                          error);

    GPtrArray *overrides = g_ptr_array_new_with_free_func(g_free);
    for (char **set = options->set; set != NULL && *set != NULL; set++)
        g_ptr_array_add(overrides, g_strdup(*set));
    if (options->seed != NULL)
        g_ptr_array_add(overrides, g_strconcat("search.seed=", options->seed, NULL));
    if (options->round != NULL)
        g_ptr_array_add(overrides, g_strconcat("search.round=", options->round, NULL));
    enum status status = options->certify != NULL ? add_box(overrides, options, error) : STATUS_OK;
    if (status == STATUS_OK)
        status = options->seeds > 0 || sweep_detect(options->scenario)
                     ? begin_sweep(run, options, overrides, threads, error)
                     : begin_scenario(run, options, overrides, threads, error);
    g_ptr_array_free(overrides, TRUE);
    return status;
}

// Says who can take part: those who have the key, or anyone.
static void note_key(const struct wire *wire, const struct key *key)
{
    char name[KEY_NAME_SIZE];
    if (key != NULL)
        log_debug("messages are sealed with the key %s", key_name(key, name));
    else if (wire_leaves_machine(wire))
        log_note("messages leave this machine without a key: anyone on this network can take part "
                 "and read along; see --key-file");
}

// What is to be carried out: one of the two.
struct job {
    struct run *run;
    struct evaluate *evaluate;
};

static uint32_t mtu_of(const struct command_line *options, const struct job *job)
{
    if (options->mtu != COMMAND_LINE_NO_MTU)
        return (uint32_t)options->mtu;
    return job->evaluate != NULL && options->url == NULL ? MTU_LOCAL : WIRE_MTU_DEFAULT;
}

// Opens the wire the options ask for, with a worker of its own where there is no other, and runs.
static enum status run_on_wire(const struct job *job, const struct command_line *options,
                               int threads, const char *url, const struct key *key,
                               struct children *children, struct error *error)
{
    const uint64_t sender = identity_random();
    const struct wire_settings settings = {.url = url, .mtu = mtu_of(options, job), .key = key};
    struct wire *wire = NULL;
    enum status status = wire_open(&wire, &settings, sender, error);
    if (status != STATUS_OK)
        return status;
    note_key(wire, key);

    struct worker *worker = NULL;
    if (options->url == NULL && children == NULL) {
        struct worker_settings own = worker_settings_default();
        own.threads = threads;
        status = worker_start(&worker, wire, sender, &own, error);
    }
    if (status == STATUS_OK) {
        const struct coordinator_settings coordinator = {
            .url = url, .children = children, .open = options->url != NULL, .threads = threads};
        status = job->evaluate != NULL ? evaluate_run(job->evaluate, wire, &coordinator, error)
                                       : coordinator_run(job->run, wire, &coordinator, error);
    }
    worker_stop(worker);
    wire_close(wire);
    return status;
}

// Starts local workers first: LCM does not survive a fork.
static enum status run_with_workers(const struct job *job, const struct command_line *options,
                                    int threads, const struct key *key, struct error *error)
{
    char *url = NULL;
    if (options->url != NULL)
        url = g_strdup(options->url);
    else
        url = options->workers > 0 ? children_private_url() : g_strdup("memq://");

    struct children *children = NULL;
    enum status status = STATUS_OK;
    if (options->workers > 0) {
        const struct children_settings settings = {
            .count = (uint32_t)options->workers,
            .url = url,
            .key_file = options->key_file,
            .threads = options->threads,
            .mtu = mtu_of(options, job),
            .verbose = options->verbose,
        };
        status = children_start(&children, &settings, error);
    }
    if (status == STATUS_OK)
        status = run_on_wire(job, options, threads, url, key, children, error);
    children_stop(children);
    g_free(url);
    return status;
}

// Writes what the journal holds as files and shows it.
static enum status show(const char *directory, struct error *error)
{
    enum status status = report_write(directory, error);
    if (status != STATUS_OK)
        return status;
    struct error undrawn = {0};
    if (report_draw(directory,
                    &(struct report_plot){.format = PICTURE_SVG, .search = REPORT_SEARCH_SHOWN},
                    &undrawn) != STATUS_OK)
        log_note("no picture: %s", undrawn.text);
    return report_print(directory, &(struct report_table){0}, stdout, error);
}

// What a session that ended as it should says with its exit status.
static int outcome(const struct run *run, struct error *error)
{
    const uint32_t waiting = run->record.search_count - run->done_count - run->failed_count;
    if (run->failed_count > 0)
        return (int)status_exit(error_set(
            error, STATUS_FAILED,
            "%u of %u searches could not be carried out; try again with 'sobox-coordinator "
            "--resume %s'",
            run->failed_count, run->record.search_count, run->directory));
    if (waiting > 0) {
        log_note("%u of %u searches wait; continue with 'sobox-coordinator --resume %s'", waiting,
                 run->record.search_count, run->directory);
        return EXIT_STATUS_DONE;
    }
    if (run->coarse_count > 0)
        return (int)status_exit(error_set(
            error, STATUS_FAILED,
            "search.round is too coarse: in %u of %u boxes an interval would lose its width and "
            "was left as it is, see `round` in %s/result.json; choose a smaller step",
            run->coarse_count, run->record.search_count, run->directory));
    return run->found_count == 0 ? EXIT_STATUS_NO_GOOD_DESIGN : EXIT_STATUS_DONE;
}

static int run_scenario(const struct command_line *options, const struct key *key,
                        struct error *error)
{
    const int threads =
        options->threads > 0 ? processors_limited(options->threads) : processors_usable();
    struct run run;
    enum status status = open_run(&run, options, threads, error);
    if (status != STATUS_OK || options->dry_run)
        return (int)status_exit(status);

    log_debug("run folder %s", run.directory);
    status = run_with_workers(&(struct job){.run = &run}, options, threads, key, error);
    int exit_code = (int)status_exit(status);
    if (status == STATUS_OK) {
        status = show(run.directory, error);
        exit_code = status == STATUS_OK ? outcome(&run, error) : (int)status_exit(status);
    } else if (run.steps == 0 && options->resume == NULL) {
        // A run that never began is removed, not left as an empty shell.
        run_abandon(&run);
    }
    run_fini(&run);
    return exit_code;
}

// Begins an evaluation, or takes up the one in the folder to be resumed, perhaps with a table that
// has moved.
static enum status open_evaluation(struct evaluation *evaluation,
                                   const struct command_line *options, struct error *error)
{
    if (options->resume != NULL) {
        enum status status =
            evaluation_resume(evaluation, options->resume, clock_monotonic_ns(), error);
        if (status == STATUS_OK && options->evaluate != NULL) {
            g_free(evaluation->designs);
            evaluation->designs = g_strdup(options->evaluate);
        }
        return status;
    }
    struct scenario scenario;
    guint overrides = options->set != NULL ? g_strv_length(options->set) : 0;
    enum status status = scenario_read_file(&scenario, options->scenario,
                                            (const char *const *)options->set, overrides, error);
    if (status == STATUS_OK)
        plausibility_tell(&scenario);
    if (status == STATUS_OK)
        status = evaluation_create(evaluation, options->out, &scenario, options->evaluate,
                                   options->outcomes, clock_monotonic_ns(), error);
    scenario_fini(&scenario);
    return status;
}

static void print_evaluation(const struct evaluation *evaluation)
{
    const double designs = (double)MAX(evaluation->rows, 1);
    printf("%s: %" PRIu64 " designs, %" PRIu64 " good (%.3g %%)", evaluation->scenario.name,
           evaluation->rows, evaluation->sums.good, 100 * (double)evaluation->sums.good / designs);
    if (evaluation->sums.non_finite > 0)
        printf(", %" PRIu64 " without a finite outcome", evaluation->sums.non_finite);
    printf("\noutcomes: %s/outcomes.csv\n", evaluation->directory);
}

static int run_evaluation(const struct command_line *options, const struct key *key,
                          struct error *error)
{
    const int threads =
        options->threads > 0 ? processors_limited(options->threads) : processors_usable();
    struct evaluation evaluation = {.file = -1};
    struct evaluate evaluate = {0};
    enum status status = open_evaluation(&evaluation, options, error);
    if (status != STATUS_OK)
        return (int)status_exit(status);
    status = evaluate_open(&evaluate, &evaluation, error);
    if (status == STATUS_OK)
        status =
            run_with_workers(&(struct job){.evaluate = &evaluate}, options, threads, key, error);
    evaluate_close(&evaluate);
    if (status == STATUS_OK)
        print_evaluation(&evaluation);
    else if (evaluation.rows == 0 && options->resume == NULL)
        evaluation_abandon(&evaluation); // it never began
    else if (status != STATUS_INTERRUPTED)
        log_note("%" PRIu64 " designs are evaluated; continue with 'sobox-coordinator --resume %s'",
                 evaluation.rows, evaluation.directory);
    evaluation_fini(&evaluation);
    return (int)status_exit(status);
}

static int run_with_key(const struct command_line *options, struct error *error)
{
    struct key *key = NULL;
    if (options->key_file != NULL) {
        enum status status = key_read(&key, options->key_file, error);
        if (status != STATUS_OK)
            return (int)status_exit(status);
    }
    const bool evaluation =
        options->resume != NULL ? evaluation_present(options->resume) : options->evaluate != NULL;
    int exit_code =
        evaluation ? run_evaluation(options, key, error) : run_scenario(options, key, error);
    key_free(key);
    return exit_code;
}

static int make_key(const char *path, struct error *error)
{
    enum status status = key_write_new(path, error);
    if (status == STATUS_OK)
        log_note("%s holds a new key: give it to every program with --key-file, and copy it only "
                 "by ways that keep a secret",
                 path);
    return (int)status_exit(status);
}

int main(int argc, char **argv)
{
    streams_start();
    wait_policy_sleep(argv);
    arithmetic_start();
    struct command_line options;
    struct error error = {0};
    log_start("sobox-coordinator", LOG_NORMAL);
    enum status status = command_line_parse(&options, argc, argv, &error);
    int exit_code = (int)status_exit(status);
    if (status == STATUS_OK && options.version) {
        printf("sobox-coordinator %s\n", SOBOX_VERSION);
    } else if (status == STATUS_OK) {
        log_start("sobox-coordinator", options_log_level(options.quiet, options.verbose));
        if (sodium_init() < 0)
            exit_code =
                (int)status_exit(error_set(&error, STATUS_FAILED, "libsodium cannot start"));
        else if (options.new_key != NULL)
            exit_code = make_key(options.new_key, &error);
        else
            exit_code = run_with_key(&options, &error);
    }
    if (error.status != STATUS_OK)
        log_failure(&error);
    command_line_fini(&options);
    return exit_code;
}
