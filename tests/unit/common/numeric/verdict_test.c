#include "common/numeric/verdict.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { COUNT_MAX = 70, CONSTRAINTS = 5 };

// A repeatable mixture of good and bad verdicts.
static void mixture(struct verdict *verdicts, uint32_t count, uint32_t seed)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t word = (seed + i) * UINT32_C(2654435761);
        bool good = word >> 30 == 0;
        verdicts[i].violation = good ? 0 : (uint16_t)(1 + (word >> 8) % 65535);
        verdicts[i].constraint = good ? 0 : (uint8_t)(word % CONSTRAINTS);
    }
}

// The scale must order as the number does, keep every violation above zero, and set apart what is
// not a number; a NaN taken for good would be the worst mistake of all.
static void scale_orders_violations(void **state)
{
    (void)state;
    assert_int_equal(verdict_violation(0), VERDICT_GOOD);
    assert_int_equal(verdict_violation(-0.0), VERDICT_GOOD);
    assert_int_equal(verdict_violation(-1), VERDICT_GOOD);
    assert_int_equal(verdict_violation(-INFINITY), VERDICT_GOOD);
    assert_int_equal(verdict_violation(DBL_TRUE_MIN), 1);
    assert_int_equal(verdict_violation(NAN), VERDICT_NON_FINITE);
    assert_int_equal(verdict_violation(INFINITY), VERDICT_NON_FINITE);
    uint16_t last = 0;
    for (double relative = 1e-60; relative < 1e60; relative *= 1.3) {
        uint16_t violation = verdict_violation(relative);
        assert_true(violation >= last && violation > 0);
        last = violation;
    }
    assert_true(verdict_violation(DBL_MAX) < VERDICT_NON_FINITE);
    assert_true(verdict_violation(DBL_MAX) >= last);
}

// Eight mantissa bits: the middle of a step is within 1/512 of what was put in.
static void relative_inverts_the_scale(void **state)
{
    (void)state;
    assert_true(verdict_relative(VERDICT_GOOD) == 0);
    assert_true(isinf(verdict_relative(VERDICT_NON_FINITE)));
    assert_true(isfinite(verdict_relative(verdict_violation(DBL_MAX))));
    for (double relative = 1e-30; relative < 1e30; relative *= 1.7) {
        double back = verdict_relative(verdict_violation(relative));
        assert_true(fabs(back / relative - 1) <= 1.0 / 512);
        assert_int_equal(verdict_violation(back), verdict_violation(relative));
    }
}

// What was packed comes out again, for every count around the edges of a byte.
static void full_detail_survives_the_round_trip(void **state)
{
    (void)state;
    for (uint32_t count = 0; count <= COUNT_MAX; count++) {
        struct verdict in[COUNT_MAX];
        struct verdict out[COUNT_MAX];
        mixture(in, count, count);
        uint8_t *packed = malloc(verdict_packed_size_max(count, VERDICT_DETAIL_FULL) + 1);
        size_t size = verdict_pack(in, count, VERDICT_DETAIL_FULL, packed);
        assert_true(size <= verdict_packed_size_max(count, VERDICT_DETAIL_FULL));
        assert_true(verdict_unpack(out, count, VERDICT_DETAIL_FULL, CONSTRAINTS, packed, size));
        for (uint32_t i = 0; i < count; i++) {
            assert_int_equal(in[i].violation, out[i].violation);
            assert_int_equal(in[i].constraint, out[i].constraint);
        }
        free(packed);
    }
}

// A certificate needs one bit a sample: 10 samples are 2 bytes, and bad ones come out as the least.
static void share_detail_keeps_one_bit(void **state)
{
    (void)state;
    struct verdict in[10] = {[3] = {.violation = 700, .constraint = 4}, [9] = {.violation = 9}};
    struct verdict out[10];
    uint8_t packed[2];
    assert_int_equal(verdict_pack(in, 10, VERDICT_DETAIL_SHARE, packed), 2);
    assert_int_equal(packed[0], 0xF7);
    assert_int_equal(packed[1], 0x01);
    assert_true(verdict_unpack(out, 10, VERDICT_DETAIL_SHARE, 1, packed, 2));
    assert_int_equal(verdict_good_count(out, 10), 8);
    assert_int_equal(out[3].violation, 1);
    assert_int_equal(out[3].constraint, 0);
}

static void assert_refused(uint32_t count, const uint8_t *packed, size_t size)
{
    struct verdict out[COUNT_MAX];
    struct verdict before[COUNT_MAX];
    memset(out, 0x5A, sizeof out);
    memset(before, 0x5A, sizeof before);
    assert_false(verdict_unpack(out, count, VERDICT_DETAIL_FULL, CONSTRAINTS, packed, size));
    assert_memory_equal(out, before, sizeof out);
}

// Bytes from the network are refused unless they are exactly what packing writes, and nothing is
// written when they are not.
static void hostile_bytes_are_refused(void **state)
{
    (void)state;
    assert_refused(9, (const uint8_t[]){0xFF}, 1);                    // a byte short
    assert_refused(9, NULL, 0);                                       // nothing at all
    assert_refused(8, (const uint8_t[]){0xFF, 0}, 2);                 // a byte too many
    assert_refused(9, (const uint8_t[]){0xFF, 0x03}, 2);              // an unused bit
    assert_refused(8, (const uint8_t[]){0xFE}, 1);                    // the bad one is missing
    assert_refused(8, (const uint8_t[]){0xFE, CONSTRAINTS, 1, 0}, 4); // no such constraint
    assert_refused(8, (const uint8_t[]){0xFE, 0, 0, 0}, 4);           // bad, yet VERDICT_GOOD
    assert_refused(8, (const uint8_t[]){0xFE, 0, 1, 0, 0, 1, 0}, 7);  // one bad one too many
    assert_refused(8, (const uint8_t[]){0xFE, 0, 1}, 3);              // cut off inside
    struct verdict out[1];
    assert_false(verdict_unpack(out, 1, VERDICT_DETAIL_COUNT, 1, (const uint8_t[]){1}, 1));
}

// Whatever comes, unpacking either refuses or gives what packs to the same bytes; the sanitizers
// watch that no byte beyond the size is read.
static void random_bytes_are_refused_or_round_trip(void **state)
{
    (void)state;
    uint32_t word = 1;
    for (int round = 0; round < 20000; round++) {
        word = word * UINT32_C(1664525) + UINT32_C(1013904223);
        const uint32_t count = word >> 16 & 15;
        const size_t size = word >> 24 & 15;
        uint8_t *bytes = malloc(size + 1);
        for (size_t i = 0; i < size; i++) {
            word = word * UINT32_C(1664525) + UINT32_C(1013904223);
            // Mostly set bits and small numbers: otherwise nearly nothing would be accepted.
            bytes[i] = (uint8_t)(i < 2 ? word >> 24 | word >> 13 : word >> 30);
        }
        struct verdict out[16];
        if (verdict_unpack(out, count, VERDICT_DETAIL_FULL, CONSTRAINTS, bytes, size)) {
            uint8_t again[64];
            assert_int_equal(verdict_pack(out, count, VERDICT_DETAIL_FULL, again), size);
            assert_memory_equal(again, bytes, size);
        }
        free(bytes);
    }
}

// The margin of each sample, good or bad, comes out to the last bit, infinities among them, beside
// what full detail holds.
static void margin_detail_survives_the_round_trip(void **state)
{
    (void)state;
    static const float margins[] = {0, -0.0F, 1e-30F, -3.5F, INFINITY, -INFINITY, FLT_MAX};
    for (uint32_t count = 0; count <= COUNT_MAX; count++) {
        struct verdict in[COUNT_MAX], out[COUNT_MAX];
        mixture(in, count, count);
        uint32_t bad = 0;
        for (uint32_t i = 0; i < count; i++) {
            in[i].margin = margins[i % 7];
            bad += in[i].violation != VERDICT_GOOD;
        }
        uint8_t *packed = malloc(verdict_packed_size_max(count, VERDICT_DETAIL_MARGIN) + 1);
        const size_t size = verdict_pack(in, count, VERDICT_DETAIL_MARGIN, packed);
        assert_int_equal(size, (count + 7) / 8 + 4 * count + 3 * bad);
        assert_true(size <= verdict_packed_size_max(count, VERDICT_DETAIL_MARGIN));
        assert_true(verdict_unpack(out, count, VERDICT_DETAIL_MARGIN, CONSTRAINTS, packed, size));
        for (uint32_t i = 0; i < count; i++) {
            assert_int_equal(in[i].violation, out[i].violation);
            assert_int_equal(in[i].constraint, out[i].constraint);
            assert_memory_equal(&in[i].margin, &out[i].margin, sizeof in[i].margin);
        }
        free(packed);
    }
}

// A margin from the network that is no number would make every comparison false; a size that is
// not that of the margins, or of bad ones behind them, is refused as in full detail.
static void hostile_margins_are_refused(void **state)
{
    (void)state;
    struct verdict in[2] = {{.margin = 0.5F}, {.violation = 7, .constraint = 1, .margin = -1}};
    struct verdict out[2];
    uint8_t packed[1 + 2 * 4 + 3 + 1] = {0};
    const size_t size = verdict_pack(in, 2, VERDICT_DETAIL_MARGIN, packed);
    assert_int_equal(size, sizeof packed - 1);
    assert_true(verdict_unpack(out, 2, VERDICT_DETAIL_MARGIN, 2, packed, size));
    for (size_t other = 0; other <= sizeof packed; other++) {
        if (other != size)
            assert_false(verdict_unpack(out, 2, VERDICT_DETAIL_MARGIN, 2, packed, other));
    }
    assert_false(verdict_unpack(out, 2, VERDICT_DETAIL_MARGIN, 1, packed, size)); // constraint 1
    static const float nothing = NAN;
    for (uint32_t i = 0; i < 2; i++) {
        uint8_t broken[sizeof packed];
        memcpy(broken, packed, sizeof packed);
        memcpy(broken + 1 + 4 * (size_t)i, &nothing, sizeof nothing);
        memset(out, 0x5A, sizeof out);
        assert_false(verdict_unpack(out, 2, VERDICT_DETAIL_MARGIN, 2, broken, size));
        assert_int_equal(out[0].violation, 0x5A5A); // untouched
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scale_orders_violations),
        cmocka_unit_test(relative_inverts_the_scale),
        cmocka_unit_test(full_detail_survives_the_round_trip),
        cmocka_unit_test(share_detail_keeps_one_bit),
        cmocka_unit_test(hostile_bytes_are_refused),
        cmocka_unit_test(margin_detail_survives_the_round_trip),
        cmocka_unit_test(hostile_margins_are_refused),
        cmocka_unit_test(random_bytes_are_refused_or_round_trip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
