// sobox-monitor: watches runs and workers through LCM, or a run through its journal, for a terminal
// and for browsers. It only listens; with a key it also asks unknown senders
// for a proof.

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "monitor/feed/feed.h"
#include "monitor/http/http.h"
#include "monitor/record/record.h"
#include "monitor/terminal/lines.h"
#include "monitor/terminal/screen.h"
#include "monitor/texts/texts.h"
#include "monitor/watch/watch.h"

#include <glib-unix.h>
#include <glib.h>
#include <inttypes.h>
#include <sodium.h>
#include <stdio.h>
#include <unistd.h>

static const char program_summary[] =
    "Shows the runs and workers heard on an LCM network: on a full screen, or where there is no\n"
    "terminal a line a run and a second, and with --http on a page for browsers. It only\n"
    "listens: any number of monitors may be started and stopped at any time.";

static const char program_description[] =
    "Examples:\n"
    "  sobox-monitor --url 'udpm://239.255.76.67:7667?ttl=1'\n"
    "  sobox-monitor --http 127.0.0.1:8765\n"
    "  sobox-monitor --from runs/sedan --http 127.0.0.1:8765\n"
    "  sobox-monitor --json | jq .runs[0].searches[0].log_volume\n"
    "\n"
    "Without --url the environment variable SOBOX_URL names the network, and without that it is\n"
    "udpm://239.255.76.67:7667?ttl=1.\n"
    "\n"
    "Exit status: 0 stopped; 1 failed while running; 2 usage.";

struct options {
    char *url;
    char *from;
    char *http;
    char *key_file;
    gboolean json;
    gboolean plain;
    gboolean quiet;
    gboolean version;
};

struct monitor {
    struct options options;
    struct feed feed;
    struct texts *texts;
    struct watch *watch;   // of a network, or
    struct record *record; // of a run folder
    struct picture_view view;
    char instance[17];
    struct http *http;
    struct screen *screen; // NULL: lines are printed, or nothing
    GMainLoop *loop;
    int64_t shown_ns; // when lines were last printed
    gboolean silence_said;
};

// ---- Options ----

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    *options = (struct options){0};
    const GOptionEntry entries[] = {
        {"url", 'u', 0, G_OPTION_ARG_STRING, &options->url, "The LCM network to watch", "LCM_URL"},
        {"from", 'f', 0, G_OPTION_ARG_FILENAME, &options->from,
         "Show the run of this run folder in place of a network", "RUN_DIR"},
        {"key-file", 'k', 0, G_OPTION_ARG_FILENAME, &options->key_file,
         "The key that the network's messages are sealed with, in this file", "FILE"},
        {"http", 'w', 0, G_OPTION_ARG_STRING, &options->http,
         "Serve a page for browsers, for instance at 127.0.0.1:8765", "ADDRESS:PORT"},
        {"json", 'j', 0, G_OPTION_ARG_NONE, &options->json, "One JSON object a second", NULL},
        {"plain", 'p', 0, G_OPTION_ARG_NONE, &options->plain, "Lines, also on a terminal", NULL},
        {"quiet", 'q', 0, G_OPTION_ARG_NONE, &options->quiet, "Print nothing but errors", NULL},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_program program = {
        .summary = program_summary,
        .description = program_description,
        .entries = entries,
    };
    struct options_common common;
    enum status status = options_read(&program, argc, argv, &common, error);
    options->version = common.version;
    if (status == STATUS_OK && options->from != NULL &&
        (options->url != NULL || options->key_file != NULL))
        status = error_set(error, STATUS_INVALID,
                           "--from: a run folder is no network: expected it without --url and "
                           "--key-file");
    if (options->url == NULL) {
        const char *url = g_getenv("SOBOX_URL");
        options->url = g_strdup(url ? url : "udpm://239.255.76.67:7667?ttl=1");
    }
    return status;
}

static void options_free(struct options *options)
{
    g_free(options->url);
    g_free(options->from);
    g_free(options->http);
    g_free(options->key_file);
}

// ---- Showing ----

static const char *source(const struct monitor *monitor)
{
    return monitor->options.from != NULL ? monitor->options.from : monitor->options.url;
}

static void show_lines(struct monitor *monitor, int64_t now_ns)
{
    if (monitor->options.json) {
        lines_print_json(&monitor->feed, now_ns, (double)clock_calendar_ns() / 1e9, stdout);
    } else if (lines_print(&monitor->feed, monitor->shown_ns, now_ns, stdout) > 0) {
        monitor->silence_said = FALSE;
    } else if (!monitor->silence_said) {
        monitor->silence_said = TRUE;
        const guint workers = monitor->feed.workers.entries->len;
        printf("no run is heard on %s; %u worker%s\n", source(monitor), workers,
               workers == 1 ? "" : "s");
    }
    fflush(stdout);
    monitor->shown_ns = now_ns;
}

// A run folder whose run is over is shown once where nobody stays to look at it.
static bool is_told(const struct monitor *monitor)
{
    return monitor->record != NULL && !record_goes_on(monitor->record) && monitor->http == NULL &&
           monitor->screen == NULL;
}

static void read_on(struct monitor *monitor, int64_t now_ns)
{
    struct error error = {0};
    if (record_goes_on(monitor->record) &&
        record_read(monitor->record, now_ns, &error) != STATUS_OK)
        log_note("%s", error.text);
}

static gboolean second(gpointer user)
{
    struct monitor *monitor = user;
    const int64_t now_ns = clock_monotonic_ns();
    if (monitor->watch != NULL)
        watch_count(monitor->watch, now_ns);
    else
        read_on(monitor, now_ns);
    feed_tick(&monitor->feed, now_ns);
    if (!monitor->options.quiet && monitor->screen == NULL)
        show_lines(monitor, now_ns);
    if (is_told(monitor))
        g_main_loop_quit(monitor->loop);
    return G_SOURCE_CONTINUE;
}

static void want(void *user, uint64_t run, const struct digest *scenario)
{
    struct monitor *monitor = user;
    if (monitor->watch != NULL)
        watch_want(monitor->watch, run, scenario);
}

static void want_samples(void *user, uint64_t run, uint32_t search)
{
    (void)run; // a run folder holds one
    struct monitor *monitor = user;
    struct error error = {0};
    if (monitor->record != NULL &&
        record_read_samples(monitor->record, search, clock_monotonic_ns(), &error) != STATUS_OK)
        log_note("%s", error.text);
}

static enum status serve(struct monitor *monitor, struct error *error)
{
    uint64_t instance;
    randombytes_buf(&instance, sizeof instance);
    g_snprintf(monitor->instance, sizeof monitor->instance, "%016" PRIx64, instance);
    monitor->view = (struct picture_view){
        .feed = &monitor->feed,
        .texts = monitor->texts,
        .source = source(monitor),
        .instance = monitor->instance,
        .start_ns = clock_monotonic_ns(),
        .want = want,
        .want_samples = want_samples,
        .user = monitor,
    };
    const enum status status =
        http_start(&monitor->http, monitor->options.http, &monitor->view, error);
    if (status != STATUS_OK)
        return status;
    log_note("the page is at %s", http_url(monitor->http));
    if (http_leaves_machine(monitor->http))
        log_note("everybody who reaches this machine can watch: --http 127.0.0.1:PORT keeps the "
                 "page here");
    return STATUS_OK;
}

// ---- Life ----

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

// Notes would stand across the screen; what matters of them is among the problems it shows.
static void show_start(struct monitor *monitor)
{
    if (monitor->options.json || monitor->options.plain || monitor->options.quiet)
        return;
    monitor->screen = screen_start(&monitor->feed, source(monitor), stop, monitor);
    if (monitor->screen != NULL)
        log_start("sobox-monitor", LOG_QUIET);
}

static enum status open_source(struct monitor *monitor, const struct key *key, struct error *error)
{
    if (monitor->options.from == NULL)
        return watch_start(&monitor->watch, monitor->options.url, key, &monitor->feed,
                           monitor->texts, error);
    monitor->record = record_open(monitor->options.from, &monitor->feed, monitor->texts);
    return record_read(monitor->record, clock_monotonic_ns(), error);
}

static void run_loop(struct monitor *monitor)
{
    g_unix_signal_add(SIGINT, stop, monitor);
    g_unix_signal_add(SIGTERM, stop, monitor);
    show_start(monitor);
    if (!monitor->options.quiet)
        g_unix_fd_add(STDOUT_FILENO, G_IO_ERR, unread, monitor);
    g_timeout_add(1000, second, monitor);
    // A network is waited for; a run folder has something to show at once, and is never silent.
    monitor->silence_said = monitor->record != NULL;
    if (monitor->record != NULL)
        second(monitor);
    if (!is_told(monitor))
        g_main_loop_run(monitor->loop);
    if (monitor->record == NULL)
        second(monitor);
}

static enum status run(struct monitor *monitor, struct error *error)
{
    struct key *key = NULL;
    enum status status = STATUS_OK;
    if (monitor->options.key_file != NULL)
        status = key_read(&key, monitor->options.key_file, error);
    if (status == STATUS_OK)
        status = open_source(monitor, key, error);
    if (status == STATUS_OK && monitor->options.http != NULL)
        status = serve(monitor, error);
    if (status == STATUS_OK)
        run_loop(monitor);
    screen_stop(monitor->screen);
    http_stop(monitor->http);
    record_close(monitor->record);
    watch_stop(monitor->watch);
    key_free(key);
    return status;
}

int main(int argc, char **argv)
{
    streams_start();
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
        monitor.texts = texts_create();
        monitor.loop = g_main_loop_new(NULL, FALSE);
        status = run(&monitor, &error);
        g_main_loop_unref(monitor.loop);
        texts_free(monitor.texts);
        feed_fini(&monitor.feed);
    }
    if (status != STATUS_OK)
        log_failure(&error);
    options_free(&monitor.options);
    return (int)status_exit(status);
}
