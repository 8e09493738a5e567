// A stranger on the network: hears everything that LCM carries on the three ports from 7667 on, and
// sends what it likes. It has no key.
//
//     stranger record FILE          takes down every packet until it is ended by a signal
//     stranger replay FILE          sends what was recorded, packet by packet
//     stranger forge COUNT [SEED]   sends COUNT packets that are noise, damaged, moved to other
//                                   channels, recorded a moment ago, or well-formed messages of
//                                   runs and workers that do not exist, with hostile counts and
//                                   fields
//
// It never sends a well-formed message in the name of a run that is there: without a key anyone can
// do that, and with a key it is no different from noise.
#include "common/wire/check.h"
#include "common/wire/url.h"

#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define GROUP "udpm://239.255.76.67:7667"

enum {
    PACKET_MAX = 65507,
    LIVE_MAX = 64,    // packets heard lately
    LIVE_SIZE = 2048, // [bytes] kept of one
    BURST = 64,       // packets sent, then what arrived is looked at
    BUFFER = 4 << 20, // [bytes] of the receiving sockets
    MAGIC_SIZE = 8,   // "LC02" and LCM's sequence number
};

struct packet_head {
    uint32_t port; // 0 .. WIRE_PORT_COUNT - 1
    uint32_t size;
};

struct live {
    struct packet_head head;
    uint8_t bytes[LIVE_SIZE];
};

static struct sockaddr_in places[WIRE_PORT_COUNT];
static int ears[WIRE_PORT_COUNT];
static int mouth;
static struct live live[LIVE_MAX];
static unsigned live_count;
static uint8_t packet[PACKET_MAX];
static uint64_t state = 1;

static void fail(const char *what)
{
    perror(what);
    exit(EXIT_FAILURE);
}

static uint32_t dice(void)
{
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(state >> 33);
}

static uint32_t dice_below(uint32_t limit)
{
    return dice() % limit;
}

static void dice_fill(uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
        bytes[i] = (uint8_t)dice();
}

// ---- The network ----

static void open_ear(unsigned port)
{
    int on = 1, buffer = BUFFER;
    struct sockaddr_in any = {.sin_family = AF_INET, .sin_port = places[port].sin_port};
    struct ip_mreq group = {.imr_multiaddr = places[port].sin_addr};
    ears[port] = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    setsockopt(ears[port], SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    setsockopt(ears[port], SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    if (bind(ears[port], (const struct sockaddr *)&any, sizeof any) != 0 ||
        setsockopt(ears[port], IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0)
        fail("stranger: listen");
}

static void open_network(void)
{
    struct url url;
    struct error error = {0};
    if (url_parse(&url, GROUP, &error) != STATUS_OK)
        fail(error.text);
    mouth = socket(AF_INET, SOCK_DGRAM, 0);
    for (unsigned port = 0; port < WIRE_PORT_COUNT; port++) {
        places[port] = url_socket_address(&url, port);
        open_ear(port);
    }
}

static void send_packet(uint32_t port, const uint8_t *bytes, size_t size)
{
    if (sendto(mouth, bytes, size, 0, (const struct sockaddr *)&places[port], sizeof places[port]) <
        0)
        fail("stranger: send");
}

// The next packet that has arrived on any port, into `packet`; false when there is none.
static bool hear(struct packet_head *head)
{
    for (head->port = 0; head->port < WIRE_PORT_COUNT; head->port++) {
        ssize_t size = recv(ears[head->port], packet, sizeof packet, 0);
        head->size = (uint32_t)size;
        if (size >= 0)
            return true;
    }
    return false;
}

// ---- Recording ----

static _Noreturn void record(const char *path)
{
    struct packet_head head;
    FILE *file = fopen(path, "wb");
    if (file == NULL)
        fail(path);
    puts("recording");
    fflush(stdout);
    for (;;) {
        struct pollfd ready[WIRE_PORT_COUNT];
        for (unsigned i = 0; i < WIRE_PORT_COUNT; i++)
            ready[i] = (struct pollfd){.fd = ears[i], .events = POLLIN};
        poll(ready, WIRE_PORT_COUNT, -1);
        while (hear(&head))
            if (fwrite(&head, sizeof head, 1, file) != 1 ||
                fwrite(packet, 1, head.size, file) != head.size)
                fail(path);
        fflush(file);
    }
}

static int replay(const char *path)
{
    struct packet_head head;
    unsigned count = 0;
    FILE *file = fopen(path, "rb");
    if (file == NULL)
        fail(path);
    while (fread(&head, sizeof head, 1, file) == 1 &&
           fread(packet, 1, head.size, file) == head.size) {
        send_packet(head.port, packet, head.size);
        count++;
    }
    fclose(file);
    printf("replayed %u packets\n", count);
    return EXIT_SUCCESS;
}

// ---- Forging ----

static enum wire_kind any_kind(void)
{
    return (enum wire_kind)dice_below(WIRE_KIND_COUNT);
}

// Begins a packet of LCM's on the kind's channel; returns where its content starts.
static size_t begin(enum wire_kind kind)
{
    const char *channel = check_kind(kind)->channel;
    memcpy(packet, "LC02", 4);
    dice_fill(packet + 4, 4);
    memcpy(packet + MAGIC_SIZE, channel, strlen(channel) + 1);
    return MAGIC_SIZE + strlen(channel) + 1;
}

static void noise(void)
{
    size_t size = dice_below(1500);
    dice_fill(packet, size);
    send_packet(dice_below(WIRE_PORT_COUNT), packet, size);
}

static void noise_on_a_channel(void)
{
    enum wire_kind kind = any_kind();
    size_t at = begin(kind), size = dice_below(2000);
    dice_fill(packet + at, size);
    if (dice_below(2) == 0)
        memcpy(packet + at, "SBX1\0\0\0\1", 8); // as if sealed
    if (dice_below(4) == 0)
        packet[3] = '3'; // a fragment
    send_packet(check_kind(kind)->port, packet, at + size);
}

// A number at the edges of what a field may be, or any.
static int64_t hostile_number(void)
{
    static const int64_t edges[] = {0,         1,         -1,        2,     65535,
                                    65536,     65537,     INT32_MAX, 7,     INT32_MIN,
                                    INT64_MAX, INT64_MIN, 1 << 29,   60000, 1 << 20};
    uint32_t pick = dice_below(2 * sizeof edges / sizeof edges[0]);
    return pick < sizeof edges / sizeof edges[0] ? edges[pick] : (int64_t)dice() << 16 ^ dice();
}

// A message whose header is right and whose run and sender do not exist, the rest mostly zeros with
// some hostile numbers in it, its tag right.
static void message_of_nobody(void)
{
    enum wire_kind kind = any_kind();
    const struct check_kind *layout = check_kind(kind);
    union codec_message message;
    memset(&message, 0, sizeof message);
    message.header =
        (sobox_header_t){.protocol = dice_below(50) == 0 ? WIRE_PROTOCOL - 1 : WIRE_PROTOCOL,
                         .sequence = (int32_t)dice(),
                         .sender = 1 + (int64_t)dice(),
                         .run = 1 + (int64_t)dice()};
    size_t at = begin(kind), size = codec_encoded_size(kind, &message);
    codec_encode(kind, &message, packet + at, size);
    size_t extra = layout->unit * dice_below(20);
    dice_fill(packet + at + size, extra);
    for (uint32_t edits = dice_below(8); edits > 0; edits--) {
        size_t room = size - 32, place = 32 + dice_below((uint32_t)room - 8) / 4 * 4;
        int64_t number = hostile_number();
        for (unsigned i = 0; i < 4; i++)
            packet[at + place + i] = (uint8_t)(number >> (24 - 8 * i));
    }
    if (layout->unit != 0 && dice_below(4) != 0) // the count that agrees with the size
        for (unsigned i = 0; i < 4; i++)
            packet[at + size - 4 + i] = (uint8_t)(extra / layout->unit >> (24 - 8 * i));
    size += extra;
    tag_compute(packet + at + size, layout->channel, packet + at, size);
    send_packet(layout->port, packet, at + size + TAG_SIZE);
}

// Something heard a moment ago: again, damaged, cut, or on another channel.
static void from_life(void)
{
    if (live_count == 0)
        return;
    const struct live *heard = &live[dice_below(live_count < LIVE_MAX ? live_count : LIVE_MAX)];
    size_t size = heard->head.size;
    memcpy(packet, heard->bytes, size);
    uint32_t port = heard->head.port, what = dice_below(4);
    if (what == 1) {
        packet[dice_below((uint32_t)size)] ^= (uint8_t)(1 << dice_below(8));
    } else if (what == 2) {
        size = dice_below((uint32_t)size);
    } else if (what == 3) {
        const uint8_t *end = memchr(packet + MAGIC_SIZE, 0, size - MAGIC_SIZE);
        size_t content = end == NULL ? size : (size_t)(end - packet) + 1;
        enum wire_kind kind = any_kind();
        size_t at = begin(kind);
        memcpy(packet + at, heard->bytes + content, size - content);
        size = at + size - content;
        port = check_kind(kind)->port;
    }
    send_packet(port, packet, size);
}

static void listen_a_moment(void)
{
    struct packet_head head;
    for (unsigned i = 0; i < 4 * BURST && hear(&head); i++)
        if (head.size > MAGIC_SIZE && head.size <= LIVE_SIZE && dice_below(4) == 0) {
            live[live_count % LIVE_MAX].head = head;
            memcpy(live[live_count++ % LIVE_MAX].bytes, packet, head.size);
        }
}

static int forge(unsigned long count)
{
    puts("forging");
    fflush(stdout);
    for (unsigned long i = 0; i < count; i++) {
        if (i % BURST == 0)
            listen_a_moment();
        switch (dice_below(4)) {
        case 0:
            noise();
            break;
        case 1:
            noise_on_a_channel();
            break;
        case 2:
            message_of_nobody();
            break;
        default:
            from_life();
            break;
        }
    }
    printf("forged %lu packets\n", count);
    return EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    open_network();
    if (argc == 3 && strcmp(argv[1], "record") == 0)
        record(argv[2]);
    if (argc == 3 && strcmp(argv[1], "replay") == 0)
        return replay(argv[2]);
    if (argc >= 3 && strcmp(argv[1], "forge") == 0) {
        state = argc > 3 ? strtoull(argv[3], NULL, 10) : 1;
        return forge(strtoul(argv[2], NULL, 10));
    }
    fputs("stranger record FILE | replay FILE | forge COUNT [SEED]\n", stderr);
    return EXIT_FAILURE;
}
