// Texts that workers ask for by digest.
#include "coordinator/runtime/texts.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { REPEAT_NS = 1000 };

static const char words[] = "front rails and spring domes";

static const uint8_t *ask(struct texts *texts, const struct digest *digest, size_t offset,
                          int64_t now_ns)
{
    size_t size = 0;
    return texts_ask(texts, digest, offset, now_ns, REPEAT_NS, &size);
}

// A worker finds what was offered, with its size; nothing else is found.
static void offered_text_is_found_by_its_digest(void **state)
{
    (void)state;
    struct texts *texts = texts_create();
    const struct digest digest = digest_of(words, sizeof words);
    const struct digest other = digest_of(words, sizeof words - 1);
    texts_add(texts, &digest, words, sizeof words);
    size_t size = 0;
    assert_ptr_equal(texts_ask(texts, &digest, 0, 0, REPEAT_NS, &size), words);
    assert_int_equal(size, sizeof words);
    assert_null(ask(texts, &other, 0, 0));
    texts_free(texts);
}

// An offset at or beyond the end comes from a confused or hostile worker: it gets nothing.
static void offset_beyond_the_end_is_refused(void **state)
{
    (void)state;
    struct texts *texts = texts_create();
    const struct digest digest = digest_of(words, sizeof words);
    texts_add(texts, &digest, words, sizeof words);
    assert_non_null(ask(texts, &digest, sizeof words - 1, 0));
    assert_null(ask(texts, &digest, sizeof words, 5000));
    assert_null(ask(texts, &digest, (size_t)INT32_MAX, 9000));
    texts_free(texts);
}

// A hundred workers ask for the same text at once: it is sent once, later again, and at once from
// another place for the one that missed a piece.
static void same_place_is_not_sent_twice_at_once(void **state)
{
    (void)state;
    struct texts *texts = texts_create();
    const struct digest digest = digest_of(words, sizeof words);
    texts_add(texts, &digest, words, sizeof words);
    assert_non_null(ask(texts, &digest, 0, 0));
    assert_null(ask(texts, &digest, 0, REPEAT_NS - 1));
    assert_non_null(ask(texts, &digest, 7, REPEAT_NS - 1));
    assert_non_null(ask(texts, &digest, 0, REPEAT_NS));
    texts_free(texts);
}

// Two searches may share a scenario: the text stays until both have taken it back.
static void text_offered_twice_stays_until_removed_twice(void **state)
{
    (void)state;
    struct texts *texts = texts_create();
    const struct digest digest = digest_of(words, sizeof words);
    texts_add(texts, &digest, words, sizeof words);
    texts_add(texts, &digest, words, sizeof words);
    texts_remove(texts, &digest);
    assert_non_null(ask(texts, &digest, 0, 0));
    texts_remove(texts, &digest);
    assert_null(ask(texts, &digest, 0, 5000));
    texts_remove(texts, &digest);
    texts_free(texts);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(offered_text_is_found_by_its_digest),
        cmocka_unit_test(offset_beyond_the_end_is_refused),
        cmocka_unit_test(same_place_is_not_sent_twice_at_once),
        cmocka_unit_test(text_offered_twice_stays_until_removed_twice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
