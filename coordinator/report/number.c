#include "coordinator/report/number.h"

#include <glib.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

const char *number_exact(double value, char text[NUMBER_SIZE])
{
    if (!isfinite(value))
        return strcpy(text, isnan(value) ? "nan" : value > 0 ? "inf" : "-inf");
    // 15 digits are enough for most numbers that people write, 17 for all there are.
    for (int digits = 15; digits <= 17; digits++) {
        char format[8];
        g_snprintf(format, sizeof format, "%%.%dg", digits);
        g_ascii_formatd(text, NUMBER_SIZE, format, value);
        if (g_ascii_strtod(text, NULL) == value)
            break;
    }
    return text;
}

const char *number_count(uint64_t value, char text[NUMBER_SIZE])
{
    char digits[NUMBER_SIZE];
    int count = g_snprintf(digits, sizeof digits, "%" PRIu64, value);
    char *at = text;
    for (int i = 0; i < count; i++) {
        if (i > 0 && (count - i) % 3 == 0)
            *at++ = ',';
        *at++ = digits[i];
    }
    *at = '\0';
    return text;
}
