#include "coordinator/search/ranking.h"

#include "common/numeric/random.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { COUNT_MAX = 40000 };

static double key[COUNT_MAX];
static uint32_t order[COUNT_MAX];
static uint64_t scratch[2 * COUNT_MAX];

// Indexes go in backwards, so that equal keys must come out with falling indexes.
static void assert_ranked(uint32_t count, double least, double most)
{
    for (uint32_t i = 0; i < count; i++)
        order[i] = count - 1 - i;
    ranking_sort(order, count, key, least, most, scratch);
    for (uint32_t i = 1; i < count; i++) {
        const double before = key[order[i - 1]];
        const double here = key[order[i]];
        assert_true(before < here || (before == here && order[i - 1] > order[i]));
    }
}

// Every width of digit is used, and none is right for the sizes next to it by chance.
static void keys_ascend_whatever_their_number(void **state)
{
    (void)state;
    static const uint32_t counts[] = {0,   1,   2,    24,   25,   127,   128,
                                      129, 300, 1023, 1024, 5000, 32768, COUNT_MAX};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        for (uint32_t i = 0; i < counts[c]; i++)
            key[i] = 2 * random_uniform(1, 0, 0, i, 0) - 1;
        assert_ranked(counts[c], -1, 1);
    }
}

// A sort by cells forgets the order of what shares one, or compares what need not be compared.
static void equal_keys_keep_their_order(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 5000; i++)
        key[i] = floor(5 * random_uniform(2, 0, 0, i, 0));
    assert_ranked(5000, -UINT16_MAX, UINT16_MAX);
    for (uint32_t i = 0; i < 5000; i++)
        key[i] = 3;
    assert_ranked(5000, 3, 3);
}

// Keys over the whole range of exponents: nearly all share a cell, in that cell nearly all share
// one, and so on, down to differences whose reciprocal is no number.
static void crowded_cells_are_parted(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 3000; i++)
        key[i] = ldexp(1 + random_uniform(3, 0, 0, i, 0), (int)(i % 2090) - 1070);
    assert_ranked(3000, 0, DBL_MAX);
    for (uint32_t i = 0; i < 3000; i++)
        key[i] = (i % 7) * DBL_TRUE_MIN;
    assert_ranked(3000, 0, 1);
    for (uint32_t i = 0; i < 100; i++)
        key[i] = i % 2 == 0 ? -DBL_MAX : DBL_MAX * random_uniform(4, 0, 0, i, 0);
    assert_ranked(100, -DBL_MAX, DBL_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_ascend_whatever_their_number),
        cmocka_unit_test(equal_keys_keep_their_order),
        cmocka_unit_test(crowded_cells_are_parted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
