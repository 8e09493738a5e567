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
        {"tcpq://127.0.0.1:7700", "expected memq://"},
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
        cmocka_unit_test(unusable_urls_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
