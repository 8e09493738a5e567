#include "messages.h"

#include <sodium.h>

static const uint8_t text[] = "an encoded message";

// The tag is plain BLAKE2b over channel, NUL and bytes, so that any other program can make it.
static void tag_is_blake2b_of_channel_and_bytes(void **state)
{
    (void)state;
    static const uint8_t whole[] = "SOBOX_TEXT\0an encoded message";
    uint8_t tag[TAG_SIZE], right[TAG_SIZE];
    tag_compute(tag, "SOBOX_TEXT", text, sizeof text - 1);
    crypto_generichash(right, sizeof right, whole, sizeof whole - 1, NULL, 0);
    assert_memory_equal(tag, right, TAG_SIZE);
}

// Moving a byte from the content to the channel's name must not keep the tag.
static void channel_and_bytes_are_kept_apart(void **state)
{
    (void)state;
    uint8_t tag[TAG_SIZE];
    tag_compute(tag, "AB", (const uint8_t *)"C", 1);
    assert_true(tag_matches(tag, "AB", (const uint8_t *)"C", 1));
    assert_false(tag_matches(tag, "A", (const uint8_t *)"BC", 2));
    assert_false(tag_matches(tag, "ABC", (const uint8_t *)"", 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tag_is_blake2b_of_channel_and_bytes),
        cmocka_unit_test(channel_and_bytes_are_kept_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
