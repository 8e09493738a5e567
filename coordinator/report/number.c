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

char *report_name_plain(const char *name)
{
    GString *plain = g_string_new(NULL);
    for (const char *c = name; *c != '\0'; c = g_utf8_next_char(c)) {
        gunichar character = g_utf8_get_char_validated(c, -1);
        if (character >= (gunichar)-2) { // not UTF-8: nothing behind it can be trusted either
            g_string_append_c(plain, '?');
            break;
        }
        if (g_unichar_isprint(character))
            g_string_append_unichar(plain, character);
        else
            g_string_append_c(plain, '?');
    }
    return g_string_free(plain, FALSE);
}
