// sobox-hub: where a network carries no multicast, programs meet here over TCP. It speaks the
// protocol of LCM's tcpq:// clients, so LCM's own tools can listen too.
#include "common/base/error.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "common/wire/key.h"
#include "common/wire/wire.h"
#include "hub/server/server.h"

#include <arpa/inet.h>
#include <glib-unix.h>
#include <glib.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#define LISTEN_DEFAULT "0.0.0.0:7700"

struct options {
    char *listen;
    char *key_file;
    long clients;
    long queue;
    long message;
    gboolean quiet;
    gboolean verbose;
    gboolean version;
};

static const struct options_number number_options[] = {
    {"--clients", offsetof(struct options, clients), 1, 100000},
    {"--queue", offsetof(struct options, queue), WIRE_MTU_MAX, 1 << 30},
    {"--message", offsetof(struct options, message), WIRE_MTU_MAX, 1 << 28},
    {0},
};

static enum status read_options(struct options *options, int argc, char **argv, struct error *error)
{
    const GOptionEntry entries[] = {
        {"listen", 'l', 0, G_OPTION_ARG_STRING, &options->listen,
         "Where to listen, in numbers (default: " LISTEN_DEFAULT ", all of this machine's)",
         "ADDRESS:PORT"},
        {"key-file", 'k', 0, G_OPTION_ARG_FILENAME, &options->key_file,
         "Pass on only messages sealed with the key in this file", "FILE"},
        {"clients", 0, 0, G_OPTION_ARG_CALLBACK, options_number,
         "Most clients at once (default: 1024)", "N"},
        {"queue", 0, 0, G_OPTION_ARG_CALLBACK, options_number,
         "What waits for a slow client at most, 60000 or more bytes (default: 4194304)", "BYTES"},
        {"message", 0, 0, G_OPTION_ARG_CALLBACK, options_number,
         "Greatest message passed on, 60000 or more bytes (default: 1048576)", "BYTES"},
        {"quiet", 'q', 0, G_OPTION_ARG_NONE, &options->quiet, "Print errors only", NULL},
        {"verbose", 'v', 0, G_OPTION_ARG_NONE, &options->verbose, "Print who comes and goes", NULL},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_program program = {
        .summary = "Passes LCM's messages on between programs that reach it over TCP, where there "
                   "is no\n"
                   "multicast. They are given --url tcpq://ADDRESS:PORT, the address in numbers.",
        .description = "SIGUSR1 has it say what it has passed on.\n"
                       "Exit status: 0 stopped; 1 failed while running; 2 usage.",
        .entries = entries,
        .numbers = number_options,
        .options = options,
    };
    struct options_common common;
    const enum status status = options_read(&program, argc, argv, &common, error);
    options->version = common.version;
    return status;
}

// A name is not looked up: what a hub listens at must not depend on what a name server says, and
// what clients are given is a number too.
static enum status read_address(const char *text, struct sockaddr_in *address, struct error *error)
{
    const char *colon = strrchr(text, ':');
    guint64 port = 0;
    g_autofree char *host = g_strndup(text, colon != NULL ? (gsize)(colon - text) : 0);
    *address = (struct sockaddr_in){.sin_family = AF_INET};
    if (colon == NULL || inet_pton(AF_INET, host, &address->sin_addr) != 1 ||
        IN_MULTICAST(ntohl(address->sin_addr.s_addr)) ||
        !g_ascii_string_to_unsigned(colon + 1, 10, 0, UINT16_MAX, &port, NULL))
        return error_set(
            error, STATUS_INVALID,
            "--listen %s: expected ADDRESS:PORT in numbers, for instance " LISTEN_DEFAULT
            " or 127.0.0.1:7700 (port 0: one that is free)",
            text);
    address->sin_port = htons((uint16_t)port);
    return STATUS_OK;
}

// ---- The whole ----

static gboolean stop_loop(gpointer loop)
{
    g_main_loop_quit(loop);
    return G_SOURCE_CONTINUE;
}

static gboolean on_bytes(gint descriptor, GIOCondition condition, gpointer server)
{
    (void)descriptor;
    (void)condition;
    server_dispatch(server);
    return G_SOURCE_CONTINUE;
}

static gboolean each_second(gpointer server)
{
    server_second(server);
    return G_SOURCE_CONTINUE;
}

static gboolean tell(gpointer server)
{
    struct relay_counters counters = server_counters(server);
    log_note("%zu clients of %" PRIu64 " that came; %" PRIu64 " messages taken, %" PRIu64
             " passed on, %" PRIu64 " lost to slow clients, %" PRIu64
             " without the right seal, %" PRIu64 " too large",
             server_clients(server), counters.joined, counters.received, counters.delivered,
             counters.lost, counters.refused, counters.large);
    return G_SOURCE_CONTINUE;
}

static void say_hello(const struct server *server, const struct key *key)
{
    char address[INET_ADDRSTRLEN], name[KEY_NAME_SIZE];
    struct sockaddr_in at = server_address(server);
    inet_ntop(AF_INET, &at.sin_addr, address, sizeof address);
    log_note("listening at %s:%u", address, ntohs(at.sin_port));
    if (key != NULL)
        log_note("only messages sealed with the key %s are passed on", key_name(key, name));
    else if (ntohl(at.sin_addr.s_addr) >> 24 != 127)
        log_note(
            "anyone who reaches this port can take part: messages carry no key. Share one with "
            "--key-file, or listen at an address that only those you trust can reach");
}

static enum status serve(const struct options *options, const struct key *key, struct error *error)
{
    struct server *server = NULL;
    struct sockaddr_in address;
    struct relay_settings settings = relay_settings_default();
    settings.clients_max = (uint32_t)options->clients;
    settings.queue_max = (size_t)options->queue;
    settings.message_max = (size_t)options->message;
    settings.key = key;
    enum status status =
        read_address(options->listen != NULL ? options->listen : LISTEN_DEFAULT, &address, error);
    if (status == STATUS_OK)
        status = server_open(&server, &address, &settings, error);
    if (status != STATUS_OK)
        return status;
    GMainLoop *loop = g_main_loop_new(NULL, FALSE);
    g_unix_signal_add(SIGINT, stop_loop, loop);
    g_unix_signal_add(SIGTERM, stop_loop, loop);
    g_unix_signal_add(SIGUSR1, tell, server);
    g_unix_fd_add(server_descriptor(server), G_IO_IN, on_bytes, server);
    g_timeout_add_seconds(1, each_second, server);
    say_hello(server, key);
    g_main_loop_run(loop);
    tell(server);
    server_close(server);
    g_main_loop_unref(loop);
    return STATUS_OK;
}

static enum status run(const struct options *options, struct error *error)
{
    struct key *key = NULL;
    enum status status = STATUS_OK;
    if (options->key_file != NULL)
        status = key_read(&key, options->key_file, error);
    if (status == STATUS_OK)
        status = serve(options, key, error);
    key_free(key);
    return status;
}

int main(int argc, char **argv)
{
    streams_start();
    log_start("sobox-hub", LOG_NORMAL);
    struct relay_settings settings = relay_settings_default();
    struct options options = {.clients = (long)settings.clients_max,
                              .queue = (long)settings.queue_max,
                              .message = (long)settings.message_max};
    struct error error = {0};
    enum status status = read_options(&options, argc, argv, &error);
    if (status == STATUS_OK && options.version) {
        printf("sobox-hub %s\n", SOBOX_VERSION);
    } else if (status == STATUS_OK) {
        log_start("sobox-hub", options_log_level(options.quiet, options.verbose));
        status = run(&options, &error);
    }
    if (status != STATUS_OK)
        log_error("%s", error.text);
    g_free(options.listen);
    g_free(options.key_file);
    return (int)status_exit(status);
}
