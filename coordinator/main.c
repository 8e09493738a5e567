// sobox-coordinator: reads a scenario or a sweep, runs its searches on the workers, writes the run
// folder. Or it evaluates a table of designs on them.

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "common/base/wait_policy.h"
#include "common/numeric/identity.h"
#include "common/scenario/plausibility.h"
#include "common/scenario/scenario_read.h"
#include "common/scenario/sweep.h"
#include "common/wire/key.h"
#include "coordinator/report/report.h"
#include "coordinator/runtime/children.h"
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

static const char program_summary[] =
    "Finds the widest force-deformation corridors in which every design of the scenario is safe,\n"
    "and writes them, with the journal of the search, into a run folder.\n"
    "\n"
    "Without --url and --workers a worker runs inside this process on all cores, and nothing\n"
    "touches the network. A file with the key `sweep` is a sweep: a search for each of its cases.\n"
    "With --evaluate nothing is searched: the designs of a table are simulated, and their "
    "outcomes\n"
    "written into outcomes.csv in the run folder.";

static const char program_description[] =
    "Examples:\n"
    "  sobox-coordinator sedan-two-springs.yaml\n"
    "  sobox-coordinator sedan-two-springs.yaml --set response=rotating --out rotating\n"
    "  sobox-coordinator sedan-two-springs.yaml --workers 3\n"
    "  sobox-coordinator sedan-two-springs.yaml --url 'udpm://239.255.76.67:7667?ttl=1'\n"
    "  sobox-coordinator --resume runs/sedan-two-springs\n"
    "  sobox-coordinator masses.yaml --dry-run\n"
    "  sobox-coordinator masses.yaml --only 'mass=1500,*'\n"
    "  sobox-coordinator --evaluate designs.csv sedan-two-springs.yaml --out study\n"
    "  sobox-coordinator --new-key sobox.key\n"
    "\n"
    "Exit status: 0 done; 1 failed while running; 2 usage or invalid input; 3 finished, but no "
    "good\n"
    "design was found; 130 interrupted (continue with --resume).";

enum {
    WORKERS_MAX = 256,  // processes of one machine
    THREADS_MAX = 1024, // of one process
    MTU_NOT_GIVEN = -1,
    // Between processes of one machine frames have no say. Of this size six fit the receive buffer
    // that a kernel grants everyone, and larger ones make nothing faster.
    MTU_LOCAL = 32000, // [bytes]
};

struct options {
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
    struct run_choice choice; // from only, shard, stop_after and keep_going
    int stop_after;
    gboolean keep_going;
    gboolean dry_run;
    int workers;
    int threads;
    int mtu;
    gboolean quiet;
    gboolean verbose;
    gboolean version;
};

static void options_fini(struct options *options)
{
    g_free(options->scenario);
    g_free(options->out);
    g_free(options->resume);
    g_free(options->url);
    g_free(options->key_file);
    g_free(options->new_key);
    g_free(options->seed);
    g_free(options->only);
    g_free(options->shard);
    g_free(options->evaluate);
    g_free(options->outcomes);
    g_strfreev(options->set);
}

static enum status check_ranges(const struct options *options, struct error *error)
{
    if (options->workers < 0 || options->workers > WORKERS_MAX)
        return error_set(error, STATUS_INVALID, "--workers %d: expected 0 to %d", options->workers,
                         WORKERS_MAX);
    if (options->threads < 0 || options->threads > THREADS_MAX)
        return error_set(error, STATUS_INVALID, "--threads %d: expected 0 (all processors) to %d",
                         options->threads, THREADS_MAX);
    if (options->mtu != MTU_NOT_GIVEN &&
        (options->mtu < WIRE_MTU_DEFAULT || options->mtu > WIRE_MTU_MAX))
        return error_set(error, STATUS_INVALID, "--mtu %d: expected %d to %d bytes", options->mtu,
                         WIRE_MTU_DEFAULT, WIRE_MTU_MAX);
    return STATUS_OK;
}

// "2/5" is every fifth case from the second one on.
static bool parse_shard(const char *text, struct run_choice *choice)
{
    unsigned shard, count;
    int length = 0;
    if (text[0] == '-' || text[0] == '+' || strpbrk(text, " \t") != NULL ||
        sscanf(text, "%6u/%6u%n", &shard, &count, &length) != 2 || text[length] != '\0' ||
        shard < 1 || shard > count)
        return false;
    choice->shard = shard;
    choice->shard_count = count;
    return true;
}

static enum status check_choice(struct options *options, struct error *error)
{
    struct run_choice *choice = &options->choice;
    *choice = (struct run_choice){.only = options->only,
                                  .shard = 1,
                                  .shard_count = 1,
                                  .stop_after = (uint32_t)options->stop_after,
                                  .keep_going = options->keep_going};
    if (options->stop_after < 0)
        return error_set(error, STATUS_INVALID, "--stop-after %d: expected 1 search or more",
                         options->stop_after);
    if (options->shard != NULL && !parse_shard(options->shard, choice))
        return error_set(error, STATUS_INVALID,
                         "--shard %s: expected which part of how many, for instance 1/2",
                         options->shard);
    return STATUS_OK;
}

// Options that only a sweep can honour, whatever they are given with.
static const char *sweep_option(const struct options *options)
{
    return options->only != NULL      ? "--only"
           : options->shard != NULL   ? "--shard"
           : options->stop_after != 0 ? "--stop-after"
           : options->keep_going      ? "--keep-going"
           : options->dry_run         ? "--dry-run"
                                      : NULL;
}

static enum status check_evaluate(const struct options *options, struct error *error)
{
    if (options->outcomes != NULL && (options->evaluate == NULL || options->resume != NULL))
        return error_set(error, STATUS_INVALID,
                         "--outcomes goes with --evaluate, when it is begun");
    if (options->evaluate == NULL)
        return STATUS_OK;
    if (options->seed != NULL || sweep_option(options) != NULL)
        return error_set(error, STATUS_INVALID, "--evaluate searches nothing: it goes without %s",
                         options->seed != NULL ? "--seed" : sweep_option(options));
    if (options->scenario != NULL && sweep_detect(options->scenario))
        return error_set(error, STATUS_INVALID,
                         "--evaluate goes with a scenario, and %s is a sweep", options->scenario);
    return STATUS_OK;
}

static enum status check_together(const struct options *options, struct error *error)
{
    if (options->new_key != NULL) {
        if (options->scenario != NULL || options->resume != NULL || options->key_file != NULL ||
            options->evaluate != NULL)
            return error_set(error, STATUS_INVALID,
                             "--new-key makes a key and ends: it goes without a scenario, "
                             "--evaluate, --resume and --key-file");
        return STATUS_OK;
    }
    if (options->resume != NULL) {
        if (options->scenario != NULL || options->out != NULL || options->seed != NULL ||
            options->set != NULL || options->shard != NULL || options->keep_going ||
            options->dry_run)
            return error_set(error, STATUS_INVALID,
                             "--resume continues a run as it was begun: it goes without a "
                             "scenario, --out, --seed, --set, --shard, --keep-going and --dry-run");
        return STATUS_OK;
    }
    if (options->scenario == NULL)
        return error_set(error, STATUS_INVALID,
                         "no scenario: expected sobox-coordinator SCENARIO.yaml (see --help)");
    // What it holds is looked at before it is read, and of a pipe nothing is left by then.
    GStatBuf file;
    if (g_stat(options->scenario, &file) == 0 && S_ISFIFO(file.st_mode))
        return error_set(error, STATUS_INVALID,
                         "%s:1:1: expected a file, found a pipe, which can be read only once",
                         options->scenario);
    if (sweep_option(options) != NULL && !sweep_detect(options->scenario)) {
        // A file that is no YAML at all is better told by its own error.
        struct scenario scenario;
        enum status status = scenario_read_file(&scenario, options->scenario, NULL, 0, error);
        if (status == STATUS_OK)
            status = error_set(error, STATUS_INVALID, "%s goes with a sweep, and %s is a scenario",
                               sweep_option(options), options->scenario);
        scenario_fini(&scenario);
        return status;
    }
    return STATUS_OK;
}

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    *options = (struct options){.mtu = MTU_NOT_GIVEN};
    // FILENAME takes the bytes as they come. STRING would convert them from the alphabet of the
    // locale, and programs that write the same numbers everywhere set none.
    const GOptionEntry entries[] = {
        {"out", 'o', 0, G_OPTION_ARG_FILENAME, &options->out,
         "Run folder, absent or empty (default: the first free of runs/NAME, runs/NAME-2, ...)",
         "DIR"},
        {"set", 's', 0, G_OPTION_ARG_FILENAME_ARRAY, &options->set,
         "Override a key of the scenario, for instance response=rotating or "
         "springs.front.force_y.upper=2e5; may be repeated",
         "KEY.PATH=VALUE"},
        {"seed", 0, 0, G_OPTION_ARG_STRING, &options->seed,
         "Seed of the random numbers: short for --set search.seed=SEED", "SEED"},
        {"workers", 'w', 0, G_OPTION_ARG_INT, &options->workers,
         "Start N worker processes on this machine", "N"},
        {"url", 'u', 0, G_OPTION_ARG_STRING, &options->url,
         "Use the workers that listen on this LCM URL, for instance "
         "udpm://239.255.76.67:7667?ttl=1, or that share this hub, tcpq://ADDRESS:PORT",
         "LCM_URL"},
        {"key-file", 'k', 0, G_OPTION_ARG_FILENAME, &options->key_file,
         "Seal all messages with the key in this file, the same for all workers and monitors",
         "FILE"},
        {"new-key", 0, 0, G_OPTION_ARG_FILENAME, &options->new_key,
         "Make a key, write it to this new file, and end", "FILE"},
        {"threads", 't', 0, G_OPTION_ARG_INT, &options->threads,
         "Threads of this process and of each worker it starts (default: all processors)", "N"},
        {"mtu", 0, 0, G_OPTION_ARG_INT, &options->mtu,
         "Greatest message in bytes, the same for all workers (default: 1400; for --evaluate "
         "without "
         "--url 32000)",
         "BYTES"},
        {"only", 0, 0, G_OPTION_ARG_FILENAME, &options->only,
         "Of a sweep run the cases whose names match, for instance 'mass=1500,*'", "PATTERN"},
        {"shard", 0, 0, G_OPTION_ARG_STRING, &options->shard,
         "Of a sweep run every N-th case from the I-th on, to split it over coordinators", "I/N"},
        {"stop-after", 0, 0, G_OPTION_ARG_INT, &options->stop_after,
         "Of a sweep run N searches now; --resume runs the rest", "N"},
        {"keep-going", 0, 0, G_OPTION_ARG_NONE, &options->keep_going,
         "Leave out cases of a sweep whose scenario is invalid, and say which", NULL},
        {"dry-run", 0, 0, G_OPTION_ARG_NONE, &options->dry_run,
         "Print the cases of a sweep, estimate its time from a short measurement, and end", NULL},
        {"evaluate", 'e', 0, G_OPTION_ARG_FILENAME, &options->evaluate,
         "Evaluate the designs of this table, a row each, a column a variable as result.json names "
         "them; - is standard input",
         "DESIGNS.csv"},
        {"outcomes", 0, 0, G_OPTION_ARG_STRING, &options->outcomes,
         "With --evaluate write these only, for instance s_L,AbWAP (default: all)", "NAMES"},
        {"resume", 'r', 0, G_OPTION_ARG_FILENAME, &options->resume,
         "Continue the run in this folder, to the same bits", "DIR"},
        {"quiet", 'q', 0, G_OPTION_ARG_NONE, &options->quiet, "Show the result and errors only",
         NULL},
        {"verbose", 'v', 0, G_OPTION_ARG_NONE, &options->verbose, "Show every decision", NULL},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_program program = {
        .argument = "SCENARIO.yaml",
        .summary = program_summary,
        .description = program_description,
        .entries = entries,
    };
    struct options_common common;
    enum status status = options_read(&program, argc, argv, &common, error);
    options->version = common.version;
    options->scenario = common.argument;
    if (status != STATUS_OK || options->version)
        return status;
    status = check_ranges(options, error);
    if (status == STATUS_OK)
        status = check_choice(options, error);
    if (status == STATUS_OK)
        status = check_evaluate(options, error);
    if (status == STATUS_OK)
        status = check_together(options, error);
    return status;
}

static enum status begin_scenario(struct run *run, const struct options *options,
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
static enum status begin_sweep(struct run *run, const struct options *options,
                               const GPtrArray *overrides, int threads, struct error *error)
{
    struct sweep *sweep;
    enum status status = sweep_read_file(
        &sweep, options->scenario, (const char *const *)overrides->pdata, overrides->len, error);
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

// Begins a run of the scenario or sweep, or takes up the one in the folder to be resumed.
static enum status open_run(struct run *run, const struct options *options, int threads,
                            struct error *error)
{
    *run = (struct run){0};
    if (options->resume != NULL)
        return run_resume(run, options->resume, &options->choice, threads, clock_monotonic_ns(),
                          error);

    GPtrArray *overrides = g_ptr_array_new();
    for (char **set = options->set; set != NULL && *set != NULL; set++)
        g_ptr_array_add(overrides, *set);
    char *seed = options->seed ? g_strdup_printf("search.seed=%s", options->seed) : NULL;
    if (seed != NULL)
        g_ptr_array_add(overrides, seed);
    enum status status = sweep_detect(options->scenario)
                             ? begin_sweep(run, options, overrides, threads, error)
                             : begin_scenario(run, options, overrides, threads, error);
    g_ptr_array_free(overrides, TRUE);
    g_free(seed);
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

static uint32_t mtu_of(const struct options *options, const struct job *job)
{
    if (options->mtu != MTU_NOT_GIVEN)
        return (uint32_t)options->mtu;
    return job->evaluate != NULL && options->url == NULL ? MTU_LOCAL : WIRE_MTU_DEFAULT;
}

// Opens the wire the options ask for, with a worker of its own where there is no other, and runs.
static enum status run_on_wire(const struct job *job, const struct options *options, int threads,
                               const char *url, const struct key *key, struct children *children,
                               struct error *error)
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
static enum status run_with_workers(const struct job *job, const struct options *options,
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
    if (report_draw(directory, &(struct report_plot){.format = PICTURE_SVG}, &undrawn) != STATUS_OK)
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
    return run->found_count == 0 ? EXIT_STATUS_NO_GOOD_DESIGN : EXIT_STATUS_DONE;
}

static int run_scenario(const struct options *options, const struct key *key, struct error *error)
{
    const int threads = options->threads > 0 ? options->threads : (int)g_get_num_processors();
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
static enum status open_evaluation(struct evaluation *evaluation, const struct options *options,
                                   struct error *error)
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

static int run_evaluation(const struct options *options, const struct key *key, struct error *error)
{
    const int threads = options->threads > 0 ? options->threads : (int)g_get_num_processors();
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

static int run_with_key(const struct options *options, struct error *error)
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
    struct options options;
    struct error error = {0};
    log_start("sobox-coordinator", LOG_NORMAL);
    enum status status = options_parse(&options, argc, argv, &error);
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
    options_fini(&options);
    return exit_code;
}
