#include "hub/server/server.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/link.h"

#include <arpa/inet.h>
#include <errno.h>
#include <glib.h>
#include <inttypes.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    EVENTS_A_TURN = 64,
    ACCEPTS_A_TURN = 32,
    PIECES_A_WRITE = 64,
    INPUT_SIZE = 262144,    // [bytes] read from a client at once, so that each has its turn
    DESCRIPTORS_SPARE = 32, // that a process needs besides its clients'
    BACKLOG = 512,
};

struct connection {
    int socket; // -1: over; freed when the turn is
    struct relay_client *client;
    bool writing; // waits for room in its socket
    uint64_t lost;
};

struct server {
    struct relay *relay;
    int listener;
    int epoll;
    struct sockaddr_in address;
    GQueue over; // connections to be freed
    uint8_t input[INPUT_SIZE];
};

// ---- Connections ----

static void hang_up(struct server *server, struct connection *connection, const char *why)
{
    connection->lost += relay_lost(connection->client);
    log_debug("%s left: %s", relay_name(connection->client), why);
    if (connection->lost > 0)
        log_note("%s left (%s) after %" PRIu64 " messages to it were lost",
                 relay_name(connection->client), why, connection->lost);
    relay_leave(server->relay, connection->client);
    close(connection->socket); // which takes it out of the epoll, too
    connection->socket = -1;
    g_queue_push_tail(&server->over, connection);
}

// A misbehaving client is the user's business, a leaving one is not.
static void cut_off(struct server *server, struct relay_client *client, const char *why)
{
    log_note("%s is cut off: %s", relay_name(client), why);
    hang_up(server, relay_user(client), why);
}

static void watch(struct server *server, struct connection *connection, int operation)
{
    struct epoll_event event = {.events = EPOLLIN | (connection->writing ? EPOLLOUT : 0),
                                .data.ptr = connection};
    epoll_ctl(server->epoll, operation, connection->socket, &event);
}

static void welcome(struct server *server, int socket, const struct sockaddr_in *from)
{
    char address[INET_ADDRSTRLEN], name[RELAY_NAME_SIZE];
    int64_t now_ns = clock_monotonic_ns();
    inet_ntop(AF_INET, &from->sin_addr, address, sizeof address);
    g_snprintf(name, sizeof name, "%s:%u", address, ntohs(from->sin_port));
    struct connection *connection = g_new0(struct connection, 1);
    connection->socket = socket;
    connection->client = relay_join(server->relay, name, connection, now_ns);
    if (connection->client == NULL) {
        struct relay_client *victim = relay_victim(server->relay, now_ns);
        if (victim != NULL) {
            cut_off(server, victim, "all places are taken, and it has shown nothing");
            connection->client = relay_join(server->relay, name, connection, now_ns);
        }
    }
    if (connection->client == NULL) {
        log_note("%s is sent away: all places are taken (see --clients)", name);
        close(socket);
        g_free(connection);
        return;
    }
    log_debug("%s came", name);
    link_tune(socket);
    watch(server, connection, EPOLL_CTL_ADD);
}

static void accept_clients(struct server *server)
{
    for (unsigned i = 0; i < ACCEPTS_A_TURN; i++) {
        struct sockaddr_in from = {0};
        socklen_t size = sizeof from;
        int socket = accept4(server->listener, (struct sockaddr *)&from, &size,
                             SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (socket < 0)
            return;
        welcome(server, socket, &from);
    }
}

// ---- Bytes ----

static void write_to(struct server *server, struct connection *connection)
{
    struct iovec pieces[PIECES_A_WRITE];
    bool full = false;
    while (!full) {
        struct msghdr message = {.msg_iov = pieces};
        message.msg_iovlen = relay_peek(connection->client, pieces, PIECES_A_WRITE);
        if (message.msg_iovlen == 0)
            break;
        ssize_t sent = sendmsg(connection->socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent >= 0) {
            relay_pop(connection->client, (size_t)sent);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            full = true;
        } else if (errno != EINTR) {
            hang_up(server, connection, g_strerror(errno));
            return;
        }
    }
    if (full != connection->writing) {
        connection->writing = full;
        watch(server, connection, EPOLL_CTL_MOD);
    }
}

static void read_from(struct server *server, struct connection *connection)
{
    const char *why;
    ssize_t size = recv(connection->socket, server->input, INPUT_SIZE, MSG_DONTWAIT);
    if (size == 0)
        hang_up(server, connection, "it closed the connection");
    else if (size < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
        hang_up(server, connection, g_strerror(errno));
    else if (size > 0 && !relay_take(server->relay, connection->client, server->input, (size_t)size,
                                     clock_monotonic_ns(), &why))
        cut_off(server, connection->client, why);
}

// What the clients said has filled queues of others.
static void write_to_all(struct server *server)
{
    struct relay_client *client;
    while ((client = relay_next_to_write(server->relay)) != NULL) {
        struct connection *connection = relay_user(client);
        if (!connection->writing)
            write_to(server, connection);
    }
}

void server_dispatch(struct server *server)
{
    struct epoll_event events[EVENTS_A_TURN];
    int count = epoll_wait(server->epoll, events, EVENTS_A_TURN, 0);
    for (int i = 0; i < count; i++) {
        struct connection *connection = events[i].data.ptr;
        if (connection == NULL) {
            accept_clients(server);
            continue;
        }
        // It may be over because of what another did meanwhile.
        if (connection->socket >= 0 && (events[i].events & EPOLLOUT) != 0)
            write_to(server, connection);
        if (connection->socket >= 0 && (events[i].events & ~(uint32_t)EPOLLOUT) != 0)
            read_from(server, connection);
    }
    write_to_all(server);
    g_queue_clear_full(&server->over, g_free);
}

static void tell_losses(struct relay_client *client, void *user)
{
    struct connection *connection = relay_user(client);
    uint64_t lost = relay_lost(client);
    (void)user;
    if (lost > 0 && connection->lost == 0)
        log_note("%s reads too slowly or not at all: messages to it are lost", relay_name(client));
    connection->lost += lost;
}

void server_second(struct server *server)
{
    struct relay_client *client;
    while ((client = relay_overdue(server->relay, clock_monotonic_ns())) != NULL)
        cut_off(server, client, "it began and did not go on");
    relay_each(server->relay, tell_losses, NULL);
    g_queue_clear_full(&server->over, g_free);
}

// ---- Opening ----

// As many clients as the process may open files for.
static uint32_t fit_clients(uint32_t wanted)
{
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) != 0)
        return wanted;
    rlim_t needed = (rlim_t)wanted + DESCRIPTORS_SPARE;
    if (files.rlim_cur < needed) {
        files.rlim_cur = MIN(files.rlim_max, needed);
        setrlimit(RLIMIT_NOFILE, &files);
    }
    if (files.rlim_cur >= needed)
        return wanted;
    uint32_t fitting =
        files.rlim_cur > DESCRIPTORS_SPARE ? (uint32_t)(files.rlim_cur - DESCRIPTORS_SPARE) : 1;
    log_note("at most %u clients: this process may open %llu files only ('ulimit -n')", fitting,
             (unsigned long long)files.rlim_cur);
    return fitting;
}

static enum status listen_at(struct server *server, const struct sockaddr_in *address,
                             struct error *error)
{
    int on = 1;
    socklen_t size = sizeof server->address;
    char text[INET_ADDRSTRLEN];
    inet_ntop(AF_INET, &address->sin_addr, text, sizeof text);
    server->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    setsockopt(server->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (server->listener < 0 ||
        bind(server->listener, (const struct sockaddr *)address, sizeof *address) != 0 ||
        listen(server->listener, BACKLOG) != 0 ||
        getsockname(server->listener, (struct sockaddr *)&server->address, &size) != 0)
        return error_set(error, STATUS_NETWORK, "cannot listen at %s:%u: %s", text,
                         ntohs(address->sin_port), g_strerror(errno));
    struct epoll_event event = {.events = EPOLLIN};
    server->epoll = epoll_create1(EPOLL_CLOEXEC);
    if (server->epoll < 0 || epoll_ctl(server->epoll, EPOLL_CTL_ADD, server->listener, &event) != 0)
        return error_set(error, STATUS_NETWORK, "cannot wait for clients: %s", g_strerror(errno));
    return STATUS_OK;
}

enum status server_open(struct server **opened, const struct sockaddr_in *address,
                        const struct relay_settings *settings, struct error *error)
{
    struct server *server = g_new0(struct server, 1);
    server->listener = server->epoll = -1;
    g_queue_init(&server->over);
    *opened = NULL;
    enum status status = listen_at(server, address, error);
    if (status != STATUS_OK) {
        server_close(server);
        return status;
    }
    struct relay_settings fitting = *settings;
    fitting.clients_max = fit_clients(settings->clients_max);
    server->relay = relay_create(&fitting);
    *opened = server;
    return STATUS_OK;
}

static void close_socket(struct relay_client *client, void *user)
{
    struct connection *connection = relay_user(client);
    (void)user;
    close(connection->socket);
    g_free(connection);
}

void server_close(struct server *server)
{
    if (server == NULL)
        return;
    if (server->relay != NULL)
        relay_each(server->relay, close_socket, NULL);
    relay_free(server->relay);
    if (server->listener >= 0)
        close(server->listener);
    if (server->epoll >= 0)
        close(server->epoll);
    g_free(server);
}

// ---- Looking ----

struct sockaddr_in server_address(const struct server *server)
{
    return server->address;
}

int server_descriptor(const struct server *server)
{
    return server->epoll;
}

size_t server_clients(const struct server *server)
{
    return relay_count(server->relay);
}

struct relay_counters server_counters(const struct server *server)
{
    return relay_counters(server->relay);
}
