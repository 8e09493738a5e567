// sobox-monitor: watches runs and workers through LCM. It only listens.

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/key.h"
#include "common/wire/source.h"
#include "common/wire/wire.h"
#include "monitor/feed/feed.h"
#include "monitor/terminal/lines.h"

#include <glib-unix.h>
#include <glib.h>
#include <sodium.h>
#include <stdio.h>
#include <unistd.h>

static const char program_summary[] =
    "Shows the runs and workers heard on an LCM network: a line a run and a second. It only\n"
    "listens: any number of monitors may be started and stopped at any time.";

static const char program_description[] =
    "Examples:\n"
    "  sobox-monitor --url 'udpm://239.255.76.67:7667?ttl=1'\n"
    "  sobox-monitor --json | jq .runs[0].searches[0].log_volume\n"
    "\n"
    "Without --url the environment variable SOBOX_URL names the network, and without that it is\n"
    "udpm://239.255.76.67:7667?ttl=1.\n"
    "\n"
    "Exit status: 0 stopped; 1 failed while running; 2 usage.";

struct options {
    char *url;
    char *key_file;
    gboolean json;
    gboolean version;
};

struct monitor {
    struct options options;
    struct feed feed;
    struct key *key;
    struct wire *wire;
    GMainLoop *loop;
    gboolean silence_said;
};

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    *options = (struct options){0};
    const GOptionEntry entries[] = {
        {"url", 'u', 0, G_OPTION_ARG_STRING, &options->url, "The LCM network to watch", "LCM_URL"},
        {"key-file", 'k', 0, G_OPTION_ARG_FILENAME, &options->key_file,
         "Open messages with the key in this file, where the runs have one", "FILE"},
        {"json", 'j', 0, G_OPTION_ARG_NONE, &options->json, "One JSON object a second", NULL},
        {"version", 0, 0, G_OPTION_ARG_NONE, &options->version, "Print the version and end", NULL},
        G_OPTION_ENTRY_NULL,
    };
    GOptionContext *context = g_option_context_new(NULL);
    g_option_context_set_summary(context, program_summary);
    g_option_context_set_description(context, program_description);
    g_option_context_add_main_entries(context, entries, NULL);
    GError *reason = NULL;
    enum status status = STATUS_OK;
    if (!g_option_context_parse(context, &argc, &argv, &reason)) {
        status = error_set(error, STATUS_INVALID, "%s (see --help)", reason->message);
        g_error_free(reason);
    } else if (argc > 1) {
        status = error_set(error, STATUS_INVALID, "%s: no argument is expected", argv[1]);
    }
    g_option_context_free(context);
    if (options->url == NULL) {
        const char *url = g_getenv("SOBOX_URL");
        options->url = g_strdup(url ? url : "udpm://239.255.76.67:7667?ttl=1");
    }
    return status;
}

static void heard(void *user, enum wire_kind kind, const void *message)
{
    struct monitor *monitor = user;
    const int64_t now_ns = clock_monotonic_ns();
    if (kind == WIRE_RUN_STATUS)
        feed_run_heard(&monitor->feed, message, now_ns);
    else if (kind == WIRE_SEARCH_STATUS)
        feed_search_heard(&monitor->feed, message, now_ns);
    else if (kind == WIRE_WORKER_STATUS)
        feed_worker_heard(&monitor->feed, message, now_ns);
}

static void count_own(struct monitor *monitor, int64_t now_ns)
{
    struct wire_counters counters;
    wire_counters(monitor->wire, &counters);
    feed_own_counted(&monitor->feed,
                     &(struct feed_own){
                         .received = counters.received,
                         .rejected = counters.rejected,
                         .foreign = counters.foreign,
                         .unopened = counters.unopened,
                         .lost = counters.lost,
                         .dropped = counters.dropped,
                         .buffer_size = counters.buffer_size,
                     },
                     now_ns);
}

static gboolean show(gpointer user)
{
    struct monitor *monitor = user;
    const int64_t now_ns = clock_monotonic_ns();
    count_own(monitor, now_ns);
    feed_tick(&monitor->feed, now_ns);
    if (monitor->options.json) {
        lines_print_json(&monitor->feed, now_ns, (double)clock_calendar_ns() / 1e9, stdout);
    } else if (lines_print(&monitor->feed, now_ns - CLOCK_SECOND_NS, now_ns, stdout) > 0) {
        monitor->silence_said = FALSE;
    } else if (!monitor->silence_said) {
        monitor->silence_said = TRUE;
        printf("no run is heard on %s; %u workers\n", monitor->options.url,
               monitor->feed.workers.entries->len);
    }
    fflush(stdout);
    return G_SOURCE_CONTINUE;
}

// Whoever reads the lines has gone: so does the monitor, also while it has nothing to say.
static gboolean unread(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)descriptor;
    (void)condition;
    g_main_loop_quit(((struct monitor *)user)->loop);
    return G_SOURCE_REMOVE;
}

static gboolean stop(gpointer user)
{
    g_main_loop_quit(((struct monitor *)user)->loop);
    return G_SOURCE_CONTINUE;
}

static enum status watch(struct monitor *monitor, struct error *error)
{
    struct wire_settings settings = wire_settings_default();
    settings.url = monitor->options.url;
    uint64_t sender = 0;
    randombytes_buf(&sender, sizeof sender);
    enum status status = STATUS_OK;
    if (monitor->options.key_file != NULL)
        status = key_read(&monitor->key, monitor->options.key_file, error);
    settings.key = monitor->key;
    if (status == STATUS_OK)
        status = wire_open(&monitor->wire, &settings, sender | 1, error);
    static const enum wire_kind kinds[] = {WIRE_RUN_STATUS, WIRE_SEARCH_STATUS, WIRE_WORKER_STATUS};
    for (size_t i = 0; status == STATUS_OK && i < G_N_ELEMENTS(kinds); i++)
        status = wire_subscribe(monitor->wire, kinds[i], heard, monitor, error);
    if (status != STATUS_OK)
        return status;
    wire_source_attach(monitor->wire);
    g_unix_signal_add(SIGINT, stop, monitor);
    g_unix_signal_add(SIGTERM, stop, monitor);
    g_unix_fd_add(STDOUT_FILENO, G_IO_ERR, unread, monitor);
    g_timeout_add(1000, show, monitor);
    g_main_loop_run(monitor->loop);
    show(monitor);
    wire_source_detach(monitor->wire);
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    struct error error = {0};
    struct monitor monitor = {0};
    log_start("sobox-monitor", LOG_NORMAL);
    signal(SIGPIPE, SIG_IGN);
    enum status status = options_parse(&monitor.options, argc, argv, &error);
    if (status == STATUS_OK && monitor.options.version) {
        printf("sobox-monitor %s\n", SOBOX_VERSION);
    } else if (status == STATUS_OK && sodium_init() < 0) {
        status = error_set(&error, STATUS_FAILED, "libsodium cannot start");
    } else if (status == STATUS_OK) {
        feed_init(&monitor.feed);
        monitor.loop = g_main_loop_new(NULL, FALSE);
        status = watch(&monitor, &error);
        wire_close(monitor.wire);
        key_free(monitor.key);
        g_main_loop_unref(monitor.loop);
        feed_fini(&monitor.feed);
    }
    if (status != STATUS_OK)
        log_failure(&error);
    g_free(monitor.options.url);
    g_free(monitor.options.key_file);
    return (int)status_exit(status);
}
