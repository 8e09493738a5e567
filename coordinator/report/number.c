#include "coordinator/report/number.h"

#include <glib.h>
#include <inttypes.h>

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
