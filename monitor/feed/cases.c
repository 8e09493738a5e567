#include "monitor/feed/cases.h"

#include "common/protocol/protocol.h"

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

// Puts the texts, which it takes over, in a place unless they are there already.
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

bool cases_put(struct cases *cases, int32_t index, char *const *texts, uint64_t version)
{
    const uint32_t columns = g_strv_length((char **)texts);
    if (index >= CASES_KNOWN_MAX)
        return false;
    if (cases->columns != columns)
        forget(cases);
    cases->columns = columns;
    char **shown = g_new0(char *, columns + 1);
    for (uint32_t i = 0; i < columns; i++)
        shown[i] = printable(texts[i]);
    if (index >= 0 && cases->entries->len <= (guint)index)
        g_array_set_size(cases->entries, (guint)index + 1);
    struct cases_entry *entry =
        index >= 0 ? &g_array_index(cases->entries, struct cases_entry, index) : NULL;
    if (!place(entry != NULL ? &entry->texts : &cases->axes, shown))
        return false;
    if (entry != NULL)
        entry->changed = version;
    cases->changed = version;
    return true;
}

bool cases_hear(struct cases *cases, const sobox_cases_t *message, uint64_t version)
{
    char *texts[1 + PROTOCOL_AXIS_MAX + 1] = {NULL};
    bool news = false;
    int32_t index = message->first;
    for (int32_t at = 0; at < message->text_size; index++) {
        for (int32_t i = 0; i < message->columns; i++) {
            texts[i] = (char *)message->text + at;
            at += (int32_t)strlen(texts[i]) + 1;
        }
        news |= cases_put(cases, index, texts, version);
    }
    return news;
}

char *const *cases_find(const struct cases *cases, uint32_t index)
{
    return index < cases->entries->len
               ? g_array_index(cases->entries, struct cases_entry, index).texts
               : NULL;
}
