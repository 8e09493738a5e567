#include "coordinator/evaluation/decimal.h"

#include <glib.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    DIGITS_EXACT = 15,    // that every double holds, and whose integer is exact as one
    DIGITS_ALL = 17,      // that tell any two doubles apart
    POWER_EXACT_MAX = 22, // greatest power of ten that is exact as a double
    POWER_LONG_MAX = 27,  // and as a long double of 64 bits
};

#define INTEGER_EXACT_MAX (UINT64_C(1) << 53) // up to which every integer is a double

_Static_assert(__LDBL_MANT_DIG__ == 64, "decimal_write() needs the long double of x86");

static const double powers[POWER_EXACT_MAX + 1] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
};

static const long double long_powers[POWER_LONG_MAX + 1] = {
    1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,  1e7L,  1e8L,  1e9L,
    1e10L, 1e11L, 1e12L, 1e13L, 1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L,
    1e20L, 1e21L, 1e22L, 1e23L, 1e24L, 1e25L, 1e26L, 1e27L,
};

// ---- Reading ----

// A decimal number taken apart: digits x 10^exponent.
struct parts {
    uint64_t digits;
    int digit_count; // significant ones
    int exponent;
    bool negative;
};

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

// An exponent of which more than four digits would decide nothing.
static const char *read_exponent(const char *at, const char *end, int *exponent)
{
    const bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+'))
        at++;
    if (at == end || !is_digit(*at))
        return NULL;
    int value = 0;
    for (; at < end && is_digit(*at); at++)
        value = value < 10000 ? 10 * value + (*at - '0') : value;
    *exponent += negative ? -value : value;
    return at;
}

// Takes a number apart; false when it is none. Digits beyond the 19th are counted, not kept.
static bool take_apart(const char *at, const char *end, struct parts *parts)
{
    *parts = (struct parts){.negative = at < end && *at == '-'};
    if (at < end && (*at == '-' || *at == '+'))
        at++;
    bool any = false, point = false;
    for (; at < end; at++) {
        if (*at == '.' && !point) {
            point = true;
            continue;
        }
        if (!is_digit(*at))
            break;
        any = true;
        if (parts->digits > 0 || *at != '0')
            parts->digit_count++;
        if (parts->digit_count <= 19)
            parts->digits = 10 * parts->digits + (uint64_t)(*at - '0');
        parts->exponent -= point;
    }
    if (any && at < end && (*at == 'e' || *at == 'E'))
        at = read_exponent(at + 1, end, &parts->exponent);
    return any && at == end;
}

// What the fast way cannot do; the text is known to be a number.
static bool read_slowly(const char *text, size_t size, double *number)
{
    char small[64];
    char *copy = size < sizeof small ? small : g_malloc(size + 1);
    memcpy(copy, text, size);
    copy[size] = '\0';
    *number = g_ascii_strtod(copy, NULL);
    if (copy != small)
        g_free(copy);
    return isfinite(*number);
}

// An integer and a power of ten that are both exact need one operation, which is rounded as the
// number itself would be (Clinger 1990, "How to read floating point numbers accurately").
bool decimal_read(const char *text, size_t size, double *number)
{
    struct parts parts;
    if (!take_apart(text, text + size, &parts))
        return false;
    if (parts.digit_count > DIGITS_EXACT || abs(parts.exponent) > POWER_EXACT_MAX)
        return read_slowly(text, size, number);
    const double digits = (double)parts.digits;
    const double value =
        parts.exponent < 0 ? digits / powers[-parts.exponent] : digits * powers[parts.exponent];
    *number = parts.negative ? -value : value;
    return true;
}

// ---- Writing ----

static size_t write_slowly(double number, char text[DECIMAL_SIZE])
{
    char digits[G_ASCII_DTOSTR_BUF_SIZE];
    if (isnan(number))
        return (size_t)g_snprintf(text, DECIMAL_SIZE, "nan");
    if (isinf(number))
        return (size_t)g_snprintf(text, DECIMAL_SIZE, number > 0 ? "inf" : "-inf");
    g_ascii_formatd(digits, sizeof digits, "%.15g", number);
    if (g_ascii_strtod(digits, NULL) != number)
        g_ascii_formatd(digits, sizeof digits, "%.17g", number);
    return g_strlcpy(text, digits, DECIMAL_SIZE);
}

// Writes 0.00123, 12.3 or 123: `digits` (count of them) with the point behind the one of weight
// 10^0, where the first has weight 10^leading. Zeros at the end are left out.
static size_t write_digits(uint64_t digits, int count, int leading, char *text)
{
    char figures[24];
    for (int i = count - 1; i >= 0; i--, digits /= 10)
        figures[i] = (char)('0' + digits % 10);
    const int whole = leading + 1; // figures in front of the point
    while (count > whole && count > 1 && figures[count - 1] == '0')
        count--;
    char *at = text;
    if (whole <= 0) {
        *at++ = '0';
        *at++ = '.';
        for (int i = whole; i < 0; i++)
            *at++ = '0';
        memcpy(at, figures, (size_t)count);
        return (size_t)(at + count - text);
    }
    memcpy(at, figures, (size_t)MIN(whole, count));
    at += MIN(whole, count);
    if (count > whole) {
        *at++ = '.';
        memcpy(at, figures + whole, (size_t)(count - whole));
        at += count - whole;
    }
    return (size_t)(at - text);
}

// Scaled to an integer of 17 digits in 64 bits of mantissa, a number is off by 0.0055 of the last
// digit at most, so its rounding is within 0.506 of it; half the distance to the next double is
// 0.55 or more. So what is written reads back as the same number.
size_t decimal_write(double number, char text[DECIMAL_SIZE])
{
    const double size = fabs(number);
    if (number == 0) {
        const bool negative = signbit(number) != 0;
        memcpy(text, "-0", 2);
        text[0] = negative ? '-' : '0';
        return negative ? 2 : 1;
    }
    if (!(size >= 1e-4 && size < 1e14))
        return write_slowly(number, text);
    int leading = (int)floor(log10(size)); // may be off by one beside a power of ten
    const int exact_scale = DIGITS_EXACT - 1 - leading, all_scale = DIGITS_ALL - 1 - leading;
    char *at = text;
    if (number < 0)
        *at++ = '-';
    uint64_t digits = (uint64_t)llrintl((long double)size * long_powers[exact_scale]);
    int count = DIGITS_EXACT;
    if (digits > INTEGER_EXACT_MAX || (double)digits / powers[exact_scale] != size) {
        digits = (uint64_t)llrintl((long double)size * long_powers[all_scale]);
        count = DIGITS_ALL;
    }
    const uint64_t greatest =
        count == DIGITS_ALL ? UINT64_C(100000000000000000) : UINT64_C(1000000000000000);
    if (digits >= greatest) { // rounded up to the next power of ten, or the logarithm was
        count++;
        leading++;
    } else if (digits < greatest / 10) {
        count--;
        leading--;
    }
    return (size_t)(at - text) + write_digits(digits, count, leading, at);
}
