#include "common/wire/probe.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/filter.h>
#include <poll.h>
#include <sodium.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

// What a probe looks like on the network: a packet on the channel of LCM's own self test, which
// nobody else listens to, and a random number by which it is known again.
struct probe_packet {
    uint32_t magic;
    uint32_t sequence;
    char channel[16];
    uint32_t nonce;
};
_Static_assert(sizeof(struct probe_packet) == 28, "a packet has no holes: reorder its fields");

enum status probe_route(const struct url *url, struct error *error)
{
    struct sockaddr_in group = url_socket_address(url, 0);
    int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (probe < 0)
        return error_set(error, STATUS_NETWORK, "cannot open a socket: %s", strerror(errno));
    int failed = connect(probe, (const struct sockaddr *)&group, sizeof group) != 0 ? errno : 0;
    close(probe);
    if (failed == ENETUNREACH || failed == EHOSTUNREACH)
        return error_set(error, STATUS_NETWORK,
                         "no route for multicast to %s: connect this machine to a network, or keep "
                         "multicast inside it with (as root) 'ip link set lo up; ip route add "
                         "%s/32 dev lo'",
                         url->address, url->address);
    if (failed != 0)
        return error_set(error, STATUS_NETWORK, "multicast to %s is not possible: %s", url->address,
                         strerror(failed));
    return STATUS_OK;
}

// Lets through only the packet with this number, so that traffic on the port is not in the way.
static void filter_nonce(int probe, uint32_t nonce)
{
    // The filter counts from the UDP header (8 bytes) on.
    uint32_t place = 8 + (uint32_t)offsetof(struct probe_packet, nonce);
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, place),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ntohl(nonce), 1, 0),
        BPF_STMT(BPF_RET | BPF_K, 0),
        BPF_STMT(BPF_RET | BPF_K, UINT32_MAX),
    };
    struct sock_fprog program = {.len = sizeof code / sizeof code[0], .filter = code};
    setsockopt(probe, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);
}

static enum status bind_port(int probe, const struct sockaddr_in *group, struct error *error)
{
    int on = 1;
    unsigned port = ntohs(group->sin_port);
    struct sockaddr_in any = {.sin_family = AF_INET, .sin_port = group->sin_port};
    setsockopt(probe, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(probe, (const struct sockaddr *)&any, sizeof any) == 0)
        return STATUS_OK;
    if (errno == EADDRINUSE)
        return error_set(error, STATUS_NETWORK,
                         "port %u is in use by a program that does not share it: 'ss -ulpn sport = "
                         ":%u' shows which; end it or choose another port in the LCM URL",
                         port, port);
    return error_set(error, STATUS_NETWORK, "cannot listen on port %u: %s", port, strerror(errno));
}

static enum status join_group(int probe, const struct sockaddr_in *group, int ttl,
                              struct error *error)
{
    struct ip_mreq membership = {.imr_multiaddr = group->sin_addr};
    setsockopt(probe, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    if (setsockopt(probe, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0)
        return STATUS_OK;
    return error_set(error, STATUS_NETWORK, "cannot join the multicast group %s: %s",
                     inet_ntoa(group->sin_addr), strerror(errno));
}

static enum status echo(int probe, const struct sockaddr_in *group,
                        const struct probe_packet *packet, struct error *error)
{
    unsigned port = ntohs(group->sin_port);
    for (unsigned sends = 0; sends < PROBE_SENDS; sends++) {
        struct pollfd ready = {.fd = probe, .events = POLLIN};
        ssize_t sent =
            sendto(probe, packet, sizeof *packet, 0, (const struct sockaddr *)group, sizeof *group);
        if (sent < 0 && errno != ENOBUFS && errno != EAGAIN)
            return error_set(error, STATUS_NETWORK, "cannot send multicast to %s port %u: %s%s",
                             inet_ntoa(group->sin_addr), port, strerror(errno),
                             errno == EPERM ? " (a firewall?)" : "");
        if (poll(&ready, 1, PROBE_RESEND_MS) > 0)
            return STATUS_OK;
    }
    return error_set(error, STATUS_NETWORK,
                     "multicast sent to %s port %u does not come back: a firewall drops it; let "
                     "UDP to this port in ('nft list ruleset' or 'iptables -L' shows the rules)",
                     inet_ntoa(group->sin_addr), port);
}

// With a nonce it hears only the packet with this number, from the start.
static enum status open_probe(int *probe, const struct sockaddr_in *group, int ttl,
                              const uint32_t *nonce, struct error *error)
{
    *probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (*probe < 0)
        return error_set(error, STATUS_NETWORK, "cannot open a socket: %s", strerror(errno));
    if (nonce != NULL)
        filter_nonce(*probe, *nonce);
    enum status status = bind_port(*probe, group, error);
    if (status == STATUS_OK)
        status = join_group(*probe, group, ttl, error);
    if (status == STATUS_OK)
        return STATUS_OK;
    close(*probe);
    *probe = -1;
    return status;
}

enum status probe_join(int *joined, const struct url *url, unsigned index, int ttl,
                       struct error *error)
{
    struct sockaddr_in group = url_socket_address(url, index);
    return open_probe(joined, &group, ttl, NULL, error);
}

enum status probe_port(const struct url *url, unsigned index, struct error *error)
{
    struct sockaddr_in group = url_socket_address(url, index);
    struct probe_packet packet = {
        .magic = htonl(0x4c433032), .channel = "LCM_SELF_TEST", .nonce = randombytes_random()};
    int probe;
    enum status status = open_probe(&probe, &group, 0, &packet.nonce, error);
    if (status != STATUS_OK)
        return status;
    status = echo(probe, &group, &packet, error);
    close(probe);
    return status;
}
