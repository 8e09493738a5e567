#include "common/numeric/random.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

struct answer {
    uint32_t counter[4];
    uint32_t key[2];
    uint32_t block[4];
};

// The blocks that Random123 lists for philox4x32-10: any slip in the rounds or the key schedule
// shows here.
static void philox_gives_known_answers(void **state)
{
    (void)state;
    static const struct answer answers[] = {
        {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
        {{~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}, {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
        {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
         {0xa4093822, 0x299f31d0},
         {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
    };
    for (size_t i = 0; i < sizeof answers / sizeof *answers; i++) {
        uint32_t block[4];
        random_philox(answers[i].counter, answers[i].key, block);
        assert_memory_equal(block, answers[i].block, sizeof block);
    }
}

// Each argument must reach the counter or the key: two places that differ in one of them would
// otherwise share their numbers.
static void uniform_depends_on_every_argument(void **state)
{
    (void)state;
    const double base = random_uniform(1, 2, 3, 4, 6);
    assert_true(base != random_uniform(0, 2, 3, 4, 6));
    assert_true(base != random_uniform(1 | UINT64_C(1) << 32, 2, 3, 4, 6));
    assert_true(base != random_uniform(1, 0, 3, 4, 6));
    assert_true(base != random_uniform(1, 2, 0, 4, 6));
    assert_true(base != random_uniform(1, 2, 3, 0, 6));
    assert_true(base != random_uniform(1, 2, 3, 4, 7));
    assert_true(base != random_uniform(1, 2, 3, 4, 8));
}

// 1.0 would be above an upper bound after rounding; 0 is allowed.
static void unit_stays_below_one(void **state)
{
    (void)state;
    assert_true(random_unit(~0u, ~0u) == 1 - 0x1p-53);
    assert_true(random_unit(0, 0) == 0);
    assert_true(random_unit(1u << 31, 0) == 0.5);
    assert_true(random_unit(0, 1u << 6) == 0x1p-53);
}

// The mean of 10000 numbers lies within 5 standard errors of a half, their mean square of a third.
static void uniform_is_uniform(void **state)
{
    (void)state;
    double sum = 0;
    double square = 0;
    for (uint32_t i = 0; i < 10000; i++) {
        double unit = random_uniform(7, 0, 1, i, i % 5);
        assert_true(unit >= 0 && unit < 1);
        sum += unit;
        square += unit * unit;
    }
    assert_true(sum / 10000 > 0.4855 && sum / 10000 < 0.5145);
    assert_true(square / 10000 > 0.3184 && square / 10000 < 0.3483);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(philox_gives_known_answers),
        cmocka_unit_test(uniform_depends_on_every_argument),
        cmocka_unit_test(unit_stays_below_one),
        cmocka_unit_test(uniform_is_uniform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
