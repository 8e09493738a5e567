// Who may ask the server, and where it listens.
#include "monitor/http/host.h"

#include <arpa/inet.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// The Host header is what tells a request of the page from one that somebody else's page made by
// pointing its own name at this machine.
static void foreign_names_are_refused(void **state)
{
    (void)state;
    assert_false(host_is_ours("evil.example", "crash7"));
    assert_false(host_is_ours("evil.example:8765", "crash7"));
    assert_false(host_is_ours("localhost.evil.example:8765", "crash7"));
    assert_false(host_is_ours("127.0.0.1.evil.example", "crash7"));
    assert_false(host_is_ours("crash7.evil.example", "crash7"));
    assert_false(host_is_ours("crash77", "crash7"));
    assert_false(host_is_ours("", "crash7"));
    assert_false(host_is_ours(NULL, "crash7"));
    assert_false(host_is_ours("", ""));
    assert_false(host_is_ours("localhost:port", "crash7"));
    assert_false(host_is_ours("localhost:8765:8765", "crash7"));
    assert_false(host_is_ours("[::1", "crash7"));
    assert_false(host_is_ours("[::1]x", "crash7"));
}

// Any port: whoever comes through a tunnel has another one.
static void numbers_and_own_names_are_answered(void **state)
{
    (void)state;
    assert_true(host_is_ours("127.0.0.1:8765", "crash7"));
    assert_true(host_is_ours("10.1.2.3", "crash7"));
    assert_true(host_is_ours("[::1]:9000", "crash7"));
    assert_true(host_is_ours("LocalHost:8765", "crash7"));
    assert_true(host_is_ours("crash7:8765", "crash7"));
}

static void addresses_are_read_strictly(void **state)
{
    (void)state;
    struct host_address address;
    struct error error = {0};
    assert_int_equal(host_parse(&address, "127.0.0.1:8765", &error), STATUS_OK);
    assert_true(address.loopback);
    assert_int_equal(ntohs(address.socket.v4.sin_port), 8765);
    assert_int_equal(host_parse(&address, "8765", &error), STATUS_OK);
    assert_true(address.loopback);
    assert_int_equal(host_parse(&address, "[::1]:0", &error), STATUS_OK);
    assert_true(address.loopback);
    assert_int_equal(host_parse(&address, "0.0.0.0:80", &error), STATUS_OK);
    assert_false(address.loopback);
    static const char *const wrong[] = {"",          ":8765",           "127.0.0.1",
                                        "localhost", "127.0.0.1:65536", "127.0.0.1:-1",
                                        "::1:8765",  "example.org:80",  "127.0.0.1:80 "};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(host_parse(&address, wrong[i], &error), STATUS_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(foreign_names_are_refused),
        cmocka_unit_test(numbers_and_own_names_are_answered),
        cmocka_unit_test(addresses_are_read_strictly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
