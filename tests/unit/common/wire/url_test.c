#include "messages.h"

#include "common/wire/url.h"

// What people write, and what LCM gets for each of the three ports.
static void complete_and_short_urls_are_read(void **state)
{
    (void)state;
    struct url url;
    char text[URL_LCM_SIZE];
    assert_int_equal(url_parse(&url, "memq://", NULL), STATUS_OK);
    assert_true(url.memq);
    assert_string_equal(url_lcm(&url, 0, text), "memq://");
    assert_int_equal(url_parse(&url, "udpm://239.255.76.67:7667", NULL), STATUS_OK);
    assert_string_equal(url_lcm(&url, 2, text),
                        "udpm://239.255.76.67:7669?ttl=0&recv_buf_size=2147483647");
    assert_int_equal(url_parse(&url, "udpm://224.0.1.2:65533?recv_buf_size=1000000&ttl=255", NULL),
                     STATUS_OK);
    assert_string_equal(url_lcm(&url, 2, text),
                        "udpm://224.0.1.2:65535?ttl=255&recv_buf_size=2147483647");
    assert_int_equal(url.receive_buffer, 1000000);
}

// Through a hub everything goes over one connection; what stays on this machine is told from what
// leaves it, where a key is advised.
static void hubs_are_read(void **state)
{
    (void)state;
    struct url url;
    char text[URL_LCM_SIZE];
    assert_int_equal(url_parse(&url, "tcpq://192.168.1.10:65535", NULL), STATUS_OK);
    assert_true(url.tcpq && !url.memq);
    assert_int_equal(url.port, 65535);
    assert_string_equal(url_lcm(&url, 0, text), "tcpq://192.168.1.10:65535");
    assert_true(url_leaves_machine(&url));
    assert_int_equal(url_parse(&url, "tcpq://127.0.0.1:7700", NULL), STATUS_OK);
    assert_false(url_leaves_machine(&url));
}

// Each of these is accepted by LCM and then does not work, or is a slip of the pen; the message
// names the URL and what is wrong.
static void unusable_urls_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *url, *reason;
    } cases[] = {
        {"", "expected memq://"},
        {"memq", "expected memq://"},
        {"memq://x", "expected memq://"},
        {"udpm:/239.255.76.67:7667", "expected memq://"},
        {"mpudpm://239.255.76.67:7667", "expected memq://"},
        {"tcp://127.0.0.1:7700", "expected memq://"},
        {"tcpq://", "port is missing"},
        {"tcpq://127.0.0.1", "port is missing"},
        {"tcpq://127.0.0.1:", "port ''"},
        {"tcpq://127.0.0.1:0", "port '0'"},
        {"tcpq://127.0.0.1:65536", "expected a number from 1 to 65535"},
        {"tcpq://hub.example:7700", "'hub.example' is no address of a hub: expected numbers"},
        {"tcpq://localhost:7700", "LCM takes any name for this machine"},
        {"tcpq://:7700", "no address of a hub"},
        {"tcpq://0.0.0.0:7700", "no address of a hub"},
        {"tcpq://127.0.0.1.1.1.1.1.1:7700", "no address of a hub"},
        {"tcpq://239.255.76.67:7667", "expected udpm:// before it"},
        {"tcpq://127.0.0.1:7700?ttl=1", "tcpq:// has no options"},
        {"udpm://", "port is missing"},
        {"udpm://239.255.76.67", "port is missing"},
        {"udpm://239.255.76.67?ttl=1", "port is missing"},
        {"udpm://239.255.76.67:", "port ''"},
        {"udpm://239.255.76.67:0", "port '0'"},
        {"udpm://239.255.76.67:65534", "port '65534'"},
        {"udpm://239.255.76.67:-1", "port '-1'"},
        {"udpm://239.255.76.67:7667x", "port '7667x'"},
        {"udpm://239.255.76.67:99999999999999999999", "expected a number from 1 to 65533"},
        {"udpm://:7667", "no dotted number"},
        {"udpm://host.example:7667", "no dotted number"},
        {"udpm://239.255.76:7667", "no dotted number"},
        {"udpm://239.255.76.67.1.1.1.1.1:7667", "no dotted number"},
        {"udpm://[ff02::1]:7667", "no dotted number"},
        {"udpm://127.0.0.1:7667", "not a multicast address"},
        {"udpm://192.168.1.5:7667", "not a multicast address"},
        {"udpm://240.0.0.1:7667", "not a multicast address"},
        {"udpm://239.255.76.67:7667?ttl", "ttl: expected a number from 0 to 255"},
        {"udpm://239.255.76.67:7667?ttl=", "ttl: expected"},
        {"udpm://239.255.76.67:7667?ttl=256", "ttl: expected"},
        {"udpm://239.255.76.67:7667?ttl=one", "found 'one'"},
        {"udpm://239.255.76.67:7667?ttl=1&ttl=2", "ttl is given twice"},
        {"udpm://239.255.76.67:7667?recv_buf_size=0", "recv_buf_size: expected"},
        {"udpm://239.255.76.67:7667?transmit_only=true", "unknown option 'transmit_only=true'"},
        {"udpm://239.255.76.67:7667?ttl=1?ttl=2", "ttl: expected"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct url url;
        struct error error;
        assert_int_equal(url_parse(&url, cases[i].url, &error), STATUS_INVALID);
        if (strstr(error.text, cases[i].reason) == NULL || strstr(error.text, cases[i].url) == NULL)
            fail_msg("%s: expected '%s', found '%s'", cases[i].url, cases[i].reason, error.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(complete_and_short_urls_are_read),
        cmocka_unit_test(hubs_are_read),
        cmocka_unit_test(unusable_urls_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
