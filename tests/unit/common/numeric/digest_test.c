#include "common/numeric/digest.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// BLAKE2b with 16 bytes of the empty text and of "abc": another hash, or a truncated longer one,
// would differ.
static void digest_is_blake2b_128(void **state)
{
    (void)state;
    char hex[DIGEST_HEX_SIZE];
    struct digest digest = digest_of("", 0);
    assert_string_equal(digest_hex(&digest, hex), "cae66941d9efbd404e4d88758ea67670");
    digest = digest_of("abc", 3);
    assert_string_equal(digest_hex(&digest, hex), "cf4ab791c62b8d2b2109c90275287816");
}

// Pieces, numbers and doubles all end up as the same bytes, little end first.
static void numbers_are_little_endian_bytes(void **state)
{
    (void)state;
    const uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F};
    struct digest whole = digest_of(bytes, sizeof bytes);
    struct digest_state pieces;
    digest_start(&pieces);
    digest_u64(&pieces, UINT64_C(0x0807060504030201));
    digest_doubles(&pieces, (double[]){1.0}, 1);
    struct digest sum = digest_end(&pieces);
    assert_true(digest_equal(&whole, &sum));
}

// One changed bit must change the digest, or two runs could not be told apart.
static void one_bit_changes_the_digest(void **state)
{
    (void)state;
    struct digest a = digest_of("box", 3);
    struct digest b = digest_of("boy", 3);
    assert_false(digest_equal(&a, &b));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(digest_is_blake2b_128),
        cmocka_unit_test(numbers_are_little_endian_bytes),
        cmocka_unit_test(one_bit_changes_the_digest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
