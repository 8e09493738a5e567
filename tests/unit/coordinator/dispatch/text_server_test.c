// Texts that workers ask for by digest.
#include "coordinator/dispatch/text_server.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <string.h>

static const char words[] = "front rails and spring domes";

enum { REPEAT_NS = sizeof words * TEXT_SERVER_BYTE_NS };

static const uint8_t *ask(struct text_server *server, const struct digest *digest, size_t offset,
                          int64_t now_ns)
{
    size_t size = 0;
    return text_server_ask(server, digest, offset, now_ns, &size);
}

// A worker finds what was offered, with its size; nothing else is found.
static void offered_text_is_found_by_its_digest(void **state)
{
    (void)state;
    struct text_server *server = text_server_create();
    const struct digest digest = digest_of(words, sizeof words);
    const struct digest other = digest_of(words, sizeof words - 1);
    text_server_offer(server, &digest, words, sizeof words);
    size_t size = 0;
    assert_memory_equal(text_server_ask(server, &digest, 0, 0, &size), words, sizeof words);
    assert_int_equal(size, sizeof words);
    assert_null(ask(server, &other, 0, 0));
    text_server_free(server);
}

// An offset at or beyond the end comes from a confused or hostile worker: it gets nothing.
static void offset_beyond_the_end_is_refused(void **state)
{
    (void)state;
    struct text_server *server = text_server_create();
    const struct digest digest = digest_of(words, sizeof words);
    text_server_offer(server, &digest, words, sizeof words);
    assert_non_null(ask(server, &digest, sizeof words - 1, 0));
    assert_null(ask(server, &digest, sizeof words, 5000));
    assert_null(ask(server, &digest, (size_t)INT32_MAX, 9000));
    text_server_free(server);
}

// A hundred workers ask for the same text at once: it is sent once, later again, and at once from
// another place for the one that missed a piece.
static void same_place_is_not_sent_twice_at_once(void **state)
{
    (void)state;
    struct text_server *server = text_server_create();
    const struct digest digest = digest_of(words, sizeof words);
    text_server_offer(server, &digest, words, sizeof words);
    assert_non_null(ask(server, &digest, 0, 0));
    assert_null(ask(server, &digest, 0, REPEAT_NS - 1));
    assert_non_null(ask(server, &digest, 7, REPEAT_NS - 1));
    assert_non_null(ask(server, &digest, 0, REPEAT_NS));
    text_server_free(server);
}

// Two searches may offer the same box, and the one that offered it last may be done first and use
// its memory for something else: the other one's workers still get the text that was promised.
static void text_outlives_the_memory_it_came_from(void **state)
{
    (void)state;
    struct text_server *server = text_server_create();
    const struct digest digest = digest_of(words, sizeof words);
    char first[sizeof words], second[sizeof words];
    memcpy(first, words, sizeof words);
    memcpy(second, words, sizeof words);
    text_server_offer(server, &digest, first, sizeof first);
    text_server_offer(server, &digest, second, sizeof second);
    text_server_withdraw(server, &digest);
    memset(second, 0, sizeof second);
    memset(first, 0, sizeof first);
    assert_memory_equal(ask(server, &digest, 0, 0), words, sizeof words);
    text_server_free(server);
}

// Two searches may share a scenario: the text stays until both have taken it back.
static void text_offered_twice_stays_until_removed_twice(void **state)
{
    (void)state;
    struct text_server *server = text_server_create();
    const struct digest digest = digest_of(words, sizeof words);
    text_server_offer(server, &digest, words, sizeof words);
    text_server_offer(server, &digest, words, sizeof words);
    text_server_withdraw(server, &digest);
    assert_non_null(ask(server, &digest, 0, 0));
    text_server_withdraw(server, &digest);
    assert_null(ask(server, &digest, 0, 5000));
    text_server_withdraw(server, &digest);
    text_server_free(server);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(offered_text_is_found_by_its_digest),
        cmocka_unit_test(offset_beyond_the_end_is_refused),
        cmocka_unit_test(same_place_is_not_sent_twice_at_once),
        cmocka_unit_test(text_outlives_the_memory_it_came_from),
        cmocka_unit_test(text_offered_twice_stays_until_removed_twice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
