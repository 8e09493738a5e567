#include "hub/relay/pattern.h"

#include <glib.h>
#include <string.h>

struct pattern {
    char *text;
    size_t size;
    GRegex *regex; // NULL: the name of a channel
};

// Without any of these an expression means just its letters, and comparing them is quicker.
static bool is_name(const char *text)
{
    return strpbrk(text, ".[]{}()*+?|^$\\") == NULL;
}

struct pattern *pattern_create(const char *text, size_t size)
{
    struct pattern *pattern = g_new0(struct pattern, 1);
    pattern->text = g_strndup(text, size);
    pattern->size = size;
    if (is_name(pattern->text))
        return pattern;
    // Anchored as LCM's clients do it themselves, so that both sides agree on what matches. RAW:
    // names are bytes.
    char *anchored = g_strdup_printf("(*LIMIT_MATCH=" PATTERN_STEPS ")^%s$", pattern->text);
    pattern->regex = g_regex_new(anchored, G_REGEX_RAW | G_REGEX_DOLLAR_ENDONLY, 0, NULL);
    g_free(anchored);
    if (pattern->regex != NULL)
        return pattern;
    pattern_free(pattern);
    return NULL;
}

void pattern_free(struct pattern *pattern)
{
    if (pattern == NULL)
        return;
    if (pattern->regex != NULL)
        g_regex_unref(pattern->regex);
    g_free(pattern->text);
    g_free(pattern);
}

bool pattern_is(const struct pattern *pattern, const char *text, size_t size)
{
    return pattern->size == size && memcmp(pattern->text, text, size) == 0;
}

bool pattern_matches(const struct pattern *pattern, const char *channel)
{
    if (pattern->regex == NULL)
        return strcmp(pattern->text, channel) == 0;
    return g_regex_match(pattern->regex, channel, 0, NULL);
}
