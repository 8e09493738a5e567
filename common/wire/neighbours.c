#include "common/wire/neighbours.h"

#include "common/base/clock.h"
#include "common/wire/check.h"
#include "common/wire/probe.h"
#include "common/wire/seal.h"

#include <errno.h>
#include <ifaddrs.h>
#include <poll.h>
#include <sodium.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define LCM_MAGIC 0x4c433032u // "LC02": a whole message
#define CALL_CHANNEL "LCM_SELF_TEST"
#define CALL_MARK "sobox-check" // with its NUL 12 bytes

enum { LCM_HEADER_SIZE = 8, NAMED_MAX = 8, PACKET_MAX = 65536, OWN_MAX = 64 };

_Static_assert(NEIGHBOURS_CALL_SIZE ==
                   LCM_HEADER_SIZE + sizeof CALL_CHANNEL + sizeof CALL_MARK + 4 + 4 * NAMED_MAX,
               "a call is its header, channel, mark, number and those heard: adapt its size");

static void put_word(uint8_t *at, uint32_t value)
{
    value = htonl(value);
    memcpy(at, &value, sizeof value);
}

static uint32_t get_word(const uint8_t *at)
{
    uint32_t value;
    memcpy(&value, at, sizeof value);
    return ntohl(value);
}

// ---- Packets ----

size_t neighbours_call(const struct neighbours *neighbours, uint32_t nonce,
                       uint8_t packet[NEIGHBOURS_CALL_SIZE])
{
    uint8_t *at = packet + LCM_HEADER_SIZE;
    memset(packet, 0, NEIGHBOURS_CALL_SIZE);
    put_word(packet, LCM_MAGIC);
    memcpy(at, CALL_CHANNEL, sizeof CALL_CHANNEL);
    at += sizeof CALL_CHANNEL;
    memcpy(at, CALL_MARK, sizeof CALL_MARK);
    at += sizeof CALL_MARK;
    put_word(at, nonce);
    unsigned named = 0;
    for (size_t i = 0; i < neighbours->count && named < NAMED_MAX; i++)
        if (neighbours->list[i].nonce != 0)
            put_word(at + 4 * ++named, neighbours->list[i].nonce);
    return NEIGHBOURS_CALL_SIZE;
}

static struct neighbour *find(struct neighbours *neighbours, struct in_addr from)
{
    for (size_t i = 0; i < neighbours->count; i++)
        if (neighbours->list[i].address.s_addr == from.s_addr)
            return &neighbours->list[i];
    if (neighbours->count == NEIGHBOURS_MAX)
        return NULL;
    struct neighbour *fresh = &neighbours->list[neighbours->count++];
    *fresh = (struct neighbour){.address = from};
    return fresh;
}

static void take_call(struct neighbour *neighbour, const uint8_t *data, size_t size, uint32_t nonce)
{
    const uint8_t *at = data + sizeof CALL_MARK;
    if (size != sizeof CALL_MARK + 4 + 4 * NAMED_MAX ||
        memcmp(data, CALL_MARK, sizeof CALL_MARK) != 0)
        return;
    if (neighbour->nonce != get_word(at))
        neighbour->calls = 0; // it began anew
    neighbour->nonce = get_word(at);
    neighbour->calls++;
    for (unsigned i = 1; i <= NAMED_MAX; i++)
        neighbour->hears_us |= get_word(at + 4 * i) == nonce;
}

static void take_message(struct neighbour *neighbour, enum wire_kind kind, const uint8_t *data,
                         size_t size, const struct key *key)
{
    static uint8_t opened[PACKET_MAX];
    struct seal_origin origin;
    neighbour->worker |= kind == WIRE_WORKER_STATUS;
    neighbour->coordinator |= kind == WIRE_RUN_STATUS || kind == WIRE_SEARCH_STATUS;
    bool sealed = seal_is(data, size);
    neighbour->sealed |= sealed;
    neighbour->clear |= !sealed;
    neighbour->opened |= sealed && key != NULL &&
                         seal_open(opened, data, size, check_kind(kind)->channel, key, &origin);
}

void neighbours_take(struct neighbours *neighbours, struct in_addr from, unsigned index,
                     const uint8_t *packet, size_t size, uint32_t nonce, const struct key *key)
{
    if (size <= LCM_HEADER_SIZE || size > PACKET_MAX || get_word(packet) != LCM_MAGIC)
        return;
    const char *channel = (const char *)packet + LCM_HEADER_SIZE;
    size_t name_size = strnlen(channel, size - LCM_HEADER_SIZE) + 1;
    if (name_size > size - LCM_HEADER_SIZE)
        return;
    struct neighbour *neighbour = find(neighbours, from);
    if (neighbour == NULL)
        return;
    const uint8_t *data = packet + LCM_HEADER_SIZE + name_size;
    size_t data_size = size - LCM_HEADER_SIZE - name_size;
    neighbour->heard[index] = true;
    if (strcmp(channel, CALL_CHANNEL) == 0)
        take_call(neighbour, data, data_size, nonce);
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        if (strcmp(channel, check_kind(kind)->channel) == 0)
            take_message(neighbour, kind, data, data_size, key);
}

// ---- Sockets ----

struct look {
    struct pollfd ports[NEIGHBOURS_PORTS];
    struct in_addr own[OWN_MAX];
    size_t own_count;
    uint32_t nonce;
};

static void list_own(struct look *look)
{
    struct ifaddrs *all = NULL;
    if (getifaddrs(&all) != 0)
        return;
    for (struct ifaddrs *one = all; one != NULL && look->own_count < OWN_MAX; one = one->ifa_next)
        if (one->ifa_addr != NULL && one->ifa_addr->sa_family == AF_INET)
            look->own[look->own_count++] = ((struct sockaddr_in *)(void *)one->ifa_addr)->sin_addr;
    freeifaddrs(all);
}

// Where multicast leaves by loopback it comes from nowhere.
static bool is_own(const struct look *look, struct in_addr address)
{
    if (address.s_addr == INADDR_ANY)
        return true;
    for (size_t i = 0; i < look->own_count; i++)
        if (look->own[i].s_addr == address.s_addr)
            return true;
    return false;
}

static void call_out(const struct look *look, const struct neighbours *neighbours,
                     const struct url *url)
{
    uint8_t packet[NEIGHBOURS_CALL_SIZE];
    size_t size = neighbours_call(neighbours, look->nonce, packet);
    for (unsigned i = 0; i < NEIGHBOURS_PORTS; i++) {
        struct sockaddr_in group = url_socket_address(url, i);
        sendto(look->ports[i].fd, packet, size, 0, (const struct sockaddr *)&group, sizeof group);
    }
}

static void listen_once(const struct look *look, unsigned index, struct neighbours *neighbours,
                        const struct key *key)
{
    static uint8_t packet[PACKET_MAX];
    struct sockaddr_in from = {0};
    socklen_t from_size = sizeof from;
    ssize_t size = recvfrom(look->ports[index].fd, packet, sizeof packet, MSG_DONTWAIT,
                            (struct sockaddr *)&from, &from_size);
    if (size > 0 && !is_own(look, from.sin_addr))
        neighbours_take(neighbours, from.sin_addr, index, packet, (size_t)size, look->nonce, key);
}

static void listen_for(struct look *look, struct neighbours *neighbours, const struct key *key,
                       int milliseconds)
{
    int64_t end_ns = clock_monotonic_ns() + milliseconds * CLOCK_MILLISECOND_NS, now_ns;
    while ((now_ns = clock_monotonic_ns()) < end_ns) {
        int left_ms = (int)((end_ns - now_ns) / CLOCK_MILLISECOND_NS) + 1;
        if (poll(look->ports, NEIGHBOURS_PORTS, left_ms) <= 0)
            continue;
        for (unsigned i = 0; i < NEIGHBOURS_PORTS; i++)
            if (look->ports[i].revents != 0)
                listen_once(look, i, neighbours, key);
    }
}

enum status neighbours_look(struct neighbours *neighbours, const struct url *url,
                            const struct key *key, int milliseconds, struct error *error)
{
    struct look look = {.nonce = randombytes_random() | 1};
    enum status status = STATUS_OK;
    *neighbours = (struct neighbours){0};
    for (unsigned i = 0; i < NEIGHBOURS_PORTS; i++)
        look.ports[i] = (struct pollfd){.fd = -1, .events = POLLIN};
    for (unsigned i = 0; i < NEIGHBOURS_PORTS && status == STATUS_OK; i++)
        status = probe_join(&look.ports[i].fd, url, i, url->ttl, error);
    list_own(&look);
    for (int left_ms = milliseconds; left_ms > 0 && status == STATUS_OK;
         left_ms -= NEIGHBOURS_CALL_MS) {
        call_out(&look, neighbours, url);
        listen_for(&look, neighbours, key, NEIGHBOURS_CALL_MS);
    }
    for (unsigned i = 0; i < NEIGHBOURS_PORTS; i++)
        if (look.ports[i].fd >= 0)
            close(look.ports[i].fd);
    return status;
}
