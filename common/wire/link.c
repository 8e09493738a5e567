#include "common/wire/link.h"

#include "common/base/log.h"
#include "common/wire/frame.h"
#include "common/wire/wire.h"

#include <arpa/inet.h>
#include <assert.h>
#include <errno.h>
#include <glib.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <sys/uio.h>
#include <unistd.h>

enum link_state { LINK_WAITING, LINK_CONNECTING, LINK_GREETING, LINK_UP };

enum { CHANNELS_MAX = WIRE_KIND_COUNT };

struct link {
    enum link_state state;
    struct sockaddr_in address;
    link_handler *handler;
    void *user;
    int socket; // -1 while waiting
    int epoll;  // of socket and timer: what others poll
    int timer;  // next attempt; end of patience; or messages that wait in `input`
    unsigned retry_ms;
    bool broken;  // sending failed; seen to by link_dispatch()
    bool writing; // the socket is polled for room
    bool noted;   // the person was told that the hub is away
    bool reading; // a handler is being called
    const char *channels[CHANNELS_MAX];
    size_t channel_count;
    size_t skip; // [bytes] of a message too large that are still to come
    size_t input_first, input_size;
    uint8_t input[LINK_INPUT_SIZE];
    size_t output_first, output_size;
    uint8_t *output; // LINK_OUTPUT_MAX
};

void link_tune(int socket)
{
    const struct {
        int level, name, value;
    } options[] = {
        {IPPROTO_TCP, TCP_NODELAY, 1},
        // A silent connection is asked after 10 s, then each 5 s, and given up at the third
        // silence.
        {SOL_SOCKET, SO_KEEPALIVE, 1},
        {IPPROTO_TCP, TCP_KEEPIDLE, 10},
        {IPPROTO_TCP, TCP_KEEPINTVL, 5},
        {IPPROTO_TCP, TCP_KEEPCNT, 3},
        {IPPROTO_TCP, TCP_USER_TIMEOUT, 30000}, // what is not acknowledged by then [ms]
    };
    for (size_t i = 0; i < G_N_ELEMENTS(options); i++)
        setsockopt(socket, options[i].level, options[i].name, &options[i].value,
                   sizeof options[i].value);
}

// ---- Timer and states ----

// 0 switches the timer off; a shot at once is the shortest that it knows.
static void set_timer(struct link *link, unsigned ms, bool at_once)
{
    struct itimerspec when = {.it_value = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L}};
    if (at_once)
        when.it_value.tv_nsec = 1;
    timerfd_settime(link->timer, 0, &when, NULL);
}

static void watch(struct link *link, uint32_t events, int operation)
{
    struct epoll_event event = {.events = events, .data.fd = link->socket};
    epoll_ctl(link->epoll, operation, link->socket, &event);
}

static void name_hub(const struct link *link, char name[INET_ADDRSTRLEN + 8])
{
    char address[INET_ADDRSTRLEN];
    inet_ntop(AF_INET, &link->address.sin_addr, address, sizeof address);
    g_snprintf(name, INET_ADDRSTRLEN + 8, "%s:%u", address, ntohs(link->address.sin_port));
}

// The connection is over, or there is none: tries again in a while.
static void wait_for_hub(struct link *link, const char *why)
{
    char name[INET_ADDRSTRLEN + 8];
    name_hub(link, name);
    if (!link->noted)
        log_note("no hub at %s (%s): trying again until there is one", name, why);
    link->noted = true;
    if (link->socket >= 0)
        close(link->socket); // which takes it out of the epoll, too
    link->socket = -1;
    link->state = LINK_WAITING;
    link->broken = link->writing = false;
    link->skip = link->input_first = link->input_size = 0;
    link->output_first = link->output_size = 0;
    set_timer(link, link->retry_ms, false);
    link->retry_ms = MIN(2 * link->retry_ms, LINK_RETRY_MAX_MS);
}

static void append(struct link *link, const uint8_t *bytes, size_t size)
{
    assert(link->output_first + link->output_size + size <= LINK_OUTPUT_MAX);
    memcpy(link->output + link->output_first + link->output_size, bytes, size);
    link->output_size += size;
}

// Makes room at the end of the output for `size` bytes; false when too much waits.
static bool make_room(struct link *link, size_t size)
{
    if (link->output_size + size > LINK_OUTPUT_MAX)
        return false;
    if (link->output_first + link->output_size + size > LINK_OUTPUT_MAX) {
        memmove(link->output, link->output + link->output_first, link->output_size);
        link->output_first = 0;
    }
    return true;
}

static void flush(struct link *link)
{
    while (link->output_size > 0 && !link->broken) {
        ssize_t sent = send(link->socket, link->output + link->output_first, link->output_size,
                            MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent < 0 && errno == EINTR)
            continue;
        if (sent < 0) {
            link->broken = errno != EAGAIN && errno != EWOULDBLOCK;
            break;
        }
        link->output_first += (size_t)sent;
        link->output_size -= (size_t)sent;
    }
    if (link->output_size == 0)
        link->output_first = 0;
    bool writing = link->output_size > 0;
    if (writing != link->writing)
        watch(link, EPOLLIN | (writing ? EPOLLOUT : 0), EPOLL_CTL_MOD);
    link->writing = writing;
}

static void subscribe_at_hub(struct link *link, const char *channel)
{
    uint8_t bytes[FRAME_HEAD_MAX];
    size_t size = frame_head(bytes, FRAME_SUBSCRIBE, channel, strlen(channel), 0);
    if (make_room(link, size))
        append(link, bytes, size);
}

static void greet(struct link *link)
{
    int failed = 0;
    socklen_t size = sizeof failed;
    getsockopt(link->socket, SOL_SOCKET, SO_ERROR, &failed, &size);
    if (failed != 0) {
        wait_for_hub(link, g_strerror(failed));
        return;
    }
    uint8_t hello[FRAME_HELLO_SIZE];
    frame_hello(FRAME_CLIENT, hello);
    link->state = LINK_GREETING;
    link->writing = true; // as it was polled until now
    append(link, hello, sizeof hello);
    flush(link);
}

static void start_connecting(struct link *link)
{
    link->socket = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (link->socket < 0) {
        wait_for_hub(link, g_strerror(errno));
        return;
    }
    link_tune(link->socket);
    int failed =
        connect(link->socket, (const struct sockaddr *)&link->address, sizeof link->address) != 0
            ? errno
            : 0;
    if (failed != 0 && failed != EINPROGRESS) {
        wait_for_hub(link, g_strerror(failed));
        return;
    }
    link->state = LINK_CONNECTING;
    watch(link, EPOLLOUT, EPOLL_CTL_ADD);
    set_timer(link, LINK_GREETING_MS, false);
}

static void come_up(struct link *link)
{
    char name[INET_ADDRSTRLEN + 8];
    name_hub(link, name);
    set_timer(link, 0, false);
    link->state = LINK_UP;
    link->retry_ms = LINK_RETRY_MIN_MS;
    if (link->noted)
        log_note("the hub at %s is there", name);
    link->noted = false;
    for (size_t i = 0; i < link->channel_count; i++)
        subscribe_at_hub(link, link->channels[i]);
    flush(link);
}

// ---- Receiving ----

static void consume(struct link *link, size_t size)
{
    link->input_first += size;
    link->input_size -= size;
    if (link->input_size == 0)
        link->input_first = 0;
}

static void hand_on(struct link *link, const struct frame *frame)
{
    char channel[FRAME_CHANNEL_MAX + 1];
    memcpy(channel, frame->name, frame->name_size);
    channel[frame->name_size] = '\0';
    link->reading = true;
    link->handler(link->user, channel, frame->data, frame->data_size);
    link->reading = false;
}

static void read_hello(struct link *link)
{
    if (link->input_size < FRAME_HELLO_SIZE)
        return;
    if (!frame_is_hello(FRAME_HUB, link->input + link->input_first)) {
        wait_for_hub(link, "something else answers at this port");
        return;
    }
    consume(link, FRAME_HELLO_SIZE);
    come_up(link);
}

// Hands on what is whole; returns how many messages that were.
static size_t read_frames(struct link *link, size_t limit)
{
    size_t handled = 0;
    while (link->state == LINK_UP && handled < limit) {
        struct frame frame;
        size_t skipped = MIN(link->skip, link->input_size);
        link->skip -= skipped;
        consume(link, skipped);
        enum frame_result result = frame_read(FRAME_HUB, link->input + link->input_first,
                                              link->input_size, WIRE_MTU_MAX, &frame);
        if (result == FRAME_CUT)
            return handled;
        if (result == FRAME_WRONG) {
            wait_for_hub(link, "it does not speak LCM's protocol");
            return handled;
        }
        if (result == FRAME_WHOLE) {
            hand_on(link, &frame);
            handled++;
            consume(link, frame.size);
        } else {
            link->skip = frame.size;
        }
    }
    return handled;
}

// Fills the input; false when nothing more is to be had now.
static bool fill(struct link *link)
{
    if (link->input_first > 0) {
        memmove(link->input, link->input + link->input_first, link->input_size);
        link->input_first = 0;
    }
    ssize_t got = recv(link->socket, link->input + link->input_size,
                       LINK_INPUT_SIZE - link->input_size, MSG_DONTWAIT);
    if (got > 0) {
        link->input_size += (size_t)got;
        return true;
    }
    if (got == 0)
        wait_for_hub(link, "it has closed the connection");
    else if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
        wait_for_hub(link, g_strerror(errno));
    return false;
}

// ---- Dispatching ----

static bool timer_rang(struct link *link)
{
    uint64_t rings;
    return read(link->timer, &rings, sizeof rings) == sizeof rings;
}

static void tick(struct link *link)
{
    if (link->state == LINK_WAITING)
        start_connecting(link);
    else if (link->state == LINK_CONNECTING || link->state == LINK_GREETING)
        wait_for_hub(link, "no answer");
}

static uint32_t socket_events(struct link *link)
{
    struct pollfd ready = {.fd = link->socket, .events = POLLIN | POLLOUT};
    return link->socket >= 0 && poll(&ready, 1, 0) > 0 ? (uint32_t)ready.revents : 0;
}

size_t link_dispatch(struct link *link, size_t limit)
{
    assert(!link->reading);
    if (link->broken)
        wait_for_hub(link, "the connection is lost");
    if (timer_rang(link))
        tick(link);
    uint32_t events = socket_events(link);
    if (link->state == LINK_CONNECTING && (events & (POLLOUT | POLLERR | POLLHUP)) != 0)
        greet(link);
    if (link->state == LINK_GREETING && (events & (POLLIN | POLLERR | POLLHUP)) != 0 && fill(link))
        read_hello(link);
    if (link->writing && link->state >= LINK_GREETING)
        flush(link);
    size_t handled = link->state == LINK_UP ? read_frames(link, limit) : 0;
    while (link->state == LINK_UP && handled < limit && fill(link))
        handled += read_frames(link, limit - handled);
    // Whole messages may be left in the input, which no descriptor shows.
    if (link->state == LINK_UP && handled >= limit)
        set_timer(link, 0, true);
    return handled;
}

void link_subscribe(struct link *link, const char *channel)
{
    for (size_t i = 0; i < link->channel_count; i++)
        if (strcmp(link->channels[i], channel) == 0)
            return;
    assert(link->channel_count < CHANNELS_MAX);
    link->channels[link->channel_count++] = channel;
    if (link->state != LINK_UP)
        return;
    subscribe_at_hub(link, channel);
    flush(link);
}

bool link_send(struct link *link, const char *channel, const uint8_t *data, size_t size)
{
    uint8_t head[FRAME_HEAD_MAX];
    size_t sent = 0;
    if (link->state != LINK_UP || link->broken)
        return false;
    size_t head_size = frame_head(head, FRAME_PUBLISH, channel, strlen(channel), size);
    if (!make_room(link, head_size + size))
        return false;
    if (link->output_size == 0) {
        struct iovec parts[] = {{head, head_size}, {(void *)(uintptr_t)data, size}};
        struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
        ssize_t taken = sendmsg(link->socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (taken < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
            link->broken = true; // its descriptor shows that, so that link_dispatch() is called
            return false;
        }
        sent = taken > 0 ? (size_t)taken : 0;
    }
    if (sent == head_size + size)
        return true;
    if (sent < head_size)
        append(link, head + sent, head_size - sent);
    size_t data_sent = sent > head_size ? sent - head_size : 0;
    append(link, data + data_sent, size - data_sent);
    if (!link->writing)
        watch(link, EPOLLIN | EPOLLOUT, EPOLL_CTL_MOD);
    link->writing = true;
    return true;
}

int link_descriptor(const struct link *link)
{
    return link->epoll;
}

bool link_is_up(const struct link *link)
{
    return link->state == LINK_UP;
}

void link_reopen(struct link *link)
{
    if (link->state != LINK_UP)
        return; // it is at it
    link->retry_ms = LINK_RETRY_MIN_MS;
    wait_for_hub(link, "nothing comes from it");
}

enum status link_open(struct link **opened, const struct sockaddr_in *address,
                      link_handler *handler, void *user, struct error *error)
{
    struct link *link = g_new0(struct link, 1);
    link->address = *address;
    link->handler = handler;
    link->user = user;
    link->socket = -1;
    link->retry_ms = LINK_RETRY_MIN_MS;
    link->output = g_malloc(LINK_OUTPUT_MAX);
    link->epoll = epoll_create1(EPOLL_CLOEXEC);
    link->timer = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
    *opened = link;
    struct epoll_event event = {.events = EPOLLIN, .data.fd = link->timer};
    if (link->epoll < 0 || link->timer < 0 ||
        epoll_ctl(link->epoll, EPOLL_CTL_ADD, link->timer, &event) != 0) {
        link_close(link);
        *opened = NULL;
        return error_set(error, STATUS_NETWORK, "cannot wait for the hub: %s", g_strerror(errno));
    }
    start_connecting(link);
    return STATUS_OK;
}

void link_wait(struct link *link, int ms)
{
    struct pollfd ready = {.fd = link->epoll, .events = POLLIN};
    while (link->state > LINK_WAITING && link->state < LINK_UP && poll(&ready, 1, ms) > 0)
        link_dispatch(link, 0);
    if (link->state > LINK_WAITING && link->state < LINK_UP)
        wait_for_hub(link, "no answer");
}

void link_close(struct link *link)
{
    if (link == NULL)
        return;
    if (link->socket >= 0)
        close(link->socket);
    if (link->timer >= 0)
        close(link->timer);
    if (link->epoll >= 0)
        close(link->epoll);
    g_free(link->output);
    g_free(link);
}
