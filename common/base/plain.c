#include "common/base/plain.h"

#include <glib.h>

char *plain_text(const char *text)
{
    GString *plain = g_string_new(NULL);
    for (const char *c = text; *c != '\0'; c = g_utf8_next_char(c)) {
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
