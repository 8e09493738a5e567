// sobox-coordinator: reads a scenario, runs its search on the workers, writes the run folder.

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/wait_policy.h"
#include "common/scenario/scenario_read.h"
#include "common/wire/key.h"
#include "coordinator/report/report.h"
#include "coordinator/runtime/children.h"
#include "coordinator/runtime/coordinator.h"
#include "coordinator/runtime/run.h"
#include "worker/runtime/worker.h"

#include <glib.h>
#include <sodium.h>
#include <stdio.h>
#include <string.h>

static const char program_summary[] =
    "Finds the widest force-deformation corridors in which every design of the scenario is safe,\n"
    "and writes them, with the journal of the search, into a run folder.\n"
    "\n"
    "Without --url and --workers a worker runs inside this process on all cores, and nothing\n"
    "touches the network.";

static const char program_description[] =
    "Examples:\n"
    "  sobox-coordinator sedan-two-springs.yaml\n"
    "  sobox-coordinator sedan-two-springs.yaml --set response=rotating --out rotating\n"
    "  sobox-coordinator sedan-two-springs.yaml --workers 3\n"
    "  sobox-coordinator sedan-two-springs.yaml --url 'udpm://239.255.76.67:7667?ttl=1'\n"
    "  sobox-coordinator --resume runs/sedan-two-springs\n"
    "  sobox-coordinator --new-key sobox.key\n"
    "\n"
    "Exit status: 0 done; 1 failed while running; 2 usage or invalid input; 3 finished, but no "
    "good\n"
    "design was found; 130 interrupted (continue with --resume).";

enum {
    WORKERS_MAX = 256,  // processes of one machine
    THREADS_MAX = 1024, // of one process
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
    if (options->mtu < WIRE_MTU_DEFAULT || options->mtu > WIRE_MTU_MAX)
        return error_set(error, STATUS_INVALID, "--mtu %d: expected %d to %d bytes", options->mtu,
                         WIRE_MTU_DEFAULT, WIRE_MTU_MAX);
    return STATUS_OK;
}

static enum status check_together(const struct options *options, struct error *error)
{
    if (options->new_key != NULL) {
        if (options->scenario != NULL || options->resume != NULL || options->key_file != NULL)
            return error_set(error, STATUS_INVALID,
                             "--new-key makes a key and ends: it goes without a scenario, --resume "
                             "and --key-file");
        return STATUS_OK;
    }
    if (options->resume != NULL) {
        if (options->scenario != NULL || options->out != NULL || options->seed != NULL ||
            options->set != NULL)
            return error_set(error, STATUS_INVALID,
                             "--resume continues a run as it was begun: it goes without a "
                             "scenario, --out, --seed and --set");
        return STATUS_OK;
    }
    if (options->scenario == NULL)
        return error_set(error, STATUS_INVALID,
                         "no scenario: expected sobox-coordinator SCENARIO.yaml (see --help)");
    return STATUS_OK;
}

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    *options = (struct options){.mtu = WIRE_MTU_DEFAULT};
    const GOptionEntry entries[] = {
        {"out", 'o', 0, G_OPTION_ARG_FILENAME, &options->out,
         "Run folder, absent or empty (default: the first free of runs/NAME, runs/NAME-2, ...)",
         "DIR"},
        {"set", 's', 0, G_OPTION_ARG_STRING_ARRAY, &options->set,
         "Override a key of the scenario, for instance response=rotating or "
         "springs.0.force_y.upper=2e5; may be repeated",
         "KEY.PATH=VALUE"},
        {"seed", 0, 0, G_OPTION_ARG_STRING, &options->seed,
         "Seed of the random numbers: short for --set search.seed=SEED", "SEED"},
        {"workers", 'w', 0, G_OPTION_ARG_INT, &options->workers,
         "Start N worker processes on this machine", "N"},
        {"url", 'u', 0, G_OPTION_ARG_STRING, &options->url,
         "Use the workers that listen on this LCM URL, for instance "
         "udpm://239.255.76.67:7667?ttl=1",
         "LCM_URL"},
        {"key-file", 'k', 0, G_OPTION_ARG_FILENAME, &options->key_file,
         "Seal all messages with the key in this file, the same for all workers and monitors",
         "FILE"},
        {"new-key", 0, 0, G_OPTION_ARG_FILENAME, &options->new_key,
         "Make a key, write it to this new file, and end", "FILE"},
        {"threads", 't', 0, G_OPTION_ARG_INT, &options->threads,
         "Threads of this process and of each worker it starts (default: all processors)", "N"},
        {"mtu", 0, 0, G_OPTION_ARG_INT, &options->mtu,
         "Greatest message in bytes, the same for all workers (default: 1400)", "BYTES"},
        {"resume", 'r', 0, G_OPTION_ARG_FILENAME, &options->resume,
         "Continue the run in this folder, to the same bits", "DIR"},
        {"quiet", 'q', 0, G_OPTION_ARG_NONE, &options->quiet, "Show errors only", NULL},
        {"verbose", 'v', 0, G_OPTION_ARG_NONE, &options->verbose, "Show every decision", NULL},
        {"version", 0, 0, G_OPTION_ARG_NONE, &options->version, "Print the version and end", NULL},
        G_OPTION_ENTRY_NULL,
    };
    GOptionContext *context = g_option_context_new("SCENARIO.yaml");
    g_option_context_set_summary(context, program_summary);
    g_option_context_set_description(context, program_description);
    g_option_context_add_main_entries(context, entries, NULL);
    GError *reason = NULL;
    enum status status = STATUS_OK;
    if (!g_option_context_parse(context, &argc, &argv, &reason)) {
        status = error_set(error, STATUS_INVALID, "%s (see --help)", reason->message);
        g_error_free(reason);
    } else if (argc > 2) {
        status = error_set(error, STATUS_INVALID, "%s: one scenario is expected, this is a second",
                           argv[2]);
    }
    g_option_context_free(context);
    if (argc > 1)
        options->scenario = g_strdup(argv[1]);
    if (status == STATUS_OK && !options->version)
        status = check_ranges(options, error);
    if (status == STATUS_OK && !options->version)
        status = check_together(options, error);
    return status;
}

// Begins a run of the scenario file, or takes up the one in the folder to be resumed.
static enum status open_run(struct run *run, const struct options *options, int threads,
                            struct error *error)
{
    if (options->resume != NULL)
        return run_resume(run, options->resume, threads, clock_monotonic_ns(), error);

    GPtrArray *overrides = g_ptr_array_new();
    for (char **set = options->set; set != NULL && *set != NULL; set++)
        g_ptr_array_add(overrides, *set);
    char *seed = options->seed ? g_strdup_printf("search.seed=%s", options->seed) : NULL;
    if (seed != NULL)
        g_ptr_array_add(overrides, seed);
    struct scenario scenario;
    enum status status = scenario_read_file(
        &scenario, options->scenario, (const char *const *)overrides->pdata, overrides->len, error);
    if (status == STATUS_OK)
        status = run_create(run, options->out, &scenario, threads, clock_monotonic_ns(), error);
    scenario_fini(&scenario);
    g_ptr_array_free(overrides, TRUE);
    g_free(seed);
    return status;
}

// The number that names this process on the network.
static uint64_t sender_number(void)
{
    uint64_t sender;
    do {
        randombytes_buf(&sender, sizeof sender);
        sender >>= 1; // positive as the signed number that travels
    } while (sender == 0);
    return sender;
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

// Opens the wire the options ask for, with a worker of its own where there is no other, and runs.
static enum status run_on_wire(struct run *run, const struct options *options, int threads,
                               const char *url, const struct key *key, struct children *children,
                               struct error *error)
{
    const uint64_t sender = sender_number();
    const struct wire_settings settings = {.url = url, .mtu = (uint32_t)options->mtu, .key = key};
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
            .url = url, .children = children, .open = options->url != NULL};
        status = coordinator_run(run, wire, sender, &coordinator, error);
    }
    worker_stop(worker);
    wire_close(wire);
    return status;
}

// Starts local workers first: LCM does not survive a fork.
static enum status run_with_workers(struct run *run, const struct options *options, int threads,
                                    const struct key *key, struct error *error)
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
            .mtu = (uint32_t)options->mtu,
            .verbose = options->verbose,
        };
        status = children_start(&children, &settings, error);
    }
    if (status == STATUS_OK)
        status = run_on_wire(run, options, threads, url, key, children, error);
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
    if (report_draw(directory, &(struct report_plot){.format = REPORT_SVG}, &undrawn) != STATUS_OK)
        log_note("no picture: %s", undrawn.text);
    return report_print(directory, stdout, error);
}

static bool found_nothing(const struct run *run)
{
    for (uint32_t i = 0; i < run->record.search_count; i++) {
        struct search_result result;
        search_result(run->searches[i].search, &result);
        if (result.status != SEARCH_STATUS_NO_GOOD_DESIGN)
            return false;
    }
    return true;
}

// Whether anything was sampled: a run that never began is removed, not left as an empty shell.
static bool began(const struct run *run)
{
    for (uint32_t i = 0; i < run->record.search_count; i++) {
        struct search_progress progress;
        search_progress(run->searches[i].search, &progress);
        if (progress.step > 0)
            return true;
    }
    return false;
}

static int run_scenario(const struct options *options, const struct key *key, struct error *error)
{
    const int threads = options->threads > 0 ? options->threads : (int)g_get_num_processors();
    struct run run;
    enum status status = open_run(&run, options, threads, error);
    if (status != STATUS_OK)
        return (int)status_exit(status);

    log_debug("run folder %s", run.directory);
    status = run_with_workers(&run, options, threads, key, error);
    int exit_code = (int)status_exit(status);
    if (status == STATUS_OK) {
        status = show(run.directory, error);
        exit_code = status == STATUS_OK && found_nothing(&run) ? EXIT_STATUS_NO_GOOD_DESIGN
                                                               : (int)status_exit(status);
    } else if (!began(&run) && options->resume == NULL) {
        run_abandon(&run);
    }
    run_fini(&run);
    return exit_code;
}

static int run_with_key(const struct options *options, struct error *error)
{
    struct key *key = NULL;
    if (options->key_file != NULL) {
        enum status status = key_read(&key, options->key_file, error);
        if (status != STATUS_OK)
            return (int)status_exit(status);
    }
    int exit_code = run_scenario(options, key, error);
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
    wait_policy_sleep(argv);
    struct options options;
    struct error error = {0};
    log_start("sobox-coordinator", LOG_NORMAL);
    enum status status = options_parse(&options, argc, argv, &error);
    int exit_code = (int)status_exit(status);
    if (status == STATUS_OK && options.version) {
        printf("sobox-coordinator %s\n", SOBOX_VERSION);
    } else if (status == STATUS_OK) {
        log_start("sobox-coordinator", options.quiet     ? LOG_QUIET
                                       : options.verbose ? LOG_DEBUG
                                                         : LOG_NORMAL);
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
