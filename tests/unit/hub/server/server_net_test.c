// A hub and its clients over real sockets in one process: the link of the wire on one side, the
// server on the other. Runs under tests/netns.
//
// cmocka needs these first.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/base/log.h"
#include "common/wire/frame.h"
#include "common/wire/link.h"
#include "hub/server/server.h"

#include <arpa/inet.h>
#include <errno.h>
#include <glib.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { TURNS_MAX = 20000, PORT = 7700 };

static struct server *server;
static struct link *links[2];
static unsigned heard[2];

static void note(void *user, const char *channel, const uint8_t *data, size_t size)
{
    assert_string_equal(channel, "A");
    assert_int_equal(data[size - 1], 'x');
    ++*(unsigned *)user;
}

static struct sockaddr_in place(void)
{
    return (struct sockaddr_in){
        .sin_family = AF_INET, .sin_port = htons(PORT), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
}

static void open_hub(void)
{
    struct relay_settings settings = relay_settings_default();
    struct sockaddr_in address = place();
    struct error error = {0};
    settings.clients_max = 4;
    settings.queue_max = 100000;
    if (server_open(&server, &address, &settings, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

static void open_link(unsigned index)
{
    struct sockaddr_in address = place();
    heard[index] = 0;
    assert_int_equal(link_open(&links[index], &address, note, &heard[index], NULL), STATUS_OK);
    link_subscribe(links[index], "A");
}

// Everybody gets a turn.
static void turn(void)
{
    struct pollfd ready[3] = {{.fd = -1}, {.fd = -1}, {.fd = -1}};
    for (unsigned i = 0; i < 2; i++)
        if (links[i] != NULL)
            ready[i] = (struct pollfd){.fd = link_descriptor(links[i]), .events = POLLIN};
    if (server != NULL)
        ready[2] = (struct pollfd){.fd = server_descriptor(server), .events = POLLIN};
    poll(ready, 3, 10);
    for (unsigned i = 0; i < 2; i++)
        if (links[i] != NULL)
            link_dispatch(links[i], 8);
    if (server != NULL)
        server_dispatch(server);
}

#define TURN_UNTIL(condition)                               \
    do {                                                    \
        unsigned turns = 0;                                 \
        while (!(condition))                                \
            if (turns++ < TURNS_MAX)                        \
                turn();                                     \
            else                                            \
                fail_msg("waited in vain for " #condition); \
    } while (false)

static bool is_heard(void)
{
    return heard[0] > 0 && heard[1] > 0;
}

// Subscriptions are not answered, so messages are sent until they arrive.
static void meet(void)
{
    TURN_UNTIL(link_is_up(links[0]) && link_is_up(links[1]));
    heard[0] = heard[1] = 0;
    TURN_UNTIL(link_send(links[0], "A", (const uint8_t *)"x", 1) && is_heard());
}

static int with_hub(void **state)
{
    (void)state;
    log_start("test", LOG_QUIET);
    open_hub();
    return 0;
}

static int without_hub(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        link_close(links[i]);
        links[i] = NULL;
    }
    server_close(server);
    server = NULL;
    return 0;
}

// Neither of them waits for another: all three are one thread here.
static void two_links_meet_at_a_hub(void **state)
{
    (void)state;
    open_link(0);
    open_link(1);
    meet();
}

// Everything arrives, also more than one turn takes, in whatever pieces the sockets make of it.
static void large_and_many_messages_arrive(void **state)
{
    (void)state;
    static uint8_t large[60000];
    large[sizeof large - 1] = 'x';
    open_link(0);
    open_link(1);
    meet();
    unsigned before = heard[1];
    TURN_UNTIL(heard[1] == before || heard[1] == heard[0]);
    before = heard[1];
    for (unsigned i = 0; i < 60; i++) {
        assert_true(link_send(links[0], "A", large, i % 2 == 0 ? sizeof large : 1) || i % 2 == 0);
        large[0] = 'x'; // also the last byte of the short ones
        if (i % 2 == 0)
            turn();
    }
    TURN_UNTIL(heard[1] >= before + 60);
}

// Both ends notice, and are together again without anybody's help.
static void links_survive_the_hubs_restart(void **state)
{
    (void)state;
    open_link(0);
    open_link(1);
    meet();
    server_close(server);
    server = NULL;
    TURN_UNTIL(!link_is_up(links[0]) && !link_is_up(links[1]));
    assert_false(link_send(links[0], "A", (const uint8_t *)"x", 1));
    open_hub();
    meet();
}

// What is written to one who does not read piles up in the sockets, then in the hub, then is lost.
static void client_that_does_not_read_harms_nobody(void **state)
{
    (void)state;
    static uint8_t data[20000];
    uint8_t bytes[64];
    data[sizeof data - 1] = 'x';
    struct sockaddr_in address = place();
    int stopped = socket(AF_INET, SOCK_STREAM, 0), small = 4096;
    setsockopt(stopped, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    assert_int_equal(connect(stopped, (const struct sockaddr *)&address, sizeof address), 0);
    frame_hello(FRAME_CLIENT, bytes);
    size_t size = FRAME_HELLO_SIZE;
    size += frame_head(bytes + size, FRAME_SUBSCRIBE, ".", 1, 0);
    assert_int_equal(send(stopped, bytes, size, 0), size);
    open_link(0);
    open_link(1);
    meet();
    TURN_UNTIL((link_send(links[0], "A", data, sizeof data), server_counters(server).lost > 10));
    unsigned before = heard[1];
    TURN_UNTIL((link_send(links[0], "A", data, sizeof data), heard[1] >= before + 10));
    assert_int_equal(server_clients(server), 3);
    close(stopped);
    TURN_UNTIL(server_clients(server) == 2);
}

// Connections that say nothing do not keep those out who speak.
static void silent_connections_do_not_keep_others_out(void **state)
{
    (void)state;
    int silent[8];
    struct sockaddr_in address = place();
    for (unsigned i = 0; i < G_N_ELEMENTS(silent); i++) {
        silent[i] = socket(AF_INET, SOCK_STREAM, 0);
        assert_int_equal(connect(silent[i], (const struct sockaddr *)&address, sizeof address), 0);
        turn();
    }
    open_link(0);
    open_link(1);
    meet();
    assert_in_range(server_clients(server), 2, 4);
    for (unsigned i = 0; i < G_N_ELEMENTS(silent); i++)
        close(silent[i]);
}

// A port where something else answers is no hub; it is told, and tried again.
static void something_else_at_the_port_is_no_hub(void **state)
{
    (void)state;
    server_close(server);
    server = NULL;
    int on = 1, listener = socket(AF_INET, SOCK_STREAM, 0);
    struct sockaddr_in address = place();
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    assert_int_equal(bind(listener, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(listener, 4), 0);
    open_link(0);
    int other = accept(listener, NULL, NULL);
    assert_int_equal(send(other, "220 mail.example ESMTP", 22, 0), 22);
    for (unsigned i = 0; i < 20; i++)
        turn();
    assert_false(link_is_up(links[0]));
    close(other);
    close(listener);
}

int main(void)
{
#define SERVER_TEST(name) cmocka_unit_test_setup_teardown(name, with_hub, without_hub)
    const struct CMUnitTest tests[] = {
        SERVER_TEST(two_links_meet_at_a_hub),
        SERVER_TEST(large_and_many_messages_arrive),
        SERVER_TEST(links_survive_the_hubs_restart),
        SERVER_TEST(client_that_does_not_read_harms_nobody),
        SERVER_TEST(silent_connections_do_not_keep_others_out),
        SERVER_TEST(something_else_at_the_port_is_no_hub),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
