#include "common/table/decimal.h"

#include <glib.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    DIGITS_EXACT = 15,    // that every double holds, and whose integer is exact as one
    DIGITS_ALL = 17,      // that tell any two doubles apart
    POWER_EXACT_MAX = 22, // greatest power of ten that is exact as a double
};

static const double powers[POWER_EXACT_MAX + 1] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
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

#define FAST_MIN 1e-4 // numbers from here on, up to but without FAST_MAX, are written the fast way
#define FAST_MAX 1e14

__extension__ typedef unsigned __int128 wide_t;

// A number taken apart: mantissa x 2^exponent, the mantissa of 53 bits.
struct binary {
    uint64_t mantissa;
    int exponent;
};

// Some digits of a number: the first has weight 10^leading.
struct digits {
    uint64_t digits;
    int count;
    int leading;
    bool same; // they read back as the number
};

static size_t write_slowly(double number, char text[DECIMAL_SIZE])
{
    char found[G_ASCII_DTOSTR_BUF_SIZE];
    if (isnan(number))
        return g_strlcpy(text, "nan", DECIMAL_SIZE);
    if (isinf(number))
        return g_strlcpy(text, number > 0 ? "inf" : "-inf", DECIMAL_SIZE);
    for (int count = DIGITS_EXACT; count <= DIGITS_ALL; count++) {
        char format[8];
        g_snprintf(format, sizeof format, "%%.%dg", count);
        g_ascii_formatd(found, sizeof found, format, number);
        if (g_ascii_strtod(found, NULL) == number)
            break;
    }
    return g_strlcpy(text, found, DECIMAL_SIZE);
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

// `count` digits of the number, its first taken to have weight 10^leading, rounded to the nearest
// and to even between two. The number times 10^scale is the whole number mantissa x 5^scale divided
// by 2^shift: in the fast range all of it is exact in 128 bits.
static struct digits round_to(struct binary number, int count, int leading)
{
    const int scale = count - 1 - leading, shift = -(number.exponent + scale);
    uint64_t fives = 1;
    for (int i = 0; i < scale; i++)
        fives *= 5;
    const wide_t exact = (wide_t)number.mantissa * fives;
    const wide_t half = (wide_t)1 << (shift - 1), rest = exact & (2 * half - 1);
    uint64_t digits = (uint64_t)(exact >> shift);
    digits += rest > half || (rest == half && digits % 2 == 1);
    // The doubles beside the number are 2^exponent away, fives x 2^-shift in these digits: nearer
    // than half of that, the digits read back as the number. The one below a power of two is half
    // as far.
    const wide_t rounded = (wide_t)digits << shift;
    const wide_t off = rounded > exact ? rounded - exact : exact - rounded;
    const bool near_below = number.mantissa == UINT64_C(1) << 52 && rounded < exact;
    return (struct digits){digits, count, leading, (near_below ? 4 : 2) * off < fives};
}

// The power of ten at or below 2^exponent, or one less; 1233/4096 is a little below log10(2).
static int leading_at_least(int exponent)
{
    const int product = exponent * 1233;
    return product >= 0 ? product / 4096 : -((-product + 4095) / 4096);
}

static size_t write_fast(double size, char *text)
{
    int exponent;
    const double mantissa = ldexp(frexp(size, &exponent), 53);
    const struct binary number = {(uint64_t)mantissa, exponent - 53};
    const int leading = leading_at_least(exponent - 1);
    uint64_t limit = UINT64_C(1000000000000000); // 10^DIGITS_EXACT
    for (int count = DIGITS_EXACT;; count++, limit *= 10) {
        struct digits found = round_to(number, count, leading);
        if (found.digits >= limit)
            found = round_to(number, count, leading + 1);
        if (found.same || count == DIGITS_ALL)
            return write_digits(found.digits, count, found.leading, text);
    }
}

size_t decimal_write(double number, char text[DECIMAL_SIZE])
{
    const double size = fabs(number);
    if (number != 0 && !(size >= FAST_MIN && size < FAST_MAX))
        return write_slowly(number, text);
    char *at = text;
    if (signbit(number) != 0)
        *at++ = '-';
    if (number == 0)
        *at++ = '0';
    else
        at += write_fast(size, at);
    *at = '\0';
    return (size_t)(at - text);
}

const char *decimal_text(double number, char text[DECIMAL_SIZE])
{
    decimal_write(number, text);
    return text;
}
