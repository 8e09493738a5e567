#include "common/wire/guard.h"

#include "common/wire/check.h"

#include <arpa/inet.h>
#include <assert.h>
#include <fcntl.h>
#include <glib.h>
#include <linux/filter.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    UDP_HEADER_SIZE = 8, // a socket filter counts from here
    LCM_HEADER_SIZE = 8, // "LC02" and LCM's own sequence number
    CHANNEL_PLACE = UDP_HEADER_SIZE + LCM_HEADER_SIZE,
    LCM_DESCRIPTORS = 8, // an lcm_t that listens opens six
    CODE_SIZE = 96,      // instructions of the longest filter
    SELF_TEST_SIZE = 64, // [bytes] of a self test's content, at most
    DRAIN_WAIT_US = 200,
    DRAIN_WAITS = 500, // a tenth of a second
};

#define LCM_MAGIC 0x4c433032 // "LC02": a whole message
#define SELF_TEST_CHANNEL "LCM_SELF_TEST"

// ---- Descriptors ----

void guard_look(struct guard_descriptors *descriptors)
{
    *descriptors = (struct guard_descriptors){0};
    for (int fd = 0; fd < GUARD_DESCRIPTORS; fd++)
        if (fcntl(fd, F_GETFD) >= 0)
            descriptors->open[fd / 64] |= UINT64_C(1) << (fd % 64);
}

static bool was_open(const struct guard_descriptors *descriptors, int fd)
{
    return (descriptors->open[fd / 64] >> (fd % 64) & 1) != 0;
}

bool guard_room(void)
{
    struct guard_descriptors now;
    guard_look(&now);
    int open = 0;
    for (unsigned i = 0; i < GUARD_DESCRIPTORS / 64; i++)
        open += __builtin_popcountll(now.open[i]);
    // The kernel gives the lowest free numbers, so room below the limit is all it takes.
    return open + LCM_DESCRIPTORS <= GUARD_DESCRIPTORS;
}

static bool is_bound_datagram(int fd, uint16_t port)
{
    int type = 0;
    struct sockaddr_in address = {0};
    socklen_t type_size = sizeof type, address_size = sizeof address;
    return getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &type_size) == 0 && type == SOCK_DGRAM &&
           getsockname(fd, (struct sockaddr *)&address, &address_size) == 0 &&
           address.sin_family == AF_INET && ntohs(address.sin_port) == port;
}

int guard_claim(const struct guard_descriptors *before, uint16_t port)
{
    int found = -1;
    for (int fd = 0; fd < GUARD_DESCRIPTORS; fd++) {
        int flags = was_open(before, fd) ? -1 : fcntl(fd, F_GETFD);
        if (flags < 0)
            continue;
        fcntl(fd, F_SETFD, flags | FD_CLOEXEC);
        if (is_bound_datagram(fd, port))
            found = fd;
    }
    return found;
}

// ---- Filter ----

struct filter {
    struct sock_filter code[CODE_SIZE];
    unsigned short length;
};

static void emit(struct filter *filter, struct sock_filter instruction)
{
    assert(filter->length < CODE_SIZE);
    filter->code[filter->length++] = instruction;
}

// A load and a comparison for every 4, 2 or 1 bytes of the name.
static unsigned chunk_size(size_t left)
{
    return left >= 4 ? 4 : left >= 2 ? 2 : 1;
}

static unsigned chunk_count(size_t size)
{
    return (unsigned)(size / 4 + (size % 4) / 2 + size % 2);
}

static void emit_chunk(struct filter *filter, const char *name, uint32_t at, unsigned size,
                       uint8_t otherwise)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < size; i++)
        value = value << 8 | (uint8_t)name[at + i];
    uint16_t width = size == 4 ? BPF_W : size == 2 ? BPF_H : BPF_B;
    emit(filter,
         (struct sock_filter)BPF_STMT((uint16_t)(BPF_LD | BPF_ABS | width), CHANNEL_PLACE + at));
    emit(filter, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, otherwise));
}

// Accepts a packet whose channel is `name`, its NUL included, with `least` to `most` bytes behind
// it; rejects one of another size; goes on to the next instruction with one of another channel.
static void emit_channel(struct filter *filter, const char *name, size_t least, size_t most)
{
    size_t size = strlen(name) + 1;
    unsigned tail = 5; // instructions after the last comparison
    unsigned chunks = chunk_count(size);
    for (size_t at = 0; at < size;) {
        unsigned chunk = chunk_size(size - at);
        chunks--;
        emit_chunk(filter, name, (uint32_t)at, chunk, (uint8_t)(2 * chunks + tail));
        at += chunk;
    }
    uint32_t place = (uint32_t)(CHANNEL_PLACE + size);
    emit(filter, (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0));
    emit(filter,
         (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, place + (uint32_t)least, 0, 2));
    emit(filter,
         (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, place + (uint32_t)most, 1, 0));
    emit(filter, (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, UINT32_MAX));
    emit(filter, (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, 0));
}

// A load beyond the packet's end rejects it, so short packets need no check of their own.
static void write_filter(struct filter *filter, unsigned index)
{
    filter->length = 0;
    emit(filter, (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, UDP_HEADER_SIZE));
    emit(filter, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, LCM_MAGIC, 1, 0));
    emit(filter, (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, 0));
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        if (check_kind(kind)->port == index)
            emit_channel(filter, check_kind(kind)->channel, CHECK_FOREIGN_SIZE_MIN,
                         check_kind(kind)->unit != 0 ? WIRE_MTU_MAX : CHECK_FOREIGN_SIZE_MAX);
    // Others' self tests are ignored by LCM; let through, they do not count as dropped.
    emit_channel(filter, SELF_TEST_CHANNEL, 0, SELF_TEST_SIZE);
    emit(filter, (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, 0));
}

static void memory(int socket, uint32_t values[SK_MEMINFO_VARS])
{
    socklen_t size = SK_MEMINFO_VARS * sizeof values[0];
    memset(values, 0, size);
    getsockopt(socket, SOL_SOCKET, SO_MEMINFO, values, &size);
}

// LCM's thread reads what had been received before the filter stood; it does so at once.
static void drain(int socket)
{
    uint32_t values[SK_MEMINFO_VARS];
    for (unsigned waits = 0; waits < DRAIN_WAITS; waits++) {
        memory(socket, values);
        g_usleep(DRAIN_WAIT_US); // also for the packet that the thread has in hand
        if (values[SK_MEMINFO_RMEM_ALLOC] == 0)
            return;
    }
}

static bool attach(int socket, unsigned index)
{
    struct filter filter;
    write_filter(&filter, index);
    struct sock_fprog program = {.len = filter.length, .filter = filter.code};
    return setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

// The kernel doubles what it grants; the second call goes beyond its limit where the process may.
static void size_buffer(int socket, int32_t wanted)
{
    setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &wanted, sizeof wanted);
    if (guard_buffer(socket) < (uint32_t)wanted)
        setsockopt(socket, SOL_SOCKET, SO_RCVBUFFORCE, &wanted, sizeof wanted);
}

// ---- Arming ----

static bool stand(struct guard *guard, int socket)
{
    if (!attach(socket, guard->index))
        return false;
    size_buffer(socket, guard->buffer);
    guard->socket = socket;
    return true;
}

// LCM warns that its receive buffer is small: its socket is open and not yet bound.
static void on_warning(const gchar *domain, GLogLevelFlags level, const gchar *text, gpointer user)
{
    struct guard *guard = user;
    if (g_thread_self() != guard->thread) {
        g_log_default_handler(domain, level, text, NULL);
        return;
    }
    for (int fd = 0; fd < GUARD_DESCRIPTORS && guard->socket < 0; fd++)
        if (!was_open(&guard->before, fd) && is_bound_datagram(fd, 0))
            stand(guard, fd);
}

void guard_arm(struct guard *guard, unsigned index, uint16_t port, int32_t buffer)
{
    *guard = (struct guard){
        .index = index, .port = port, .buffer = buffer, .socket = -1, .thread = g_thread_self()};
    guard_look(&guard->before);
    // The warning is wanted, so it must not be fatal, whatever G_DEBUG says.
    guard->log_fatal = g_log_set_always_fatal(G_LOG_LEVEL_ERROR);
    guard->log_handler = g_log_set_default_handler(on_warning, guard);
}

int guard_disarm(struct guard *guard)
{
    g_log_set_default_handler(guard->log_handler, NULL);
    g_log_set_always_fatal(guard->log_fatal);
    int socket = guard_claim(&guard->before, guard->port);
    if (socket < 0 || socket == guard->socket)
        return socket;
    if (!stand(guard, socket))
        return -1;
    drain(socket);
    return socket;
}

uint32_t guard_dropped(int socket)
{
    uint32_t values[SK_MEMINFO_VARS];
    memory(socket, values);
    return values[SK_MEMINFO_DROPS];
}

uint32_t guard_buffer(int socket)
{
    int granted = 0;
    socklen_t size = sizeof granted;
    getsockopt(socket, SOL_SOCKET, SO_RCVBUF, &granted, &size);
    return (uint32_t)granted;
}
