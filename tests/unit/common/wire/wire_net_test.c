// Wires over real UDP multicast, and strangers on the same port. Runs under tests/netns.
#include "messages.h"

#include "common/wire/guard.h"
#include "common/wire/quiet.h"
#include "common/wire/source.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#define URL "udpm://239.255.76.67:7667"
#define LC02 "LC02\0\0\0\0"

enum { PORT = 7667, PATIENCE_MS = 120000 };

struct seen {
    unsigned count[WIRE_KIND_COUNT];
    unsigned total;
    int64_t sender;
};

static void note(void *user, enum wire_kind kind, const void *message)
{
    struct seen *seen = user;
    seen->count[kind]++;
    seen->total++;
    seen->sender = ((const sobox_header_t *)message)->sender;
}

static struct wire *wire_at(const char *url, uint64_t sender)
{
    struct wire_settings settings = wire_settings_default();
    struct error error = {0};
    struct wire *wire = NULL;
    settings.url = url;
    if (wire_open(&wire, &settings, sender, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    return wire;
}

static void listen_to(struct wire *wire, enum wire_kind kind, struct seen *seen)
{
    struct error error = {0};
    if (wire_subscribe(wire, kind, note, seen, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

static void publish(struct wire *wire, enum wire_kind kind)
{
    union codec_message message;
    message_make(kind, &message);
    assert_int_equal(wire_publish(wire, kind, &message), STATUS_OK);
}

// Dispatches until `total` messages have been seen.
static void await(struct wire *wire, const struct seen *seen, unsigned total)
{
    int descriptors[WIRE_PORT_COUNT];
    struct pollfd ready[WIRE_PORT_COUNT];
    size_t count = wire_descriptors(wire, descriptors);
    for (size_t i = 0; i < count; i++)
        ready[i] = (struct pollfd){.fd = descriptors[i], .events = POLLIN};
    while (seen->total < total) {
        if (poll(ready, count, PATIENCE_MS) <= 0)
            fail_msg("%u of %u messages came", seen->total, total);
        wire_dispatch(wire, 100);
    }
}

static struct wire_counters counters_of(struct wire *wire)
{
    struct wire_counters counters;
    wire_counters(wire, &counters);
    return counters;
}

static unsigned open_descriptors(void)
{
    struct guard_descriptors now;
    unsigned count = 0;
    guard_look(&now);
    for (unsigned i = 0; i < GUARD_DESCRIPTORS / 64; i++)
        count += (unsigned)__builtin_popcountll(now.open[i]);
    return count;
}

// Each kind crosses from one wire to another, over its own port, and to its sender too.
static void every_kind_crosses(void **state)
{
    (void)state;
    struct seen here = {0}, there = {0};
    struct wire *sender = wire_at(URL, 1), *receiver = wire_at(URL, 2);
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        listen_to(sender, kind, &here);
        listen_to(receiver, kind, &there);
    }
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        publish(sender, kind);
    await(receiver, &there, WIRE_KIND_COUNT);
    await(sender, &here, WIRE_KIND_COUNT);
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        assert_int_equal(there.count[kind], 1);
    assert_int_equal(there.sender, 1);
    // The second wire's self tests have passed the first one's filters without a count.
    assert_int_equal(counters_of(sender).dropped, 0);
    assert_true(counters_of(receiver).buffer_size > 0);
    wire_close(sender);
    wire_close(receiver);
}

// Every listener of a port costs each of its senders, so a wire that only sends listens nowhere.
static void sending_opens_no_port(void **state)
{
    (void)state;
    int descriptors[WIRE_PORT_COUNT];
    struct seen seen = {0};
    struct wire *wire = wire_at(URL, 1);
    publish(wire, WIRE_OUTCOME_BATCH);
    assert_int_equal(wire_descriptors(wire, descriptors), 0);
    listen_to(wire, WIRE_SAMPLE_BATCH, &seen);
    listen_to(wire, WIRE_TEXT, &seen);
    assert_int_equal(wire_descriptors(wire, descriptors), 1);
    listen_to(wire, WIRE_WORKER_STATUS, &seen);
    assert_int_equal(wire_descriptors(wire, descriptors), 2);
    wire_close(wire);
}

// ---- Strangers ----

static int stranger_open(void)
{
    int stranger = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_true(stranger >= 0);
    return stranger;
}

static void stranger_send(int stranger, const void *bytes, size_t size)
{
    struct sockaddr_in group = {.sin_family = AF_INET, .sin_port = htons(PORT)};
    inet_pton(AF_INET, "239.255.76.67", &group.sin_addr);
    assert_int_equal(
        sendto(stranger, bytes, size, 0, (const struct sockaddr *)&group, sizeof group), size);
}
#define SEND(stranger, literal) stranger_send(stranger, literal, sizeof(literal) - 1)

// A packet of LCM's with `size` bytes of content on a kind's channel.
static void stranger_publish(int stranger, enum wire_kind kind, const uint8_t *content, size_t size)
{
    uint8_t bytes[WIRE_MTU_MAX + 64] = LC02;
    const char *channel = check_kind(kind)->channel;
    size_t at = 8 + strlen(channel) + 1;
    memcpy(bytes + 8, channel, at - 8);
    memcpy(bytes + at, content, size);
    stranger_send(stranger, bytes, at + size);
}

// One such fragment (LC03, on a channel that is listened to, of a 16 byte message, at the offset
// 0xfffffff0) makes unguarded LCM 1.3.1 write before its buffer and crash. None of these packets
// may reach LCM, and the kernel's count of them is ours.
static void packets_that_harm_lcm_are_filtered(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *wire = wire_at(URL, 1);
    listen_to(wire, WIRE_SAMPLE_BATCH, &seen);
    int stranger = stranger_open();
    SEND(stranger, "LC03\0\0\0\1\0\0\0\20\xff\xff\xff\xf0\0\0\0\1SOBOX_BATCH\0"
                   "twenty-five bytes of data");
    SEND(stranger, "LC03\0\0\0\2\20\0\0\0\0\0\0\0\0\0\0\1SOBOX_BATCH\0");      // claims 256 MB
    SEND(stranger, "LC02\0\0\0\3SOBOX_BATCH");                                 // no end of channel
    SEND(stranger, "LC02\0\0\0\3SOBOX_BATCH\0");                               // no content
    SEND(stranger, "LC02\0\0\0\4SOBOX_BATCHES\0a channel of somebody else's"); // kept for ever
    SEND(stranger, "LC02\0\0\0\5"
                   "a-channel-name-that-is-longer-than-the-sixty-three-bytes-LCM-allows\0data");
    SEND(stranger, "LC02");
    SEND(stranger, "");
    SEND(stranger, "junk that has nothing to do with LCM at all, only with this port");
    static const uint8_t zeros[WIRE_MTU_MAX + 1];
    stranger_publish(stranger, WIRE_SAMPLE_BATCH, zeros, sizeof zeros);
    publish(wire, WIRE_SAMPLE_BATCH);
    await(wire, &seen, 1);
    assert_int_equal(counters_of(wire).dropped, 10);
    assert_int_equal(counters_of(wire).rejected, 0);
    close(stranger);
    wire_close(wire);
}

// LCM binds its port and reads from it before it returns; a stranger that sends the deadly fragment
// without end, on the one channel that is listened to by then, must find the filter there already.
static void opening_under_fire_is_safe(void **state)
{
    (void)state;
    enum { ROUNDS = 20 };
    pid_t fire = fork();
    assert_true(fire >= 0);
    if (fire == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL); // also when an assertion ends the test early
        int stranger = stranger_open();
        for (;;)
            SEND(stranger, "LC03\0\0\0\1\0\0\0\20\xff\xff\xff\xf0\0\0\0\1LCM_SELF_TEST\0"
                           "twenty-five bytes of data");
    }
    for (unsigned i = 0; i < ROUNDS; i++) {
        struct seen seen = {0};
        struct wire *wire = wire_at(URL, 1);
        listen_to(wire, WIRE_SAMPLE_BATCH, &seen);
        publish(wire, WIRE_SAMPLE_BATCH);
        await(wire, &seen, 1);
        wire_close(wire);
    }
    kill(fire, SIGKILL);
    assert_int_equal(waitpid(fire, NULL, 0), fire);
}

// What gets through to the checks is counted for what it is, and what is right still arrives.
static void forged_messages_are_counted_and_dropped(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *wire = wire_at(URL, 1);
    listen_to(wire, WIRE_TEXT, &seen);
    int stranger = stranger_open();
    static uint8_t packet[WIRE_MTU_MAX];
    size_t size = packet_valid(WIRE_TEXT, packet);
    packet[size - 1] ^= 1; // not its tag
    stranger_publish(stranger, WIRE_TEXT, packet, size);
    packet[size - 1] ^= 1;
    stranger_publish(stranger, WIRE_TEXT, packet, size - 1); // cut
    memset(packet + 56, 0xff, 4);                            // a count of -1
    packet_tag(WIRE_TEXT, packet, size);
    stranger_publish(stranger, WIRE_TEXT, packet, size);
    size = packet_valid(WIRE_TEXT, packet);
    packet[11] = WIRE_PROTOCOL + 1; // another version
    packet_tag(WIRE_TEXT, packet, size);
    stranger_publish(stranger, WIRE_TEXT, packet, size);
    size = packet_valid(WIRE_TEXT, packet);
    stranger_publish(stranger, WIRE_TEXT, packet, size);
    await(wire, &seen, 1);
    struct wire_counters counters = counters_of(wire);
    assert_int_equal(counters.rejected, 3);
    assert_int_equal(counters.foreign, 1);
    assert_int_equal(counters.foreign_protocol, WIRE_PROTOCOL + 1);
    assert_int_equal(counters.received, 1);
    assert_int_equal(seen.sender, MESSAGE_SENDER);
    close(stranger);
    wire_close(wire);
}

// A process that is busy for long loses the newest messages instead of its memory, and every one
// that is lost is counted.
static void flood_is_bounded_and_its_losses_counted(void **state)
{
    (void)state;
    enum { FLOOD = 30000 };
    struct seen seen = {0};
    struct wire *wire = wire_at(URL, 1);
    listen_to(wire, WIRE_TEXT_REQUEST, &seen);
    for (unsigned i = 0; i < FLOOD; i++)
        publish(wire, WIRE_TEXT_REQUEST);
    while (wire_dispatch(wire, 1000) > 0)
        ;
    unsigned kept = seen.total;
    assert_in_range(kept, 1, FLOOD - 1);
    // The last one sent shows the gap before it; earlier ones may still be on their way.
    unsigned sent = FLOOD;
    do {
        publish(wire, WIRE_TEXT_REQUEST);
        sent++;
        await(wire, &seen, seen.total + 1);
        while (wire_dispatch(wire, 1000) > 0)
            ;
    } while (seen.total + counters_of(wire).lost < sent);
    assert_int_equal(seen.total + counters_of(wire).lost, sent);
    wire_close(wire);
}

// ---- The machine ----

// After a route has moved LCM is deaf; the wire opens anew with what was subscribed to.
static void reopened_wire_hears_again(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct error error = {0};
    unsigned before = open_descriptors();
    struct wire *wire = wire_at(URL, 1);
    listen_to(wire, WIRE_SAMPLE_BATCH, &seen);
    listen_to(wire, WIRE_RUN_STATUS, &seen);
    unsigned open = open_descriptors();
    for (unsigned i = 1; i <= 3; i++) {
        publish(wire, WIRE_RUN_STATUS);
        await(wire, &seen, 2 * i - 1);
        assert_int_equal(wire_reopen(wire, &error), STATUS_OK);
        publish(wire, WIRE_SAMPLE_BATCH);
        await(wire, &seen, 2 * i);
    }
    assert_int_equal(counters_of(wire).lost, 0);
    assert_int_equal(open_descriptors(), open);
    wire_close(wire);
    assert_int_equal(open_descriptors(), before);
}

// The main loop learns of the new descriptors by attaching again.
static void source_follows_a_reopened_wire(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *wire = wire_at(URL, 1);
    listen_to(wire, WIRE_TEXT, &seen);
    wire_source_attach(wire);
    assert_int_equal(wire_reopen(wire, NULL), STATUS_OK);
    wire_source_attach(wire);
    publish(wire, WIRE_TEXT);
    while (seen.total < 1)
        g_main_context_iteration(NULL, TRUE);
    wire_close(wire);
}

// The receive buffer is what the URL asks for (doubled by the kernel), not what LCM was told to
// ask.
static void receive_buffer_is_as_asked(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct wire *wire = wire_at(URL "?recv_buf_size=100000", 1);
    listen_to(wire, WIRE_TEXT, &seen);
    assert_int_equal(counters_of(wire).buffer_size, 200000);
    wire_close(wire);
}

// A worker process that is started later must not hold LCM's sockets open.
static void descriptors_close_on_exec(void **state)
{
    (void)state;
    struct guard_descriptors before;
    struct seen seen = {0};
    guard_look(&before);
    struct wire *wire = wire_at(URL, 1);
    listen_to(wire, WIRE_OUTCOME_BATCH, &seen);
    unsigned opened = 0;
    for (int fd = 0; fd < GUARD_DESCRIPTORS; fd++) {
        int flags = fcntl(fd, F_GETFD);
        if (flags < 0 || (before.open[fd / 64] >> (fd % 64) & 1) != 0)
            continue;
        opened++;
        assert_int_equal(flags & FD_CLOEXEC, FD_CLOEXEC);
    }
    assert_true(opened >= 9);
    wire_close(wire);
}

// LCM aborts when a descriptor reaches 1024; the wire says so instead.
static void full_descriptor_table_is_an_error(void **state)
{
    (void)state;
    static int filler[GUARD_DESCRIPTORS];
    struct wire_settings settings = {.url = URL, .mtu = WIRE_MTU_DEFAULT};
    struct error error = {0};
    struct wire *wire = NULL;
    size_t count = 0;
    while (count < GUARD_DESCRIPTORS) {
        int fd = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
        if (fd < 0)
            break;
        filler[count++] = fd;
        if (fd >= GUARD_DESCRIPTORS - 3)
            break;
    }
    assert_int_equal(wire_open(&wire, &settings, 1, &error), STATUS_NETWORK);
    while (count > 0)
        close(filler[--count]);
}

// The port of the outcomes belongs to another program: the message names it, the other ports go on
// working, and so does this one once it is free.
static void port_in_use_is_named(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct error error = {0};
    struct sockaddr_in taken = {.sin_family = AF_INET, .sin_port = htons(PORT + 1)};
    int other = stranger_open();
    assert_int_equal(bind(other, (const struct sockaddr *)&taken, sizeof taken), 0);
    struct wire *wire = wire_at(URL, 1);
    assert_int_equal(wire_subscribe(wire, WIRE_OUTCOME_BATCH, note, &seen, &error), STATUS_NETWORK);
    assert_non_null(strstr(error.text, "port 7668 is in use"));
    listen_to(wire, WIRE_SAMPLE_BATCH, &seen);
    publish(wire, WIRE_SAMPLE_BATCH);
    await(wire, &seen, 1);
    close(other);
    listen_to(wire, WIRE_OUTCOME_BATCH, &seen);
    publish(wire, WIRE_OUTCOME_BATCH);
    await(wire, &seen, 2);
    wire_close(wire);
}

// A machine without any network gets one line that names the remedy, and nothing of LCM's own. A
// wire that loses its network while open keeps its settings, fails softly and comes back.
static void missing_route_is_explained_and_survived(void **state)
{
    (void)state;
    struct seen seen = {0};
    struct error error = {0};
    struct wire_settings settings = {.url = URL, .mtu = WIRE_MTU_DEFAULT};
    struct wire *wire = wire_at(URL, 1), *none = NULL;
    union codec_message message;
    int descriptors[WIRE_PORT_COUNT];
    struct quiet quiet;
    listen_to(wire, WIRE_SAMPLE_BATCH, &seen);
    int network = open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC);
    assert_true(network >= 0);
    assert_int_equal(unshare(CLONE_NEWNET), 0); // this thread's sockets now have no route

    quiet_start(&quiet);
    enum status status = wire_open(&none, &settings, 2, &error);
    quiet_end(&quiet);
    assert_int_equal(status, STATUS_NETWORK);
    assert_string_equal(quiet.text, "");
    assert_non_null(strstr(error.text, "no route for multicast to 239.255.76.67"));
    assert_non_null(strstr(error.text, "ip route add"));

    assert_int_equal(wire_reopen(wire, &error), STATUS_NETWORK);
    message_make(WIRE_TEXT, &message);
    assert_int_equal(wire_publish(wire, WIRE_TEXT, &message), STATUS_NETWORK);
    assert_int_equal(wire_descriptors(wire, descriptors), 0);
    assert_int_equal(wire_dispatch(wire, 10), 0);

    assert_int_equal(setns(network, CLONE_NEWNET), 0);
    close(network);
    assert_int_equal(wire_reopen(wire, &error), STATUS_OK);
    publish(wire, WIRE_SAMPLE_BATCH);
    await(wire, &seen, 1);
    wire_close(wire);
}

static void only_ttl_lets_messages_leave(void **state)
{
    (void)state;
    struct wire *inside = wire_at("memq://", 1), *here = wire_at(URL, 1),
                *away = wire_at(URL "?ttl=1", 1);
    assert_false(wire_leaves_machine(inside));
    assert_false(wire_leaves_machine(here));
    assert_true(wire_leaves_machine(away));
    wire_close(inside);
    wire_close(here);
    wire_close(away);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_crosses),
        cmocka_unit_test(sending_opens_no_port),
        cmocka_unit_test(packets_that_harm_lcm_are_filtered),
        cmocka_unit_test(opening_under_fire_is_safe),
        cmocka_unit_test(forged_messages_are_counted_and_dropped),
        cmocka_unit_test(flood_is_bounded_and_its_losses_counted),
        cmocka_unit_test(reopened_wire_hears_again),
        cmocka_unit_test(source_follows_a_reopened_wire),
        cmocka_unit_test(receive_buffer_is_as_asked),
        cmocka_unit_test(descriptors_close_on_exec),
        cmocka_unit_test(full_descriptor_table_is_an_error),
        cmocka_unit_test(port_in_use_is_named),
        cmocka_unit_test(missing_route_is_explained_and_survived),
        cmocka_unit_test(only_ttl_lets_messages_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
