#include "common/scenario/field.h"

#include "common/scenario/scenario.h"

#include <glib.h>
#include <stdio.h>
#include <string.h>

enum { EXPECTED_SIZE = 160 }; // [bytes] of what a message says would be right

// ------------------------------------------------------------------------------------------------
// Messages

static const char *describe_range(const struct field_range *range, const char *unit,
                                  char text[EXPECTED_SIZE])
{
    const char *gap = unit == NULL ? "" : " ";
    if (unit == NULL)
        unit = "";
    bool from = isfinite(range->min), to = isfinite(range->max);
    if (from && to && range->open)
        snprintf(text, EXPECTED_SIZE, "more than %.16g and less than %.16g%s%s", range->min,
                 range->max, gap, unit);
    else if (from && to)
        snprintf(text, EXPECTED_SIZE, "%.16g to %.16g%s%s", range->min, range->max, gap, unit);
    else if (from)
        snprintf(text, EXPECTED_SIZE, range->open ? "more than %.16g%s%s" : "at least %.16g%s%s",
                 range->min, gap, unit);
    else
        snprintf(text, EXPECTED_SIZE, "a number%s%s", gap, unit);
    return text;
}

static const char *describe_words(const char *const *words, char text[EXPECTED_SIZE])
{
    text[0] = '\0';
    for (uint32_t i = 0; words[i] != NULL; i++) {
        if (i > 0)
            g_strlcat(text, words[i + 1] == NULL ? " or " : ", ", EXPECTED_SIZE);
        g_strlcat(text, words[i], EXPECTED_SIZE);
    }
    return text;
}

static bool found(const struct tree_node *node, const char *expected, struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    tree_error(node, error, "expected %s, found %s", expected, tree_shown(node, shown));
    return false;
}

// What a field holds, for the message about its absence.
static const char *describe_field(const struct field *field, char text[EXPECTED_SIZE])
{
    if (field->expected != NULL)
        return field->expected;
    switch (field->kind) {
    case FIELD_WORD:
        return describe_words(field->words, text);
    case FIELD_NAME:
    case FIELD_IDENTIFIER:
        return "a name";
    case FIELD_NUMBER_PAIR:
        return "a list of 2 numbers";
    default:
        return describe_range(&field->range, field->unit, text);
    }
}

// Edits (insert, delete, replace a byte) that turn one word into the other: Levenshtein's distance,
// row by row.
static uint32_t edit_distance(const char *a, const char *b)
{
    enum { LENGTH_MAX = 63 };
    size_t length = strlen(b);
    if (strlen(a) > LENGTH_MAX || length > LENGTH_MAX)
        return UINT32_MAX;
    uint32_t row[LENGTH_MAX + 1];
    for (uint32_t j = 0; j <= length; j++)
        row[j] = j;
    for (uint32_t i = 0; a[i] != '\0'; i++) {
        uint32_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < length; j++) {
            uint32_t replaced = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = MIN(replaced, MIN(row[j], row[j + 1]) + 1);
        }
    }
    return row[length];
}

// The known word that was probably meant: at most a third of its letters differ.
static const char *nearest(const char *word, const char *const *known)
{
    const char *best = NULL;
    uint32_t best_distance = UINT32_MAX;
    for (; *known != NULL; known++) {
        uint32_t distance = edit_distance(word, *known);
        if (distance < best_distance && distance <= MAX(1, strlen(*known) / 3)) {
            best = *known;
            best_distance = distance;
        }
    }
    return best;
}

bool field_unknown_key(const struct tree_node *key, const char *what, const char *const *known,
                       struct error *error)
{
    char shown[TREE_SHOWN_SIZE];
    tree_shown(key, shown);
    const char *quote = shown[0] == '\'' ? "" : "'";
    const char *meant = nearest(key->text, known);
    if (meant != NULL) {
        tree_error(key, error, "unknown %s %s%s%s; did you mean '%s'?", what, quote, shown, quote,
                   meant);
        return false;
    }
    char *list = g_strjoinv(", ", (char **)known);
    tree_error(key, error, "unknown %s %s%s%s; expected one of %s", what, quote, shown, quote,
               list);
    g_free(list);
    return false;
}

// ------------------------------------------------------------------------------------------------
// Numbers

// sign? digits (. digits)? (e sign? digits)?, with digits on at least one side of the point.
// Anything else that strtod() takes (hexadecimal, "inf", blanks) is not a number here.
static bool looks_like_number(const char *text)
{
    if (*text == '+' || *text == '-')
        text++;
    size_t before = strspn(text, "0123456789"), after = 0;
    text += before;
    if (*text == '.') {
        after = strspn(++text, "0123456789");
        text += after;
    }
    if (before + after == 0)
        return false;
    if (*text == 'e' || *text == 'E') {
        text++;
        if (*text == '+' || *text == '-')
            text++;
        size_t digits = strspn(text, "0123456789");
        if (digits == 0)
            return false;
        text += digits;
    }
    return *text == '\0';
}

// YAML's words for numbers that are none.
static bool not_finite(const char *text)
{
    if (*text == '+' || *text == '-')
        text++;
    return g_ascii_strcasecmp(text, ".inf") == 0 || g_ascii_strcasecmp(text, ".nan") == 0 ||
           g_ascii_strcasecmp(text, "inf") == 0 || g_ascii_strcasecmp(text, "nan") == 0;
}

static bool in_range(double number, const struct field_range *range)
{
    return range->open ? number > range->min && number < range->max
                       : number >= range->min && number <= range->max;
}

static bool read_number(const struct tree_node *node, const struct field_range *range,
                        const char *unit, double *number, struct error *error)
{
    char expected[EXPECTED_SIZE];
    if (node->kind == TREE_SCALAR && !node->quoted && not_finite(node->text))
        return found(node, "a finite number", error);
    if (node->kind != TREE_SCALAR || node->quoted || !looks_like_number(node->text)) {
        snprintf(expected, sizeof expected, "a number%s%s%s", unit == NULL ? "" : " (in ",
                 unit == NULL ? "" : unit, unit == NULL ? "" : ")");
        return found(node, expected, error);
    }
    double value = g_ascii_strtod(node->text, NULL);
    if (fabs(value) > FIELD_NUMBER_MAX)
        return found(node, "a number of at most 1e15", error);
    if (!in_range(value, range))
        return found(node, describe_range(range, unit, expected), error);
    *number = value;
    return true;
}

// A whole number, also written as 20e3. Doubles hold all of them up to FIELD_COUNT_MAX.
static bool read_count(const struct tree_node *node, const struct field_range *range,
                       uint64_t *count, struct error *error)
{
    char bounds[EXPECTED_SIZE], expected[EXPECTED_SIZE + 32];
    snprintf(expected, sizeof expected, "a whole number, %s", describe_range(range, NULL, bounds));
    if (node->kind != TREE_SCALAR || node->quoted || !looks_like_number(node->text))
        return found(node, expected, error);
    double value = g_ascii_strtod(node->text, NULL);
    if (!in_range(value, range) || value != floor(value) || fabs(value) > FIELD_COUNT_MAX)
        return found(node, expected, error);
    *count = (uint64_t)value;
    return true;
}

bool field_read_numbers(const struct tree_node *node, const struct field_range *range,
                        const char *unit, double *numbers, uint32_t count, struct error *error)
{
    if (node->kind == TREE_SEQUENCE) {
        if (node->count != count) {
            tree_error(node, error, "expected a number or a list of %u, found a list of %u", count,
                       node->count);
            return false;
        }
        for (uint32_t i = 0; i < count; i++) {
            if (!read_number(node->items[i], range, unit, &numbers[i], error))
                return false;
        }
        return true;
    }
    if (node->kind == TREE_MAPPING)
        return found(node, "a number or a list of numbers", error);
    if (!read_number(node, range, unit, &numbers[0], error))
        return false;
    for (uint32_t i = 1; i < count; i++)
        numbers[i] = numbers[0];
    return true;
}

static bool read_pair(const struct tree_node *node, const struct field *field, double pair[2],
                      struct error *error)
{
    if (node->kind != TREE_SEQUENCE || node->count != 2)
        return found(node, "a list of 2 numbers", error);
    return read_number(node->items[0], &field->range, field->unit, &pair[0], error) &&
           read_number(node->items[1], &field->range, field->unit, &pair[1], error);
}

// ------------------------------------------------------------------------------------------------
// Words and names

static bool read_word(const struct tree_node *node, const char *const *words, void *value,
                      struct error *error)
{
    char expected[EXPECTED_SIZE];
    if (node->kind == TREE_SCALAR) {
        for (int i = 0; words[i] != NULL; i++) {
            if (strcmp(words[i], node->text) == 0) {
                memcpy(value, &i, sizeof i);
                return true;
            }
        }
    }
    return found(node, describe_words(words, expected), error);
}

static bool printable(const char *text)
{
    for (; *text != '\0'; text = g_utf8_next_char(text)) {
        if (!g_unichar_isprint(g_utf8_get_char(text)) || *text == '/')
            return false;
    }
    return true;
}

static bool identifier(const char *text)
{
    return strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
           strlen(text);
}

static bool read_name(const struct tree_node *node, enum field_kind kind, char *name,
                      struct error *error)
{
    const char *expected = kind == FIELD_IDENTIFIER
                               ? "a name of 1 to 63 letters, digits, '_' or '-'"
                               : "a name of 1 to 63 printable bytes without '/' that does not "
                                 "begin with '.'";
    if (node->kind != TREE_SCALAR || (!node->quoted && strcmp(node->text, "null") == 0))
        return found(node, expected, error);
    size_t length = strlen(node->text);
    bool allowed = kind == FIELD_IDENTIFIER ? identifier(node->text)
                                            : printable(node->text) && node->text[0] != '.';
    if (length == 0 || length >= SCENARIO_NAME_SIZE || !allowed)
        return found(node, expected, error);
    memcpy(name, node->text, length + 1);
    return true;
}

// ------------------------------------------------------------------------------------------------
// Mappings

bool field_read_value(const struct tree_node *node, const struct field *field, void *value,
                      struct error *error)
{
    uint64_t count;
    switch (field->kind) {
    case FIELD_NUMBER:
        return read_number(node, &field->range, field->unit, value, error);
    case FIELD_NUMBER_PAIR:
        return read_pair(node, field, value, error);
    case FIELD_COUNT:
        if (!read_count(node, &field->range, &count, error))
            return false;
        *(uint32_t *)value = (uint32_t)count;
        return true;
    case FIELD_COUNT_64:
        return read_count(node, &field->range, value, error);
    case FIELD_WORD:
        return read_word(node, field->words, value, error);
    case FIELD_NAME:
    case FIELD_IDENTIFIER:
        return read_name(node, field->kind, value, error);
    case FIELD_NODE:
        *(const struct tree_node **)value = node;
        return true;
    }
    return false;
}

static bool refuse_unknown_keys(const struct tree_node *mapping, const struct field *fields,
                                size_t field_count, struct error *error)
{
    const char **known = g_new0(const char *, field_count + 1);
    for (size_t i = 0; i < field_count; i++)
        known[i] = fields[i].key;
    bool accepted = true;
    for (uint32_t i = 0; i < mapping->count && accepted; i++) {
        if (!g_strv_contains(known, mapping->keys[i]->text))
            accepted = field_unknown_key(mapping->keys[i], "key", known, error);
    }
    g_free(known);
    return accepted;
}

static bool require_keys(const struct tree_node *mapping, const struct field *fields,
                         size_t field_count, struct error *error)
{
    for (size_t i = 0; i < field_count; i++) {
        if (fields[i].optional || tree_child(mapping, fields[i].key) != NULL)
            continue;
        char expected[EXPECTED_SIZE];
        tree_error(mapping, error, "missing key '%s': expected %s", fields[i].key,
                   describe_field(&fields[i], expected));
        return false;
    }
    return true;
}

bool field_read(const struct tree_node *mapping, const struct field *fields, size_t field_count,
                void *target, struct error *error)
{
    if (mapping->kind != TREE_MAPPING)
        return found(mapping, "a mapping", error);
    if (!refuse_unknown_keys(mapping, fields, field_count, error) ||
        !require_keys(mapping, fields, field_count, error))
        return false;
    for (size_t i = 0; i < field_count; i++) {
        const struct tree_node *node = tree_child(mapping, fields[i].key);
        if (node != NULL &&
            !field_read_value(node, &fields[i], (char *)target + fields[i].offset, error))
            return false;
    }
    return true;
}
