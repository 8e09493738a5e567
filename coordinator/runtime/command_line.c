#include "coordinator/runtime/command_line.h"

#include "common/base/options.h"
#include "common/scenario/scenario_read.h"
#include "common/scenario/sweep.h"
#include "common/wire/wire.h"

#include <glib.h>
#include <glib/gstdio.h>
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
    "written into outcomes.csv in the run folder. With --certify nothing is searched either: a "
    "box\n"
    "is certified as it is.";

static const char program_description[] =
    "Examples:\n"
    "  sobox-coordinator sedan-two-springs.yaml\n"
    "  sobox-coordinator sedan-two-springs.yaml --set response=rotating --out rotating\n"
    "  sobox-coordinator sedan-two-springs.yaml --workers 3\n"
    "  sobox-coordinator sedan-two-springs.yaml --url 'udpm://239.255.76.67:7667?ttl=1'\n"
    "  sobox-coordinator sedan-two-springs.yaml --seeds 10\n"
    "  sobox-coordinator --resume runs/sedan-two-springs\n"
    "  sobox-coordinator masses.yaml --dry-run\n"
    "  sobox-coordinator masses.yaml --only 'mass=1500,*'\n"
    "  sobox-coordinator --evaluate designs.csv sedan-two-springs.yaml --out study\n"
    "  sobox-coordinator --certify edited.csv sedan-two-springs.yaml\n"
    "  sobox-coordinator --new-key sobox.key\n"
    "\n"
    "Exit status: 0 done; 1 failed while running; 2 usage or invalid input; 3 finished, but no "
    "good\n"
    "design was found; 130 interrupted (continue with --resume).";

enum {
    WORKERS_MAX = 256,  // processes of one machine
    THREADS_MAX = 1024, // of one process
};

void command_line_fini(struct command_line *options)
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
    g_free(options->certify);
    g_free(options->round);
    g_strfreev(options->set);
}

static enum status check_ranges(const struct command_line *options, struct error *error)
{
    if (options->workers < 0 || options->workers > WORKERS_MAX)
        return error_set(error, STATUS_INVALID, "--workers %d: expected 0 to %d", options->workers,
                         WORKERS_MAX);
    if (options->seeds < 0 || options->seeds == 1 || options->seeds > SWEEP_CASE_MAX)
        return error_set(error, STATUS_INVALID, "--seeds %d: expected 2 to %d", options->seeds,
                         SWEEP_CASE_MAX);
    if (options->threads < 0 || options->threads > THREADS_MAX)
        return error_set(error, STATUS_INVALID, "--threads %d: expected 0 (all processors) to %d",
                         options->threads, THREADS_MAX);
    if (options->mtu != COMMAND_LINE_NO_MTU &&
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

static enum status check_choice(struct command_line *options, struct error *error)
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
static const char *sweep_option(const struct command_line *options)
{
    return options->only != NULL      ? "--only"
           : options->shard != NULL   ? "--shard"
           : options->stop_after != 0 ? "--stop-after"
           : options->keep_going      ? "--keep-going"
           : options->dry_run         ? "--dry-run"
                                      : NULL;
}

// Several seeds make a sweep of a scenario.
static enum status check_seeds(const struct command_line *options, struct error *error)
{
    const char *other = options->resume != NULL     ? "--resume"
                        : options->evaluate != NULL ? "--evaluate"
                        : options->certify != NULL  ? "--certify"
                                                    : NULL;
    if (options->seeds == 0)
        return STATUS_OK;
    if (other != NULL)
        return error_set(error, STATUS_INVALID, "--seeds begins searches: it goes without %s",
                         other);
    if (options->scenario != NULL && sweep_detect(options->scenario))
        return error_set(error, STATUS_INVALID,
                         "--seeds goes with a scenario, and %s is a sweep: see `replicates`",
                         options->scenario);
    return STATUS_OK;
}

static enum status check_certify(const struct command_line *options, struct error *error)
{
    if (options->certify == NULL || (options->evaluate == NULL && options->resume == NULL))
        return STATUS_OK;
    return error_set(error, STATUS_INVALID, "--certify begins a run of its own: it goes without %s",
                     options->evaluate != NULL ? "--evaluate" : "--resume");
}

static enum status check_evaluate(const struct command_line *options, struct error *error)
{
    if (options->outcomes != NULL && (options->evaluate == NULL || options->resume != NULL))
        return error_set(error, STATUS_INVALID,
                         "--outcomes goes with --evaluate, when it is begun");
    if (options->evaluate == NULL)
        return STATUS_OK;
    const char *other = options->seed != NULL    ? "--seed"
                        : options->round != NULL ? "--round"
                                                 : sweep_option(options);
    if (other != NULL)
        return error_set(error, STATUS_INVALID, "--evaluate searches nothing: it goes without %s",
                         other);
    if (options->scenario != NULL && sweep_detect(options->scenario))
        return error_set(error, STATUS_INVALID,
                         "--evaluate goes with a scenario, and %s is a sweep", options->scenario);
    return STATUS_OK;
}

static enum status check_together(const struct command_line *options, struct error *error)
{
    if (options->new_key != NULL) {
        if (options->scenario != NULL || options->resume != NULL || options->key_file != NULL ||
            options->evaluate != NULL || options->certify != NULL)
            return error_set(error, STATUS_INVALID,
                             "--new-key makes a key and ends: it goes without a scenario, "
                             "--evaluate, --certify, --resume and --key-file");
        return STATUS_OK;
    }
    if (options->resume != NULL) {
        if (options->scenario != NULL || options->out != NULL || options->seed != NULL ||
            options->round != NULL || options->set != NULL || options->shard != NULL ||
            options->keep_going || options->dry_run)
            return error_set(error, STATUS_INVALID,
                             "--resume continues a run as it was begun: it goes without a "
                             "scenario, --out, --seed, --round, --set, --shard, --keep-going and "
                             "--dry-run");
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
    if (sweep_option(options) != NULL && options->seeds == 0 && !sweep_detect(options->scenario)) {
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

enum status command_line_parse(struct command_line *options, int argc, char **argv,
                               struct error *error)
{
    *options = (struct command_line){.mtu = COMMAND_LINE_NO_MTU};
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
        {"seeds", 0, 0, G_OPTION_ARG_INT, &options->seeds,
         "Search with N seeds: the best box is the result, with the spread of each of its bounds",
         "N"},
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
        {"certify", 'c', 0, G_OPTION_ARG_FILENAME, &options->certify,
         "Search nothing: certify this box, a corridors.csv, which may have been edited, or a run "
         "folder, and find the worst design in it",
         "BOX"},
        {"round", 0, 0, G_OPTION_ARG_STRING, &options->round,
         "Round the bounds of the box inwards to multiples of this, for instance 10e3, and certify "
         "that box: short for --set search.round=STEP",
         "STEP"},
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
        status = check_seeds(options, error);
    if (status == STATUS_OK)
        status = check_certify(options, error);
    if (status == STATUS_OK)
        status = check_evaluate(options, error);
    if (status == STATUS_OK)
        status = check_together(options, error);
    return status;
}
