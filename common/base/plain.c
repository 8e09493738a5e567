#include "common/base/plain.h"

#include <glib.h>
#include <stdbool.h>

char *plain_text(const char *text)
{
    GString *plain = g_string_new(NULL);
    while (*text != '\0') {
        const gunichar character = g_utf8_get_char_validated(text, -1);
        const bool utf8 = character < (gunichar)-2; // these two say that it is none
        if (utf8 && g_unichar_isprint(character))
            g_string_append_unichar(plain, character);
        else
            g_string_append_c(plain, '?');
        text = utf8 ? g_utf8_next_char(text) : text + 1;
    }
    return g_string_free(plain, FALSE);
}
