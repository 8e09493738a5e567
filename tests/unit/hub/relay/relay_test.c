// cmocka needs these first.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/wire/frame.h"
#include "common/wire/seal.h"
#include "hub/relay/relay.h"

#include <glib.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)

enum { MESSAGE_MAX = 4000, QUEUE_MAX = 10000 };

static struct relay *relay;
static int64_t now_ns;
static const char *why;

static struct relay_settings small(void)
{
    struct relay_settings settings = relay_settings_default();
    settings.clients_max = 4;
    settings.message_max = MESSAGE_MAX;
    settings.queue_max = QUEUE_MAX;
    return settings;
}

static void open_relay(const struct relay_settings *settings)
{
    relay = relay_create(settings);
    now_ns = 1000 * SECOND_NS;
}

static int with_relay(void **state)
{
    (void)state;
    struct relay_settings settings = small();
    open_relay(&settings);
    return 0;
}

static int without_relay(void **state)
{
    (void)state;
    relay_free(relay);
    return 0;
}

// ---- Clients ----

static bool give(struct relay_client *client, const void *bytes, size_t size)
{
    return relay_take(relay, client, bytes, size, now_ns, &why);
}

static size_t read_all(struct relay_client *client, uint8_t *bytes, size_t room)
{
    struct iovec piece;
    size_t size = 0;
    while (relay_peek(client, &piece, 1) == 1 && size + piece.iov_len <= room) {
        memcpy(bytes + size, piece.iov_base, piece.iov_len);
        size += piece.iov_len;
        relay_pop(client, piece.iov_len);
    }
    return size;
}

// A client that has said hello and heard the hub's.
static struct relay_client *join(void)
{
    uint8_t hello[FRAME_HELLO_SIZE], answer[64];
    struct relay_client *client = relay_join(relay, "10.0.0.1:4000", NULL, now_ns);
    assert_non_null(client);
    frame_hello(FRAME_CLIENT, hello);
    assert_true(give(client, hello, sizeof hello));
    assert_int_equal(read_all(client, answer, sizeof answer), FRAME_HELLO_SIZE);
    assert_true(frame_is_hello(FRAME_HUB, answer));
    return client;
}

static void ask(struct relay_client *client, enum frame_type type, const char *pattern)
{
    uint8_t bytes[FRAME_PATTERN_MAX + 12];
    size_t size = frame_head(bytes, type, pattern, strlen(pattern), 0);
    assert_true(give(client, bytes, size));
}

static struct relay_client *subscriber(const char *pattern)
{
    struct relay_client *client = join();
    ask(client, FRAME_SUBSCRIBE, pattern);
    return client;
}

static void send(struct relay_client *client, const char *channel, const void *data, size_t size)
{
    static uint8_t bytes[FRAME_HEAD_MAX + 2 * MESSAGE_MAX];
    size_t head = frame_head(bytes, FRAME_PUBLISH, channel, strlen(channel), size);
    memcpy(bytes + head, data, size);
    assert_true(give(client, bytes, head + size));
}

static void say(struct relay_client *client, const char *channel, const char *text)
{
    send(client, channel, text, strlen(text));
}

// What the client is given next, as "CHANNEL=TEXT CHANNEL=TEXT ".
static const char *heard(struct relay_client *client)
{
    static uint8_t bytes[4 * QUEUE_MAX];
    static char text[QUEUE_MAX];
    size_t size = read_all(client, bytes, sizeof bytes), place = 0;
    GString *all = g_string_new(NULL);
    struct frame frame;
    while (place < size) {
        assert_int_equal(frame_read(FRAME_HUB, bytes + place, size - place, MESSAGE_MAX, &frame),
                         FRAME_WHOLE);
        g_string_append_printf(all, "%.*s=%.*s ", (int)frame.name_size, frame.name,
                               (int)MIN(frame.data_size, 20), (const char *)frame.data);
        place += frame.size;
    }
    g_strlcpy(text, all->str, sizeof text);
    g_string_free(all, TRUE);
    return text;
}

// ---- Passing on ----

// LCM's clients expect their own messages back, as with multicast; others hear only what they asked
// for.
static void message_reaches_its_subscribers_and_its_sender(void **state)
{
    (void)state;
    struct relay_client *one = subscriber("A"), *two = subscriber("A"), *other = subscriber("B");
    say(one, "A", "text");
    assert_string_equal(heard(one), "A=text ");
    assert_string_equal(heard(two), "A=text ");
    assert_string_equal(heard(other), "");
}

// A pattern stands for a whole name, and a name with a letter more is another.
static void regular_expressions_match_whole_names(void **state)
{
    (void)state;
    struct relay_client *one = subscriber("SOBOX_(RUN|SEARCH)"), *all = subscriber(".*");
    say(one, "SOBOX_RUN", "1");
    say(one, "SOBOX_SEARCH", "2");
    say(one, "SOBOX_RUNS", "3");
    say(one, "MY_SOBOX_RUN", "4");
    assert_string_equal(heard(one), "SOBOX_RUN=1 SOBOX_SEARCH=2 ");
    assert_string_equal(heard(all), "SOBOX_RUN=1 SOBOX_SEARCH=2 SOBOX_RUNS=3 MY_SOBOX_RUN=4 ");
}

// Who hears a channel is remembered, so each change must be seen by the next message.
static void subscriptions_begin_and_end_at_once(void **state)
{
    (void)state;
    struct relay_client *one = join(), *two = subscriber("A");
    say(one, "A", "1");
    ask(one, FRAME_SUBSCRIBE, "A");
    say(one, "A", "2");
    ask(two, FRAME_UNSUBSCRIBE, "A");
    ask(two, FRAME_UNSUBSCRIBE, "A"); // there is none any more
    say(one, "A", "3");
    assert_string_equal(heard(two), "A=1 A=2 ");
    assert_string_equal(heard(one), "A=2 A=3 ");
    relay_leave(relay, one);
    say(two, "A", "4");
    struct relay_client *three = subscriber("A");
    say(two, "A", "5");
    assert_string_equal(heard(three), "A=5 ");
}

// TCP keeps no boundaries: whatever pieces the bytes come in, the messages are the same.
static void frames_may_come_in_any_pieces(void **state)
{
    (void)state;
    uint8_t bytes[200];
    struct relay_client *ear = subscriber("A|CHANNEL"), *mouth = join();
    size_t size = frame_head(bytes, FRAME_SUBSCRIBE, "X.*", 3, 0);
    size += frame_head(bytes + size, FRAME_PUBLISH, "A", 1, 0);
    size += frame_head(bytes + size, FRAME_PUBLISH, "CHANNEL", 7, 4);
    memcpy(bytes + size, "text", 4);
    size += 4;
    for (size_t piece = 1; piece <= size; piece++) {
        for (size_t place = 0; place < size; place += piece)
            assert_true(give(mouth, bytes + place, MIN(piece, size - place)));
        assert_string_equal(heard(ear), "A= CHANNEL=text ");
        ask(mouth, FRAME_UNSUBSCRIBE, "X.*");
    }
}

// The server is told of each client with something to write once, not once a message.
static void clients_to_write_to_are_named_once(void **state)
{
    (void)state;
    struct relay_client *one = subscriber("A");
    while (relay_next_to_write(relay) != NULL)
        ;
    say(one, "A", "1");
    say(one, "A", "2");
    assert_ptr_equal(relay_next_to_write(relay), one);
    assert_null(relay_next_to_write(relay));
}

// ---- Who is slow ----

// A stopped client costs its queue and nothing else; it sees gaps, but no half messages.
static void full_queue_loses_the_newest_and_harms_nobody(void **state)
{
    (void)state;
    uint8_t data[1000] = {0};
    struct relay_client *stopped = subscriber("A"), *quick = subscriber("A");
    for (unsigned i = 0; i < 100; i++) {
        send(quick, "A", data, sizeof data);
        assert_int_equal(strlen(heard(quick)), 3); // "A= "
    }
    uint64_t lost = relay_lost(stopped);
    assert_in_range(lost, 85, 95);
    assert_int_equal(relay_lost(stopped), 0);
    assert_int_equal(relay_lost(quick), 0);
    assert_int_equal(strlen(heard(stopped)), 3 * (100 - lost));
    say(quick, "A", "again");
    assert_string_equal(heard(stopped), "A=again ");
}

// Many stopped clients together are bounded too, and those who read are still served.
static void memory_of_all_queues_is_bounded(void **state)
{
    (void)state;
    struct relay_settings settings = small();
    settings.memory_max = 3000;
    relay_free(relay);
    open_relay(&settings);
    uint8_t data[1000] = {0};
    struct relay_client *stopped = subscriber("A|B"), *quick = subscriber("A");
    for (unsigned i = 0; i < 20; i++) {
        send(quick, "A", data, sizeof data);
        heard(quick);
    }
    assert_in_range(relay_lost(stopped), 15, 18);
    assert_int_equal(relay_lost(quick), 0);
}

// ---- Who is hostile ----

static void silent_and_hesitant_clients_are_overdue(void **state)
{
    (void)state;
    struct relay_client *silent = relay_join(relay, "silent", NULL, now_ns);
    struct relay_client *idle = join(), *hesitant = join();
    uint8_t half[FRAME_HEAD_MAX];
    size_t size = frame_head(half, FRAME_PUBLISH, "A", 1, 100);
    now_ns += RELAY_HELLO_NS - 1;
    assert_null(relay_overdue(relay, now_ns));
    now_ns += 1;
    assert_ptr_equal(relay_overdue(relay, now_ns), silent);
    relay_leave(relay, silent);
    // A byte each second keeps nobody in for ever.
    for (size_t i = 0; i < size; i++) {
        assert_true(give(hesitant, half + i, 1));
        now_ns += SECOND_NS;
    }
    assert_null(relay_overdue(relay, now_ns));
    now_ns += RELAY_FRAME_NS;
    assert_ptr_equal(relay_overdue(relay, now_ns), hesitant);
    relay_leave(relay, hesitant);
    now_ns += 1000 * SECOND_NS;
    assert_null(relay_overdue(relay, now_ns)); // who has nothing to say may stay
    say(idle, "A", "1");
}

static void what_is_no_protocol_is_cut_off(void **state)
{
    (void)state;
    static const struct {
        const char *bytes;
        size_t size;
    } cases[] = {
        {"\0\0\0\4\0\0\0\1A", 9},         // no such type
        {"\0\0\0\1\0\0\0\0\0\0\0\0", 12}, // a channel without name
        {"\0\0\0\1\0\0\0\100", 8},        // one of 64 bytes
        {"\0\0\0\2\377\377\377\377", 8},  // a pattern of 4 GB
        {"\0\0\0\2\0\0\0\2A\0", 10},      // with a NUL
        {"\0\0\0\2\0\0\0\2[A", 10},       // no expression
        {"GET / HTTP/1.1\r\n\r\n", 18},   // a browser
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct relay_client *client = join();
        assert_false(give(client, cases[i].bytes, cases[i].size));
        relay_leave(relay, client);
    }
    struct relay_client *browser = relay_join(relay, "browser", NULL, now_ns);
    assert_false(give(browser, "GET / HTTP/1.1\r\n\r\n", 18));
    assert_string_equal(why, "no hello of an LCM client");
}

// Nothing is kept of it, and what comes behind it is understood.
static void message_too_large_is_skipped(void **state)
{
    (void)state;
    static uint8_t data[2 * MESSAGE_MAX];
    uint8_t head[FRAME_HEAD_MAX];
    struct relay_client *ear = subscriber("A"), *mouth = join();
    send(mouth, "A", data, MESSAGE_MAX + 1);
    say(mouth, "A", "after");
    assert_string_equal(heard(ear), "A=after ");
    assert_int_equal(relay_counters(relay).large, 1);
    // Almost 4 GB are announced: what comes is let go as it comes.
    size_t size = frame_head(head, FRAME_PUBLISH, "A", 1, UINT32_MAX);
    assert_true(give(mouth, head, size));
    for (unsigned i = 0; i < 100; i++)
        assert_true(give(mouth, data, sizeof data));
    assert_string_equal(heard(ear), "");
}

static void subscriptions_are_counted(void **state)
{
    (void)state;
    struct relay_client *client = join();
    uint8_t bytes[FRAME_HEAD_MAX];
    for (unsigned i = 0; i < RELAY_PATTERNS_MAX; i++)
        ask(client, FRAME_SUBSCRIBE, ".*");
    size_t size = frame_head(bytes, FRAME_SUBSCRIBE, "A", 1, 0);
    assert_false(give(client, bytes, size));
    assert_string_equal(why, "too many subscriptions");
    say(relay_join(relay, "other", NULL, now_ns) != NULL ? client : NULL, "B", "1");
    assert_string_equal(heard(client), "B=1 "); // once, however many match
}

// An expression that takes for ever on a long name is given up; it matches nothing.
static void expressions_that_never_end_are_given_up(void **state)
{
    (void)state;
    struct relay_client *hostile = subscriber("(a+a+a+)+b"), *ear = subscriber("a*");
    say(hostile, "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa", "1");
    assert_string_equal(heard(hostile), "");
    assert_int_not_equal(strlen(heard(ear)), 0);
}

// ---- When all places are taken ----

// Connections that say nothing can be had by the thousand, so they give way to newcomers.
static void silent_clients_give_way(void **state)
{
    (void)state;
    struct relay_client *good = join();
    struct relay_client *first = relay_join(relay, "first", NULL, now_ns);
    relay_join(relay, "second", NULL, now_ns);
    relay_join(relay, "third", NULL, now_ns);
    assert_null(relay_join(relay, "fifth", NULL, now_ns));
    assert_ptr_equal(relay_victim(relay, now_ns), first);
    relay_leave(relay, first);
    assert_non_null(join());
    assert_int_equal(relay_count(relay), 4);
    say(good, "A", "1");
}

static void those_who_have_said_hello_stay(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 4; i++)
        join();
    assert_null(relay_victim(relay, now_ns + 1000 * SECOND_NS));
}

// ---- With a key ----

static const uint8_t key_bytes[KEY_SIZE] = {7, 1, 2, 3}, other_bytes[KEY_SIZE] = {7, 1, 2, 2};

static void send_sealed(struct relay_client *client, const char *channel, const char *sealed_for,
                        const uint8_t bytes[KEY_SIZE])
{
    uint8_t packet[SEAL_SIZE + 4] = {0};
    const struct seal_origin origin = {.sender = 1, .salt = 2, .number = 3};
    struct key *key = key_create(bytes);
    assert_non_null(key);
    memcpy(packet + SEAL_HEAD_SIZE, "text", 4);
    seal_close(packet, 4, sealed_for, key, 1, &origin);
    send(client, channel, packet, sizeof packet);
    key_free(key);
}

// A stranger may connect and listen to what he cannot read, but nothing of his is passed on.
static void only_the_right_seal_is_passed_on(void **state)
{
    (void)state;
    struct relay_settings settings = small();
    struct key *key = key_create(key_bytes);
    assert_non_null(key);
    settings.key = key;
    relay_free(relay);
    open_relay(&settings);
    struct relay_client *friend = subscriber("A|B"), *stranger = subscriber("A");
    say(stranger, "A", "text in clear");
    say(stranger, "A", "");
    say(stranger, "A", "SBX1 that is no seal but begins like one: never mind the rest");
    send_sealed(stranger, "A", "A", other_bytes);
    send_sealed(stranger, "B", "A", key_bytes); // recorded on another channel
    assert_string_equal(heard(friend), "");
    assert_int_equal(relay_counters(relay).refused, 5);
    send_sealed(friend, "A", "A", key_bytes);
    assert_int_not_equal(strlen(heard(friend)), 0);
    // And when places are short it is the stranger who goes, once he had his time.
    assert_null(relay_victim(relay, now_ns));
    assert_ptr_equal(relay_victim(relay, now_ns + RELAY_HELLO_NS), stranger);
    relay_leave(relay, stranger);
    assert_null(relay_victim(relay, now_ns + RELAY_HELLO_NS));
    relay_free(relay);
    key_free(key);
    with_relay(state);
}

int main(void)
{
#define RELAY_TEST(name) cmocka_unit_test_setup_teardown(name, with_relay, without_relay)
    const struct CMUnitTest tests[] = {
        RELAY_TEST(message_reaches_its_subscribers_and_its_sender),
        RELAY_TEST(regular_expressions_match_whole_names),
        RELAY_TEST(subscriptions_begin_and_end_at_once),
        RELAY_TEST(frames_may_come_in_any_pieces),
        RELAY_TEST(clients_to_write_to_are_named_once),
        RELAY_TEST(full_queue_loses_the_newest_and_harms_nobody),
        RELAY_TEST(memory_of_all_queues_is_bounded),
        RELAY_TEST(silent_and_hesitant_clients_are_overdue),
        RELAY_TEST(what_is_no_protocol_is_cut_off),
        RELAY_TEST(message_too_large_is_skipped),
        RELAY_TEST(subscriptions_are_counted),
        RELAY_TEST(expressions_that_never_end_are_given_up),
        RELAY_TEST(silent_clients_give_way),
        RELAY_TEST(those_who_have_said_hello_stay),
        RELAY_TEST(only_the_right_seal_is_passed_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
