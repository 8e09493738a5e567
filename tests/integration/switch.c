// switch LOSS TWICE DELAY_MS JITTER_MS PORT...: a network switch in bad weather. What comes in at a
// port goes out at all others; on the way to each it is lost (LOSS percent), comes twice (TWICE
// percent), and is delayed by DELAY_MS and up to JITTER_MS more, so that frames overtake each
// other. It prints its seed, which SEED in the environment sets, and at SIGTERM what it did.
//
//     cable --- packet socket --- lost? doubled? --- heap by time --- packet socket --- cable
//
// Frames keep the kernel's own header for virtual machines (PACKET_VNET_HDR): it says that a
// checksum is still to be filled in, which hosts on virtual cables leave to hardware that is not
// there.
#include "coordinator/schedule/heap.h"

#include <arpa/inet.h>
#include <errno.h>
#include <glib.h>
#include <inttypes.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    PORT_MAX = 16,
    FRAME_SIZE_MAX = 66000, // [bytes] what the kernel's virtual cables may carry in one
    WAITING_MAX = 100000,   // frames on their way; more are lost, as in a switch with full buffers
};

struct frame {
    struct heap_entry due;
    int port; // to which it goes
    size_t size;
    uint8_t bytes[];
};

static struct {
    double loss, twice; // probabilities
    int64_t delay_ns, jitter_ns;
    struct pollfd ports[PORT_MAX];
    int port_count;
    struct heap waiting;
    GRand *dice;
    uint64_t frames, lost, doubled;
} self;

static volatile sig_atomic_t ended;

static void end(int signal)
{
    (void)signal;
    ended = 1;
}

static int64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static void give_up(const char *what)
{
    fprintf(stderr, "switch: %s: %s\n", what, strerror(errno));
    exit(EXIT_FAILURE);
}

static void open_port(const char *name)
{
    const int on = 1, buffer_size = 16 << 20;
    const struct sockaddr_ll address = {.sll_family = AF_PACKET,
                                        .sll_protocol = htons(ETH_P_ALL),
                                        .sll_ifindex = (int)if_nametoindex(name)};
    const struct packet_mreq all = {.mr_ifindex = address.sll_ifindex,
                                    .mr_type = PACKET_MR_PROMISC};
    // No protocol yet: nothing arrives before everything is set.
    int fd = socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK, 0);
    if (fd < 0 || address.sll_ifindex == 0 ||
        setsockopt(fd, SOL_PACKET, PACKET_VNET_HDR, &on, sizeof on) != 0 ||
        setsockopt(fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on) != 0 ||
        bind(fd, (const struct sockaddr *)&address, sizeof address) != 0 ||
        setsockopt(fd, SOL_PACKET, PACKET_ADD_MEMBERSHIP, &all, sizeof all) != 0)
        give_up(name);
    // Only root may have so much, and others get what the system allows.
    if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &buffer_size, sizeof buffer_size) != 0)
        (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer_size, sizeof buffer_size);
    self.ports[self.port_count++] = (struct pollfd){.fd = fd, .events = POLLIN};
}

static void delay(int port, const uint8_t *bytes, size_t size)
{
    if (self.waiting.count >= WAITING_MAX) {
        self.lost++;
        return;
    }
    struct frame *frame = g_malloc(sizeof *frame + size);
    frame->due = (struct heap_entry){.tie = self.frames++};
    frame->port = port;
    frame->size = size;
    memcpy(frame->bytes, bytes, size);
    heap_put(&self.waiting, &frame->due,
             now_ns() + self.delay_ns +
                 (int64_t)(g_rand_double(self.dice) * (double)self.jitter_ns));
}

static bool chance(double probability)
{
    return g_rand_double(self.dice) < probability;
}

static void forward(int from, const uint8_t *bytes, size_t size)
{
    for (int port = 0; port < self.port_count; port++) {
        if (port == from)
            continue;
        if (chance(self.loss)) {
            self.lost++;
            continue;
        }
        delay(port, bytes, size);
        if (chance(self.twice)) {
            self.doubled++;
            delay(port, bytes, size);
        }
    }
}

static void receive(int port)
{
    static uint8_t bytes[FRAME_SIZE_MAX];
    ssize_t size;
    while ((size = recv(self.ports[port].fd, bytes, sizeof bytes, 0)) > 0)
        forward(port, bytes, (size_t)size);
}

// Sends what is due; returns how long nothing else is [ns], -1 when nothing waits. A cable that is
// unplugged loses what is sent into it.
static int64_t send_due(void)
{
    struct heap_entry *first;
    while ((first = heap_first(&self.waiting)) != NULL) {
        int64_t wait_ns = first->key - now_ns();
        if (wait_ns > 0)
            return wait_ns;
        struct frame *frame = (struct frame *)first;
        heap_remove(&self.waiting, first);
        if (send(self.ports[frame->port].fd, frame->bytes, frame->size, 0) < 0)
            self.lost++;
        g_free(frame);
    }
    return -1;
}

int main(int argc, char **argv)
{
    if (argc < 6 || argc - 5 > PORT_MAX) {
        fprintf(stderr, "usage: switch LOSS TWICE DELAY_MS JITTER_MS PORT...\n");
        return 2;
    }
    self.loss = atof(argv[1]) / 100;
    self.twice = atof(argv[2]) / 100;
    self.delay_ns = (int64_t)(atof(argv[3]) * 1e6);
    self.jitter_ns = (int64_t)(atof(argv[4]) * 1e6);
    for (int i = 5; i < argc; i++)
        open_port(argv[i]);
    const char *seed_text = getenv("SEED");
    uint32_t seed = seed_text != NULL ? (uint32_t)strtoul(seed_text, NULL, 10) : g_random_int();
    self.dice = g_rand_new_with_seed(seed);
    printf("seed %" PRIu32 "\n", seed);
    fflush(stdout);
    // Signals are let in while it waits, and only there: none is missed.
    sigset_t closed, open;
    sigemptyset(&open);
    sigemptyset(&closed);
    sigaddset(&closed, SIGTERM);
    sigprocmask(SIG_BLOCK, &closed, NULL);
    signal(SIGTERM, end);

    while (!ended) {
        int64_t wait_ns = send_due();
        const struct timespec wait = {.tv_sec = wait_ns / 1000000000,
                                      .tv_nsec = wait_ns % 1000000000};
        ppoll(self.ports, (nfds_t)self.port_count, wait_ns < 0 ? NULL : &wait, &open);
        for (int port = 0; port < self.port_count; port++) {
            if (self.ports[port].revents != 0)
                receive(port);
        }
    }
    printf("%" PRIu64 " frames sent, %" PRIu64 " lost, %" PRIu64 " doubled\n", self.frames,
           self.lost, self.doubled);
    return EXIT_SUCCESS;
}
