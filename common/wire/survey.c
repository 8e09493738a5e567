#include "common/wire/survey.h"

#include "common/wire/neighbours.h"
#include "common/wire/probe.h"
#include "common/wire/survey_state.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sodium.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    TEXT_SIZE = 1024,
    BUFFER_ADVISED = 1000000, // [bytes] below this bursts of outcomes are lost
    FRAME_SIZE = 1500,        // [bytes] an Ethernet frame; messages are made to fit it
};

static const char *const traffic[NEIGHBOURS_PORTS] = {"batches", "outcomes", "status"};

void survey_say(struct survey *survey, enum survey_verdict verdict, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    survey->wrong += verdict == SURVEY_WRONG;
    survey->tell(survey->user, verdict, text);
}

// ---- Route and interface ----

// Where packets to the group leave: what 'ip route get GROUP' says.
struct place {
    char name[IF_NAMESIZE];
    unsigned flags;
    int frame_size; // [bytes]
};

// Asks the kernel for the number of the interface; 0 when it does not say. (The address from which
// a packet would leave does not tell: loopback has none for multicast.)
static int find_interface(struct in_addr group)
{
    struct {
        struct nlmsghdr head;
        struct rtmsg route;
        struct rtattr to;
        struct in_addr group;
    } question = {
        .head = {.nlmsg_len = sizeof question,
                 .nlmsg_type = RTM_GETROUTE,
                 .nlmsg_flags = NLM_F_REQUEST},
        .route = {.rtm_family = AF_INET, .rtm_dst_len = 32},
        .to = {.rta_len = RTA_LENGTH(sizeof group), .rta_type = RTA_DST},
        .group = group,
    };
    _Alignas(struct nlmsghdr) char answer[4096];
    int interface = 0, netlink = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    if (netlink < 0)
        return 0;
    ssize_t size = -1;
    if (send(netlink, &question, sizeof question, 0) == sizeof question)
        size = recv(netlink, answer, sizeof answer, 0);
    close(netlink);
    const struct nlmsghdr *head = (const struct nlmsghdr *)answer;
    if (size < (ssize_t)NLMSG_LENGTH(sizeof(struct rtmsg)) || head->nlmsg_type != RTM_NEWROUTE)
        return 0;
    int left = (int)RTM_PAYLOAD(head);
    for (struct rtattr *one = RTM_RTA(NLMSG_DATA(head)); RTA_OK(one, left);
         one = RTA_NEXT(one, left))
        if (one->rta_type == RTA_OIF)
            memcpy(&interface, RTA_DATA(one), sizeof interface);
    return interface;
}

static bool find_place(const struct url *url, struct place *place)
{
    struct ifreq request = {0};
    int interface = find_interface(url_socket_address(url, 0).sin_addr);
    if (interface == 0 || if_indextoname((unsigned)interface, request.ifr_name) == NULL)
        return false;
    snprintf(place->name, sizeof place->name, "%s", request.ifr_name);
    int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool found = probe >= 0 && ioctl(probe, SIOCGIFFLAGS, &request) == 0;
    place->flags = (unsigned short)request.ifr_flags;
    found = found && ioctl(probe, SIOCGIFMTU, &request) == 0;
    place->frame_size = request.ifr_mtu;
    if (probe >= 0)
        close(probe);
    return found;
}

// An interface that leads to others, for advice; "eth0" when this machine has none.
static void find_way_out(char name[IF_NAMESIZE])
{
    struct ifaddrs *all = NULL;
    snprintf(name, IF_NAMESIZE, "eth0");
    if (getifaddrs(&all) != 0)
        return;
    for (struct ifaddrs *one = all; one != NULL; one = one->ifa_next)
        if (one->ifa_addr != NULL && one->ifa_addr->sa_family == AF_INET &&
            (one->ifa_flags & IFF_LOOPBACK) == 0 && (one->ifa_flags & IFF_UP) != 0) {
            snprintf(name, IF_NAMESIZE, "%s", one->ifa_name);
            break;
        }
    freeifaddrs(all);
}

static void say_interface(struct survey *survey, const struct place *place)
{
    const char *group = survey->url->address;
    char way_out[IF_NAMESIZE];
    find_way_out(way_out);
    if ((place->flags & IFF_LOOPBACK) != 0 && survey->url->ttl > 0)
        survey_say(survey, SURVEY_WRONG,
                   "multicast to %s goes to %s and reaches no other machine: 'ip route replace "
                   "239.0.0.0/8 dev %s' (root; 'ip -br address' shows the interfaces) sends it out",
                   group, place->name, way_out);
    else
        survey_say(survey, SURVEY_GOOD, "multicast to %s leaves by %s", group, place->name);
    if ((place->flags & (IFF_LOOPBACK | IFF_MULTICAST)) == 0)
        survey_say(survey, SURVEY_WRONG,
                   "%s is set to carry no multicast: 'ip link set %s multicast on' (root)",
                   place->name, place->name);
    if (place->frame_size < FRAME_SIZE)
        survey_say(
            survey, SURVEY_NOTE,
            "%s carries frames of %d bytes: messages of up to 1,428 with their headers travel "
            "in pieces, of which none may be lost",
            place->name, place->frame_size);
}

// Whether there is a route; `outwards` becomes whether it leads to other machines.
static bool look_at_route(struct survey *survey, bool *outwards)
{
    struct error error = {0};
    struct place place = {0};
    if (probe_route(survey->url, &error) != STATUS_OK) {
        survey_say(survey, SURVEY_WRONG, "%s", error.text);
        return false;
    }
    bool found = find_place(survey->url, &place);
    if (found)
        say_interface(survey, &place);
    *outwards = survey->url->ttl > 0 && !(found && (place.flags & IFF_LOOPBACK) != 0);
    return true;
}

static void look_at_ttl(struct survey *survey)
{
    unsigned ttl = survey->url->ttl;
    if (ttl == 0)
        survey_say(survey, SURVEY_NOTE,
                   "ttl=0: messages stay on this machine; '?ttl=1' in the URL lets them reach the "
                   "others of its network");
    else if (ttl == 1)
        survey_say(survey, SURVEY_GOOD,
                   "ttl=1: messages reach the machines of this network "
                   "segment, and cross no router");
    else
        survey_say(survey, SURVEY_GOOD,
                   "ttl=%u: messages cross up to %u routers, where these route multicast", ttl,
                   ttl - 1);
}

// ---- Buffer and ports ----

static void look_at_buffer(struct survey *survey)
{
    int wanted = survey->url->receive_buffer, granted = 0;
    socklen_t size = sizeof granted;
    int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (probe < 0)
        return;
    setsockopt(probe, SOL_SOCKET, SO_RCVBUF, &wanted, sizeof wanted);
    getsockopt(probe, SOL_SOCKET, SO_RCVBUF, &granted, &size);
    if (granted < wanted) // as the programs do it: who may goes beyond the limit
        setsockopt(probe, SOL_SOCKET, SO_RCVBUFFORCE, &wanted, sizeof wanted);
    getsockopt(probe, SOL_SOCKET, SO_RCVBUF, &granted, &size);
    close(probe);
    if (wanted < BUFFER_ADVISED / 2)
        survey_say(survey, SURVEY_NOTE,
                   "recv_buf_size=%d in the URL asks for a receive buffer that loses messages of "
                   "dozens of workers: without it %d are asked for",
                   wanted, URL_RECEIVE_BUFFER_DEFAULT);
    else if (granted < BUFFER_ADVISED)
        survey_say(survey, SURVEY_NOTE,
                   "the kernel grants a receive buffer of %d bytes, which loses messages of dozens "
                   "of workers: 'sysctl -w net.core.rmem_max=%d' (root) raises its limit",
                   granted, wanted);
    else
        survey_say(survey, SURVEY_GOOD, "the kernel grants a receive buffer of %d bytes", granted);
}

static bool look_at_ports(struct survey *survey)
{
    unsigned wrong = 0;
    for (unsigned i = 0; i < NEIGHBOURS_PORTS; i++) {
        struct error error = {0};
        if (probe_port(survey->url, i, &error) == STATUS_OK)
            continue;
        survey_say(survey, SURVEY_WRONG, "%s", error.text);
        wrong++;
    }
    if (wrong == 0)
        survey_say(survey, SURVEY_GOOD,
                   "messages of this machine come back to it on ports %u to %u", survey->url->port,
                   survey->url->port + NEIGHBOURS_PORTS - 1);
    return wrong == 0;
}

// ---- Other machines ----

static void say_key(struct survey *survey, const struct neighbour *neighbour, const char *name)
{
    if (neighbour->sealed && !neighbour->opened)
        survey_say(survey, SURVEY_WRONG, "%s seals its messages with %s: %s", name,
                   survey->key == NULL ? "a key" : "another key",
                   survey->key == NULL ? "give this program the same with --key-file"
                                       : "the same --key-file is needed everywhere");
    if (neighbour->clear && survey->key != NULL)
        survey_say(survey, SURVEY_WRONG,
                   "%s sends messages without a key: the same --key-file is needed everywhere",
                   name);
}

// Which of the ports were not heard; returns `text`.
static const char *missing_ports(struct survey *survey, const struct neighbour *neighbour,
                                 char text[64])
{
    size_t used = 0;
    text[0] = '\0';
    for (unsigned i = 0; i < NEIGHBOURS_PORTS; i++)
        if (!neighbour->heard[i])
            used += (size_t)snprintf(text + used, 64 - used, "%s%u (%s)", used > 0 ? ", " : "",
                                     survey->url->port + i, traffic[i]);
    return text;
}

static void say_neighbour(struct survey *survey, const struct neighbour *neighbour)
{
    char name[INET_ADDRSTRLEN], missing[64];
    inet_ntop(AF_INET, &neighbour->address, name, sizeof name);
    bool sure = neighbour->calls >= NEIGHBOURS_PORTS * NEIGHBOURS_CALLS_SURE / 2;
    if (neighbour->worker || neighbour->coordinator)
        survey_say(survey, SURVEY_GOOD, "%s is heard: %s", name,
                   !neighbour->coordinator ? "a worker"
                   : neighbour->worker     ? "worker and coordinator"
                                           : "a coordinator");
    say_key(survey, neighbour, name);
    if (neighbour->nonce == 0)
        return;
    if (missing_ports(survey, neighbour, missing)[0] != '\0' && sure)
        survey_say(
            survey, SURVEY_WRONG,
            "%s is not heard on port %s: a firewall here or there drops it; let in UDP %u to "
            "%u ('nft add rule inet filter input udp dport %u-%u accept')",
            name, missing, survey->url->port, survey->url->port + 2, survey->url->port,
            survey->url->port + 2);
    if (neighbour->hears_us)
        survey_say(survey, SURVEY_GOOD, "%s hears this machine, and is heard", name);
    else if (sure)
        survey_say(survey, SURVEY_WRONG,
                   "%s is heard but does not hear this machine: a firewall there, or its multicast "
                   "is bound to another interface; see what --check-network says there",
                   name);
    else
        survey_say(survey, SURVEY_NOTE, "%s came or went during the check: try again", name);
}

static void look_at_neighbours(struct survey *survey)
{
    struct error error = {0};
    struct neighbours neighbours;
    if (neighbours_look(&neighbours, survey->url, survey->key, SURVEY_LISTEN_MS, &error) !=
        STATUS_OK) {
        survey_say(survey, SURVEY_WRONG, "%s", error.text);
        return;
    }
    for (size_t i = 0; i < neighbours.count; i++)
        say_neighbour(survey, &neighbours.list[i]);
    if (neighbours.count == 0)
        survey_say(
            survey, SURVEY_NOTE,
            "no other machine was heard in %d s: run this check there at the same time. If "
            "neither hears the other: a firewall, a switch with IGMP snooping but no querier, "
            "or another network; if so, use sobox-hub",
            SURVEY_LISTEN_MS / 1000);
}

unsigned survey_network(const struct url *url, const struct key *key, survey_teller *tell,
                        void *user)
{
    struct survey survey = {.url = url, .key = key, .tell = tell, .user = user};
    bool outwards = false;
    if (sodium_init() < 0)
        survey_say(&survey, SURVEY_WRONG, "libsodium cannot be initialised");
    else if (url->tcpq)
        survey_hub(&survey);
    else if (look_at_route(&survey, &outwards)) {
        if (outwards || url->ttl == 0)
            look_at_ttl(&survey);
        look_at_buffer(&survey);
        if (look_at_ports(&survey) && outwards)
            look_at_neighbours(&survey);
    }
    return survey.wrong;
}
