#include "common/table/decimal.h"

#include <float.h>
#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { NUMBERS = 200000 };

static bool read_text(const char *text, double *number)
{
    return decimal_read(text, strlen(text), number);
}

static void assert_same_bits(double a, double b)
{
    assert_memory_equal(&a, &b, sizeof a);
}

static void assert_written(double number, const char *text)
{
    char found[DECIMAL_SIZE];
    assert_int_equal(decimal_write(number, found), strlen(text));
    assert_string_equal(found, text);
}

// A sequence of bits without order, the same each time.
static uint64_t next_bits(uint64_t *state)
{
    *state += UINT64_C(0x9E3779B97F4A7C15);
    uint64_t bits = *state;
    bits = (bits ^ bits >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    bits = (bits ^ bits >> 27) * UINT64_C(0x94D049BB133111EB);
    return bits ^ bits >> 31;
}

// The numbers that tables are made of, in the ways in which people and programs write them.
static void numbers_are_read_as_written(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double number;
    } cases[] = {
        {"0", 0},
        {"-0", -0.0},
        {"12", 12},
        {"+12", 12},
        {"450e3", 450e3},
        {"4.5E+5", 450e3},
        {"1e-3", 1e-3},
        {".5", 0.5},
        {"5.", 5},
        {"0.1", 0.1},
        {"-8061.9", -8061.9},
        {"123456789012345678", 123456789012345678.0},
        {"0.30000000000000004", 0.1 + 0.2},
        {"00000000000000000000000012", 12},
        {"1e22", 1e22},
        {"1e23", 1e23},
        {"4.9e-324", 4.9e-324},
        {"1e-400", 0},
        {"1.7976931348623157e308", DBL_MAX},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        double number = 1;
        assert_true(read_text(cases[i].text, &number));
        assert_same_bits(number, cases[i].number);
    }
}

// What a C library would take for a number, a table must not: it is a mistake there.
static void what_is_no_number_is_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {"",      " ",   "-",     "+",    ".",     "e5",   "1e",
                                        "1e+",   "nan", "inf",   "-inf", "0x10",  "1 2",  "1,5",
                                        "1.2.3", "12a", "1e400", "--1",  "\"1\"", "1e5x", "NA"};
    for (size_t i = 0; i < G_N_ELEMENTS(texts); i++) {
        double number;
        assert_false(read_text(texts[i], &number));
    }
    double number;
    assert_false(decimal_read("1\0002", 3, &number));
    assert_true(decimal_read("123456", 3, &number)); // and not a byte further
    assert_true(number == 123);
}

// Fifteen digits where these say it all, sixteen or seventeen else; no exponent for what people
// read.
static void short_numbers_are_written_short(void **state)
{
    (void)state;
    assert_written(0, "0");
    assert_written(-0.0, "-0");
    assert_written(0.15, "0.15");
    assert_written(450e3, "450000");
    assert_written(-8061.9, "-8061.9");
    assert_written(0.0001, "0.0001");
    assert_written(0.1 + 0.2, "0.30000000000000004");
    assert_written(5e-324, "4.94065645841247e-324");
    assert_written(0.1 + 0.7, "0.7999999999999999");
    assert_written(99999999999999.0, "99999999999999");
    assert_written(1e14, "100000000000000");
    assert_written(10, "10");
    assert_written(1e-5, "1e-05");
    assert_written(1e300, "1e+300");
    assert_written(NAN, "nan");
    assert_written(INFINITY, "inf");
    assert_written(-INFINITY, "-inf");
}

static void assert_round_trip(double number)
{
    char text[DECIMAL_SIZE], expected[64];
    double back;
    const size_t size = decimal_write(number, text);
    assert_in_range(size, 1, DECIMAL_SIZE - 1);
    for (int digits = 15; digits <= 17; digits++) {
        g_snprintf(expected, sizeof expected, "%.*g", digits, number);
        if (g_ascii_strtod(expected, NULL) == number)
            break;
    }
    assert_string_equal(text, expected);
    assert_same_bits(g_ascii_strtod(text, NULL), number);
    assert_true(decimal_read(text, size, &back));
    assert_same_bits(back, number);
}

// Whatever is written reads back as the same bits, by our own reader and by the C library's, and is
// what the library would write with as few digits: beside powers of ten, where digits carry over,
// beside powers of two, where doubles are nearer below, and for any mantissa.
static void written_numbers_read_back_the_same(void **state)
{
    (void)state;
    for (int exponent = -20; exponent <= 20; exponent++) {
        const double power = pow(10, exponent);
        double below = power, above = power;
        for (int i = 0; i < 50; i++) {
            assert_round_trip(below);
            assert_round_trip(-above);
            below = nextafter(below, 0);
            above = nextafter(above, INFINITY);
        }
    }
    for (int exponent = -15; exponent <= 48; exponent++) {
        const double power = ldexp(1, exponent);
        assert_round_trip(power);
        assert_round_trip(nextafter(power, 0));
        assert_round_trip(nextafter(power, INFINITY));
    }
    uint64_t bits = 1;
    for (int i = 0; i < NUMBERS; i++) {
        // Of sizes from 2^-16 to 2^47, where the fast way is taken.
        const uint64_t any = next_bits(&bits);
        const uint64_t mantissa = any & ((UINT64_C(1) << 52) - 1);
        const uint64_t number = (uint64_t)(1007 + (any >> 52) % 64) << 52 | mantissa;
        double value;
        memcpy(&value, &number, sizeof value);
        assert_round_trip(value);
        memcpy(&value, &any, sizeof value);
        if (isfinite(value))
            assert_round_trip(value);
    }
}

// What is read is the nearest double, as the C library has it, for numbers of all lengths.
static void numbers_are_read_as_the_library_reads_them(void **state)
{
    (void)state;
    uint64_t bits = 7;
    for (int i = 0; i < NUMBERS; i++) {
        char text[64];
        const uint64_t any = next_bits(&bits);
        const int digits = 1 + (int)(any % 19), exponent = (int)(any >> 32) % 60 - 30;
        g_snprintf(text, sizeof text, "%.*se%d", digits, "7312984650918273645", exponent);
        text[0] = (char)('1' + (any >> 5) % 9);
        text[digits / 2] = (char)('0' + (any >> 9) % 10);
        double number;
        assert_true(read_text(text, &number));
        assert_same_bits(number, g_ascii_strtod(text, NULL));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read_as_written),
        cmocka_unit_test(what_is_no_number_is_refused),
        cmocka_unit_test(short_numbers_are_written_short),
        cmocka_unit_test(written_numbers_read_back_the_same),
        cmocka_unit_test(numbers_are_read_as_the_library_reads_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
