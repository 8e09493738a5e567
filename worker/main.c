// sobox-worker: a worker as a program of its own. Any number of them, on any machine, may come and
// go while a coordinator runs.
#include "common/base/arithmetic.h"
#include "common/base/error.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "common/base/wait_policy.h"
#include "common/numeric/digest.h"
#include "common/numeric/identity.h"
#include "common/wire/key.h"
#include "common/wire/survey.h"
#include "common/wire/url.h"
#include "worker/batch/fingerprint.h"
#include "worker/runtime/worker.h"

#include <glib-unix.h>
#include <glib.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#define URL_DEFAULT "udpm://239.255.76.67:7667?ttl=1"

enum { PARENT_INTERVAL_S = 1 };

struct options {
    char *url;
    char *key_file;
    long threads;
    long priority;
    long mtu;
    long parent; // 0: none
    gboolean check_network;
    gboolean quiet;
    gboolean verbose;
    gboolean version;
};

static const struct options_number number_options[] = {
    {"--threads", offsetof(struct options, threads), 0, WORKER_THREADS_MAX},
    {"--priority", offsetof(struct options, priority), 0, WORKER_PRIORITY_MAX},
    {"--mtu", offsetof(struct options, mtu), WIRE_MTU_DEFAULT, WIRE_MTU_MAX},
    {"--parent", offsetof(struct options, parent), 1, INT32_MAX},
    {0},
};

static enum status read_options(struct options *options, int argc, char **argv, struct error *error)
{
    const GOptionEntry entries[] = {
        {"url", 'u', 0, G_OPTION_ARG_STRING, &options->url,
         "Where the coordinator is (default: $SOBOX_URL, $LCM_DEFAULT_URL, " URL_DEFAULT ")",
         "URL"},
        {"key-file", 'k', 0, G_OPTION_ARG_FILENAME, &options->key_file,
         "Seal all messages with the coordinator's key, in this file", "FILE"},
        {"threads", 't', 0, G_OPTION_ARG_CALLBACK, options_number,
         "Threads that compute (default: 0, as many as there are cores)", "N"},
        {"priority", 0, 0, G_OPTION_ARG_CALLBACK, options_number,
         "Nice value added for them, 0 to 19 (default: 10)", "N"},
        {"mtu", 0, 0, G_OPTION_ARG_CALLBACK, options_number,
         "Greatest message, 1400 to 60000 bytes (default: 1400)", "BYTES"},
        {"parent", 0, 0, G_OPTION_ARG_CALLBACK, options_number,
         "End when this process, which must be the parent, ends", "PID"},
        {"check-network", 0, 0, G_OPTION_ARG_NONE, &options->check_network,
         "Say what works on this network and what does not, with the remedy, and end", NULL},
        {"quiet", 'q', 0, G_OPTION_ARG_NONE, &options->quiet, "Print errors only", NULL},
        {"verbose", 'v', 0, G_OPTION_ARG_NONE, &options->verbose, "Print every decision", NULL},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_program program = {
        .summary = "Evaluates designs for the coordinators on the network, on all cores, until it "
                   "is stopped.",
        .description = "Exit status: 0 stopped, or the network is good; 1 failed while running, or "
                       "it is not; 2 usage.",
        .entries = entries,
        .version = "Print version, protocol and kernel fingerprint",
        .numbers = number_options,
        .options = options,
    };
    struct options_common common;
    const enum status status = options_read(&program, argc, argv, &common, error);
    options->version = common.version;
    return status;
}

// An empty --url is refused by the wire, not taken for none: it comes from an unset variable of a
// script that meant another network than the default.
static const char *url_wanted(const struct options *options)
{
    if (options->url != NULL)
        return options->url;
    const char *urls[] = {g_getenv("SOBOX_URL"), g_getenv("LCM_DEFAULT_URL")};
    for (size_t i = 0; i < G_N_ELEMENTS(urls); i++) {
        if (urls[i] != NULL && urls[i][0] != '\0')
            return urls[i];
    }
    return URL_DEFAULT;
}

static gboolean stop_loop(gpointer loop)
{
    g_main_loop_quit(loop);
    return G_SOURCE_CONTINUE;
}

// ---- A worker that a coordinator started ends with it, even when that is killed ----

struct parent_watch {
    pid_t parent;
    GMainLoop *loop;
};

static gboolean check_parent(gpointer user)
{
    const struct parent_watch *watch = user;
    if (getppid() != watch->parent)
        g_main_loop_quit(watch->loop);
    return G_SOURCE_CONTINUE;
}

// The kernel's signal comes at once. But it is bound to the parent's thread that started this
// process, and lost if the parent has ended before it is asked for, so a glance now and each second
// goes with it.
static bool watch_parent(struct parent_watch *watch)
{
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    g_timeout_add_seconds(PARENT_INTERVAL_S, check_parent, watch);
    return getppid() == watch->parent;
}

// ---- The whole ----

static void print_version(void)
{
    char hex[DIGEST_HEX_SIZE];
    struct digest fingerprint = fingerprint_compute();
    printf("sobox-worker %s\nprotocol %d\nfingerprint %s\n", SOBOX_VERSION, WIRE_PROTOCOL,
           digest_hex(&fingerprint, hex));
}

static enum status open_wire(struct wire **wire, const struct options *options,
                             const struct key *key, uint64_t sender, struct error *error)
{
    struct wire_settings settings = wire_settings_default();
    settings.url = url_wanted(options);
    settings.mtu = (uint32_t)options->mtu;
    settings.key = key;
    if (g_str_has_prefix(settings.url, "memq:"))
        return error_set(error, STATUS_INVALID,
                         "--url: %s reaches nobody outside this process: expected "
                         "udpm://ADDRESS:PORT?ttl=N or tcpq://ADDRESS:PORT",
                         settings.url);
    return wire_open(wire, &settings, sender, error);
}

// ---- The network ----

static void tell_finding(void *user, enum survey_verdict verdict, const char *text)
{
    static const char *const labels[] = {
        [SURVEY_GOOD] = "good ", [SURVEY_NOTE] = "note ", [SURVEY_WRONG] = "WRONG"};
    (void)user;
    printf("%s  %s\n", labels[verdict], text);
    fflush(stdout);
}

static enum status check_network(const struct options *options, struct error *error)
{
    struct url url;
    struct key *key = NULL;
    enum status status = url_parse(&url, url_wanted(options), error);
    if (status == STATUS_OK && url.memq)
        status = error_set(error, STATUS_INVALID,
                           "--check-network: memq:// is no network: expected "
                           "udpm://ADDRESS:PORT?ttl=N or tcpq://ADDRESS:PORT");
    if (status == STATUS_OK && options->key_file != NULL)
        status = key_read(&key, options->key_file, error);
    if (status != STATUS_OK)
        return status;
    printf("%s\n", url_wanted(options));
    unsigned wrong = survey_network(&url, key, tell_finding, NULL);
    key_free(key);
    if (wrong > 0)
        return error_set(error, STATUS_NETWORK, "%u thing%s wrong with this network", wrong,
                         wrong == 1 ? " is" : "s are");
    return STATUS_OK;
}

static void say_hello(const struct options *options, const struct worker *worker,
                      const struct wire *wire, const struct key *key)
{
    char name[KEY_NAME_SIZE];
    log_note("listening on %s with %d thread%s", url_wanted(options), worker_threads(worker),
             worker_threads(worker) == 1 ? "" : "s");
    if (key != NULL)
        log_note("messages are sealed with the key %s", key_name(key, name));
    else if (wire_leaves_machine(wire))
        log_note("anyone on this network can take part: messages carry no key. Share one with "
                 "--key-file, use a network you trust, or ttl=0 to stay on this machine");
}

static void say_goodbye(const struct worker *worker)
{
    struct worker_counters counters;
    worker_counters(worker, &counters);
    log_note("ends after %" PRIu64 " batches, %" PRIu64 " samples, %.1f s of computing",
             counters.batches, counters.samples, (double)counters.busy_ns * 1e-9);
}

static enum status run(const struct options *options, struct error *error)
{
    struct wire *wire = NULL;
    struct worker *worker = NULL;
    struct key *key = NULL;
    const uint64_t sender = identity_random();
    GMainLoop *loop = g_main_loop_new(NULL, FALSE);
    struct parent_watch watch = {.parent = (pid_t)options->parent, .loop = loop};
    g_unix_signal_add(SIGINT, stop_loop, loop);
    g_unix_signal_add(SIGTERM, stop_loop, loop);
    enum status status = STATUS_OK;
    if (options->parent != 0 && !watch_parent(&watch))
        goto end;

    if (options->key_file != NULL)
        status = key_read(&key, options->key_file, error);
    if (status == STATUS_OK)
        status = open_wire(&wire, options, key, sender, error);
    if (status != STATUS_OK)
        goto end;
    struct worker_settings settings = worker_settings_default();
    settings.threads = (int)options->threads;
    settings.priority = (int)options->priority;
    settings.reopen = true;
    settings.notes = true;
    status = worker_start(&worker, wire, sender, &settings, error);
    if (status != STATUS_OK)
        goto end;
    say_hello(options, worker, wire, key);
    g_main_loop_run(loop);
    say_goodbye(worker);
end:
    worker_stop(worker);
    wire_close(wire);
    key_free(key);
    g_main_loop_unref(loop);
    return status;
}

int main(int argc, char **argv)
{
    streams_start();
    wait_policy_sleep(argv);
    arithmetic_start();
    log_start("sobox-worker", LOG_NORMAL);
    struct options options = {.priority = WORKER_PRIORITY_DEFAULT, .mtu = WIRE_MTU_DEFAULT};
    struct error error = {0};
    enum status status = read_options(&options, argc, argv, &error);
    if (status == STATUS_OK && options.version) {
        print_version();
    } else if (status == STATUS_OK) {
        log_start("sobox-worker", options_log_level(options.quiet, options.verbose));
        status = options.check_network ? check_network(&options, &error) : run(&options, &error);
    }
    if (status != STATUS_OK)
        log_error("%s", error.text);
    g_free(options.url);
    g_free(options.key_file);
    return (int)status_exit(status);
}
