#include "monitor/http/http.h"

#include "common/base/clock.h"
#include "monitor/http/host.h"
#include "monitor/http/metrics.h"
#include "monitor/http/xray.h"
#include "monitor/web/web.h"

#include <arpa/inet.h>
#include <errno.h>
#include <glib-unix.h>
#include <inttypes.h>
#include <microhttpd.h>
#include <string.h>
#include <unistd.h>

enum {
    TICK_MS = 100,
    ROUNDS_MAX = 64, // of MHD in one go: the other sources of the loop have their turn between
    BLOCK_SIZE = 32768,
};

struct http {
    struct MHD_Daemon *daemon;
    const struct picture_view *view;
    GPtrArray *streams; // struct stream *, owned by their responses
    struct host_address address;
    char *url;
    char *machine;
    guint readable, tick; // GLib sources
};

// One reader of /events.
struct stream {
    struct http *http;
    struct MHD_Connection *connection;
    struct picture_cursor cursor;
    GString *text; // of the event being sent
    gsize sent;    // of it [bytes]
    bool suspended;
};

// What every answer carries: the page may use nothing but what comes from here, and nobody may use
// the page inside theirs.
static const char *const headers[][2] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
     "img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cache-Control", "no-store"},
};

// ---- The loop ----

static void serve(struct http *http)
{
    MHD_UNSIGNED_LONG_LONG timeout_ms;
    for (int i = 0; i < ROUNDS_MAX; i++) {
        MHD_run(http->daemon);
        if (MHD_get_timeout(http->daemon, &timeout_ms) != MHD_YES || timeout_ms > 0)
            return;
    }
}

static gboolean ready(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)descriptor;
    (void)condition;
    serve(user);
    return G_SOURCE_CONTINUE;
}

static gboolean tick(gpointer user)
{
    struct http *http = user;
    const int64_t now_ns = clock_monotonic_ns();
    for (guint i = 0; i < http->streams->len; i++) {
        struct stream *stream = http->streams->pdata[i];
        if (stream->suspended && picture_due(http->view, &stream->cursor, now_ns)) {
            stream->suspended = false;
            MHD_resume_connection(stream->connection);
        }
    }
    serve(http);
    return G_SOURCE_CONTINUE;
}

// ---- Answers ----

static enum MHD_Result answer(struct MHD_Connection *connection, unsigned status, const char *type,
                              struct MHD_Response *response)
{
    for (size_t i = 0; i < G_N_ELEMENTS(headers); i++)
        MHD_add_response_header(response, headers[i][0], headers[i][1]);
    MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type);
    if (status == MHD_HTTP_METHOD_NOT_ALLOWED)
        MHD_add_response_header(response, MHD_HTTP_HEADER_ALLOW, "GET, HEAD");
    if (status == MHD_HTTP_SERVICE_UNAVAILABLE)
        MHD_add_response_header(response, MHD_HTTP_HEADER_RETRY_AFTER, "5");
    const enum MHD_Result result = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return result;
}

static enum MHD_Result refuse(struct MHD_Connection *connection, unsigned status, const char *why)
{
    return answer(
        connection, status, "text/plain; charset=utf-8",
        MHD_create_response_from_buffer(strlen(why), (void *)why, MHD_RESPMEM_PERSISTENT));
}

static enum MHD_Result send_text(struct MHD_Connection *connection, const char *type, GString *text)
{
    struct MHD_Response *response =
        MHD_create_response_from_buffer(text->len, text->str, MHD_RESPMEM_MUST_COPY);
    g_string_free(text, TRUE);
    return answer(connection, MHD_HTTP_OK, type, response);
}

// ---- Streams ----

// Chooses what the query names. False when it makes no sense.
static bool cursor_choose(struct picture_cursor *cursor, struct MHD_Connection *connection)
{
    const char *run = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "run");
    const char *search = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "search");
    guint64 number;
    if (run != NULL) {
        if (!g_ascii_string_to_unsigned(run, 16, 0, UINT64_MAX, &number, NULL))
            return false;
        cursor->has_run = true;
        cursor->run = number;
    }
    if (search != NULL) {
        if (run == NULL || !g_ascii_string_to_unsigned(search, 10, 0, INT32_MAX, &number, NULL))
            return false;
        cursor->has_search = true;
        cursor->search = (uint32_t)number;
    }
    return true;
}

static void stream_write_event(struct stream *stream, int64_t now_ns)
{
    g_string_assign(stream->text, "data: ");
    picture_event(stream->http->view, &stream->cursor, now_ns, stream->text);
    g_string_append(stream->text, "\n\n");
    stream->sent = 0;
}

// MHD asks for more of a stream: what is left of the event, the next one if it is time, or else it
// is suspended until the tick finds news.
static ssize_t stream_read(void *user, uint64_t position, char *buffer, size_t size)
{
    (void)position;
    struct stream *stream = user;
    const int64_t now_ns = clock_monotonic_ns();
    if (stream->sent == stream->text->len) {
        if (!picture_due(stream->http->view, &stream->cursor, now_ns)) {
            stream->suspended = true;
            MHD_suspend_connection(stream->connection);
            return 0;
        }
        stream_write_event(stream, now_ns);
    }
    const size_t left = stream->text->len - stream->sent;
    const size_t sending = MIN(left, size);
    memcpy(buffer, stream->text->str + stream->sent, sending);
    stream->sent += sending;
    return (ssize_t)sending;
}

static void stream_free(void *user)
{
    struct stream *stream = user;
    g_ptr_array_remove_fast(stream->http->streams, stream);
    g_string_free(stream->text, TRUE);
    g_free(stream);
}

static enum MHD_Result send_events(struct http *http, struct MHD_Connection *connection)
{
    struct picture_cursor cursor = {0};
    if (!cursor_choose(&cursor, connection))
        return refuse(connection, MHD_HTTP_BAD_REQUEST,
                      "expected run=HEXADECIMAL and search=NUMBER\n");
    if (http->streams->len >= HTTP_STREAM_MAX)
        return refuse(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "too many viewers\n");
    struct stream *stream = g_new(struct stream, 1);
    *stream = (struct stream){
        .http = http,
        .connection = connection,
        .cursor = cursor,
        // A browser that loses us tries again after so many milliseconds.
        .text = g_string_new("retry: 2000\n\n"),
    };
    g_ptr_array_add(http->streams, stream);
    struct MHD_Response *response = MHD_create_response_from_callback(
        MHD_SIZE_UNKNOWN, BLOCK_SIZE, stream_read, stream, stream_free);
    return answer(connection, MHD_HTTP_OK, "text/event-stream; charset=utf-8", response);
}

static enum MHD_Result send_state(struct http *http, struct MHD_Connection *connection)
{
    struct picture_cursor cursor = {0};
    if (!cursor_choose(&cursor, connection))
        return refuse(connection, MHD_HTTP_BAD_REQUEST,
                      "expected run=HEXADECIMAL and search=NUMBER\n");
    GString *text = g_string_new(NULL);
    picture_event(http->view, &cursor, clock_monotonic_ns(), text);
    g_string_append_c(text, '\n');
    return send_text(connection, "application/json", text);
}

// A number of the query, or `missing`. False when it is none.
static bool query_number(struct MHD_Connection *connection, const char *name, uint32_t missing,
                         uint32_t *number)
{
    const char *text = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, name);
    guint64 value = missing;
    const bool sound =
        text == NULL || g_ascii_string_to_unsigned(text, 10, 0, UINT32_MAX, &value, NULL);
    *number = (uint32_t)value;
    return sound;
}

static enum MHD_Result send_samples(struct http *http, struct MHD_Connection *connection,
                                    bool table)
{
    struct picture_cursor cursor = {0};
    uint32_t step, x, y;
    if (!cursor_choose(&cursor, connection) || !cursor.has_search ||
        !query_number(connection, "step", UINT32_MAX, &step) ||
        !query_number(connection, "x", 0, &x) || !query_number(connection, "y", 0, &y))
        return refuse(connection, MHD_HTTP_BAD_REQUEST,
                      "expected run=HEXADECIMAL, search=NUMBER, x=NUMBER and y=NUMBER\n");
    const struct picture_view *view = http->view;
    if (view->want_samples != NULL)
        view->want_samples(view->user, cursor.run, cursor.search);
    const struct feed_search *search = feed_search_find(view->feed, cursor.run, cursor.search);
    const struct album_picture *picture =
        search != NULL && search->album != NULL ? album_find(search->album, step) : NULL;
    GString *text = g_string_new(NULL);
    if (picture != NULL && table) {
        xray_csv(picture, texts_find(view->texts, &picture->scenario), text);
        return send_text(connection, "text/csv; charset=utf-8", text);
    }
    if (picture != NULL && xray_points(picture, x, y, text))
        return send_text(connection, "application/json", text);
    g_string_free(text, TRUE);
    return refuse(connection, MHD_HTTP_NOT_FOUND, "no samples of these are known\n");
}

static enum MHD_Result send_metrics(struct http *http, struct MHD_Connection *connection)
{
    GString *text = g_string_new(NULL);
    metrics_write(http->view->feed, clock_monotonic_ns(), text);
    return send_text(connection, METRICS_TYPE, text);
}

// ---- Requests ----

// Whether another site made the browser ask. Opening the page by a link from there is fine.
static bool is_from_elsewhere(struct MHD_Connection *connection, bool page)
{
    const char *site = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Sec-Fetch-Site");
    return !page && site != NULL && strcmp(site, "same-origin") != 0 && strcmp(site, "none") != 0;
}

static enum MHD_Result respond(struct http *http, struct MHD_Connection *connection,
                               const char *path, const char *method)
{
    const char *host =
        MHD_lookup_connection_value(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_HOST);
    if (!host_is_ours(host, http->machine))
        return refuse(connection, MHD_HTTP_MISDIRECTED_REQUEST,
                      "ask by number, localhost, or this machine's own name\n");
    if (is_from_elsewhere(connection, strcmp(path, "/") == 0))
        return refuse(connection, MHD_HTTP_FORBIDDEN, "not for other sites\n");
    if (strcmp(method, MHD_HTTP_METHOD_GET) != 0 && strcmp(method, MHD_HTTP_METHOD_HEAD) != 0)
        return refuse(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "this server only shows\n");
    struct web_file file;
    if (web_file(path, &file))
        return answer(
            connection, MHD_HTTP_OK, file.type,
            MHD_create_response_from_buffer(file.size, (void *)file.bytes, MHD_RESPMEM_PERSISTENT));
    if (strcmp(path, "/events") == 0)
        return send_events(http, connection);
    if (strcmp(path, "/state.json") == 0)
        return send_state(http, connection);
    if (strcmp(path, "/samples.json") == 0 || strcmp(path, "/samples.csv") == 0)
        return send_samples(http, connection, strcmp(path, "/samples.csv") == 0);
    if (strcmp(path, "/metrics") == 0)
        return send_metrics(http, connection);
    return refuse(connection, MHD_HTTP_NOT_FOUND, "there is nothing of that name\n");
}

// Called first when a request's headers are there; a body is never waited for.
static enum MHD_Result handle(void *user, struct MHD_Connection *connection, const char *path,
                              const char *method, const char *version, const char *body,
                              size_t *body_size, void **state)
{
    (void)version;
    (void)body;
    (void)body_size;
    (void)state;
    return respond(user, connection, path, method);
}

// MHD's complaints are about clients, which is their business.
static void __attribute__((format(printf, 2, 0)))
unheard(void *user, const char *format, va_list arguments)
{
    (void)user;
    (void)format;
    (void)arguments;
}

// ---- Life ----

static char *url_of(struct http *http)
{
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(http->daemon, MHD_DAEMON_INFO_BIND_PORT);
    char name[INET6_ADDRSTRLEN];
    if (http->address.socket.any.sa_family == AF_INET6) {
        inet_ntop(AF_INET6, &http->address.socket.v6.sin6_addr, name, sizeof name);
        return g_strdup_printf("http://[%s]:%u/", name, info->port);
    }
    inet_ntop(AF_INET, &http->address.socket.v4.sin_addr, name, sizeof name);
    return g_strdup_printf("http://%s:%u/", name, info->port);
}

static struct MHD_Daemon *daemon_start(struct http *http)
{
    unsigned flags = MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG;
    if (http->address.socket.any.sa_family == AF_INET6)
        flags |= MHD_USE_IPv6;
    return MHD_start_daemon(flags, 0, NULL, NULL, handle, http, MHD_OPTION_EXTERNAL_LOGGER, unheard,
                            NULL, MHD_OPTION_SOCK_ADDR, &http->address.socket.any,
                            MHD_OPTION_CONNECTION_LIMIT, (unsigned)HTTP_CONNECTION_MAX,
                            MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)HTTP_TIMEOUT_S,
                            MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)HTTP_CONNECTION_MEMORY,
                            MHD_OPTION_LISTENING_ADDRESS_REUSE, 1u, MHD_OPTION_END);
}

enum status http_start(struct http **made, const char *address, const struct picture_view *view,
                       struct error *error)
{
    *made = NULL;
    struct http *http = g_new0(struct http, 1);
    http->view = view;
    http->streams = g_ptr_array_new();
    http->machine = g_strdup(g_get_host_name());
    enum status status = host_parse(&http->address, address, error);
    if (status != STATUS_OK)
        goto err_after_alloc;
    errno = 0;
    http->daemon = daemon_start(http);
    if (http->daemon == NULL) {
        status = error_set(error, STATUS_NETWORK, "--http: %s: %s", address,
                           errno ? g_strerror(errno) : "the server cannot start");
        goto err_after_alloc;
    }
    http->url = url_of(http);
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(http->daemon, MHD_DAEMON_INFO_EPOLL_FD);
    http->readable = g_unix_fd_add(info->epoll_fd, G_IO_IN, ready, http);
    http->tick = g_timeout_add(TICK_MS, tick, http);
    *made = http;
    return STATUS_OK;

err_after_alloc:
    http_stop(http);
    return status;
}

void http_stop(struct http *http)
{
    if (http == NULL)
        return;
    if (http->daemon != NULL) {
        g_source_remove(http->readable);
        g_source_remove(http->tick);
        // MHD ends no connection that is suspended.
        for (guint i = 0; i < http->streams->len; i++) {
            struct stream *stream = http->streams->pdata[i];
            if (stream->suspended)
                MHD_resume_connection(stream->connection);
            stream->suspended = false;
        }
        MHD_stop_daemon(http->daemon);
    }
    g_ptr_array_free(http->streams, TRUE);
    g_free(http->url);
    g_free(http->machine);
    g_free(http);
}

const char *http_url(const struct http *http)
{
    return http->url;
}

bool http_leaves_machine(const struct http *http)
{
    return !http->address.loopback;
}
