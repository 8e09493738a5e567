#include "monitor/feed/cases.h"

#include <string.h>

static void forget(struct cases *cases)
{
    for (guint i = 0; i < cases->entries->len; i++)
        g_strfreev(g_array_index(cases->entries, struct cases_entry, i).texts);
    g_array_set_size(cases->entries, 0);
    g_clear_pointer(&cases->axes, g_strfreev);
}

void cases_init(struct cases *cases)
{
    *cases = (struct cases){.entries = g_array_new(FALSE, TRUE, sizeof(struct cases_entry))};
}

void cases_fini(struct cases *cases)
{
    if (cases->entries == NULL)
        return;
    forget(cases);
    g_array_free(cases->entries, TRUE);
    *cases = (struct cases){0};
}

// What could move the cursor of a terminal is shown as a question mark; a journal may hold
// anything.
static char *printable(const char *text)
{
    char *copy = g_strdup(text);
    for (char *c = copy; *c != '\0'; c = g_utf8_next_char(c)) {
        if (!g_unichar_isprint(g_utf8_get_char(c)))
            memset(c, '?', (size_t)(g_utf8_next_char(c) - c));
    }
    return copy;
}

// The next `columns` texts of a message, from `at` on.
static char **texts_take(const sobox_cases_t *message, uint32_t columns, int32_t *at)
{
    char **texts = g_new0(char *, columns + 1);
    for (uint32_t i = 0; i < columns && *at < message->text_size; i++) {
        const char *text = (const char *)message->text + *at;
        texts[i] = printable(text);
        *at += (int32_t)strlen(text) + 1;
    }
    return texts;
}

// Puts the texts in a place unless they are there already.
static bool place(char ***old, char **texts)
{
    if (*old != NULL && g_strv_equal((const char *const *)*old, (const char *const *)texts)) {
        g_strfreev(texts);
        return false;
    }
    g_strfreev(*old);
    *old = texts;
    return true;
}

bool cases_hear(struct cases *cases, const sobox_cases_t *message, uint64_t version)
{
    const uint32_t columns = (uint32_t)message->columns;
    if (cases->columns != columns)
        forget(cases);
    cases->columns = columns;
    bool news = false;
    int32_t at = 0;
    if (message->first < 0)
        news = place(&cases->axes, texts_take(message, columns, &at));
    for (uint32_t i = (uint32_t)MAX(message->first, 0);
         message->first >= 0 && at < message->text_size && i < CASES_KNOWN_MAX; i++) {
        if (cases->entries->len <= i)
            g_array_set_size(cases->entries, i + 1);
        struct cases_entry *one = &g_array_index(cases->entries, struct cases_entry, i);
        if (place(&one->texts, texts_take(message, columns, &at))) {
            one->changed = version;
            news = true;
        }
    }
    if (news)
        cases->changed = version;
    return news;
}

char *const *cases_find(const struct cases *cases, uint32_t index)
{
    return index < cases->entries->len
               ? g_array_index(cases->entries, struct cases_entry, index).texts
               : NULL;
}
