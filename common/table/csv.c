#include "common/table/csv.h"

#include "common/base/whole_file.h"
#include "common/table/decimal.h"

#include <assert.h>
#include <glib.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

char *csv_load(const char *path, size_t *size, struct error *error)
{
    char *text = whole_file_read(path, CSV_TEXT_SIZE_MAX, size, error);
    if (text == NULL)
        return NULL;
    const char *wrong = *size > CSV_TEXT_SIZE_MAX                     ? "at most 16 MiB of text"
                        : !g_utf8_validate(text, (gssize)*size, NULL) ? "UTF-8 text"
                                                                      : NULL;
    if (wrong == NULL)
        return text;
    error_set(error, STATUS_INVALID, "%s:1:1: expected %s", path, wrong);
    g_free(text);
    return NULL;
}

void csv_start(struct csv *csv, const char *source, const char *text, size_t size)
{
    static const char mark[] = "\xef\xbb\xbf"; // in which spreadsheets like to begin a file
    const bool marked = size >= strlen(mark) && memcmp(text, mark, strlen(mark)) == 0;
    csv->source = source;
    csv->rest = text + (marked ? strlen(mark) : 0);
    csv->end = text + size;
    csv->line = 0;
    csv->line_begin = csv->line_end = csv->rest;
    csv->at = NULL;
    csv->field_count = 0;
}

void csv_continue(struct csv *csv, const char *text, size_t size)
{
    assert(csv->rest == csv->end && csv->field_count == 0);
    csv->line--; // which csv_line() had set behind the last line
    csv->rest = text;
    csv->end = text + size;
}

// ---- Rows ----

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

static const char *skip_blanks(const char *at, const char *end)
{
    while (at < end && is_blank(*at))
        at++;
    return at;
}

bool csv_line(struct csv *csv)
{
    csv->field_count = 0;
    while (csv->rest < csv->end) {
        const char *line = csv->rest;
        const char *newline = memchr(line, '\n', (size_t)(csv->end - line));
        csv->line_begin = csv->at = line;
        csv->line_end = newline != NULL ? newline : csv->end;
        csv->rest = newline != NULL ? newline + 1 : csv->end;
        csv->line++;
        if (*line != '#' && skip_blanks(line, csv->line_end) < csv->line_end)
            return true;
    }
    csv->line++; // so that a message about what is missing points behind the last line
    csv->line_begin = csv->line_end = csv->end;
    csv->at = NULL;
    return false;
}

// Reads the field whose opening quote stands at `from`.
static enum status next_quoted(struct csv *csv, const char *from, struct csv_field *field,
                               struct error *error)
{
    const char *text = from + 1, *to = text;
    for (;; to += 2) { // behind a quote that is doubled
        to = memchr(to, '"', (size_t)(csv->line_end - to));
        if (to == NULL)
            return csv_error_at(csv, from, error, "expected a closing quote (\") on the same line");
        if (to + 1 == csv->line_end || to[1] != '"')
            break;
    }
    const char *behind = skip_blanks(to + 1, csv->line_end);
    if (behind < csv->line_end && *behind != ',')
        return csv_error_at(csv, behind, error,
                            "expected a comma or the line's end behind the closing quote");
    *field = (struct csv_field){text, (size_t)(to - text), true};
    csv->at = behind < csv->line_end ? behind + 1 : NULL;
    return STATUS_OK;
}

enum status csv_next(struct csv *csv, struct csv_field *field, struct error *error)
{
    assert(csv->at != NULL);
    const char *from = skip_blanks(csv->at, csv->line_end);
    if (from < csv->line_end && *from == '"')
        return next_quoted(csv, from, field, error);
    const char *comma = memchr(from, ',', (size_t)(csv->line_end - from));
    const char *to = comma != NULL ? comma : csv->line_end;
    while (from < to && is_blank(to[-1]))
        to--;
    *field = (struct csv_field){from, (size_t)(to - from), false};
    csv->at = comma != NULL ? comma + 1 : NULL;
    return STATUS_OK;
}

enum status csv_row(struct csv *csv, struct error *error)
{
    if (!csv_line(csv))
        return STATUS_OK;
    while (csv->at != NULL) {
        if (csv->field_count == CSV_FIELD_MAX) {
            csv->field_count = 0;
            return csv_error(csv, 0, error, "expected at most %d fields", CSV_FIELD_MAX);
        }
        if (csv_next(csv, &csv->fields[csv->field_count], error) != STATUS_OK)
            return STATUS_INVALID;
        csv->field_count++;
    }
    return STATUS_OK;
}

// ---- Fields ----

bool csv_is(const struct csv_field *field, const char *word)
{
    return field->size == strlen(word) && memcmp(field->text, word, field->size) == 0;
}

char *csv_text(const struct csv_field *field)
{
    char *copy = g_malloc(field->size + 1), *to = copy;
    for (size_t i = 0; i < field->size; i++) {
        *to++ = field->text[i];
        i += field->quoted && field->text[i] == '"'; // the second of two
    }
    *to = '\0';
    return copy;
}

const char *csv_shown(const struct csv_field *field, char shown[CSV_SHOWN_SIZE])
{
    static const char cut[] = "...";
    const size_t size = MIN(field->size, CSV_SHOWN_SIZE - sizeof cut);
    for (size_t i = 0; i < size; i++)
        shown[i] = g_ascii_isprint(field->text[i]) ? field->text[i] : '?';
    g_strlcpy(shown + size, field->size > size ? cut : "", sizeof cut);
    return shown;
}

enum status csv_number(const struct csv *csv, uint32_t field, const char *name, const char *unit,
                       double *number, struct error *error)
{
    const struct csv_field *at = &csv->fields[field];
    char shown[CSV_SHOWN_SIZE];
    double value;
    if (!decimal_read(at->text, at->size, &value))
        return csv_error(csv, field, error, "%s: expected a finite number [%s], found \"%s\"", name,
                         unit, csv_shown(at, shown));
    *number = value;
    return STATUS_OK;
}

// ---- Messages ----

uint32_t csv_column(const struct csv *csv, const char *at)
{
    uint32_t column = 1;
    for (const char *c = csv->line_begin; c < at; c++)
        column += ((unsigned char)*c & 0xC0) != 0x80; // a character's first byte
    return column;
}

static enum status fail(const struct csv *csv, const char *at, struct error *error,
                        const char *format, va_list arguments)
{
    char message[ERROR_TEXT_SIZE];
    vsnprintf(message, sizeof message, format, arguments);
    return error_set(error, STATUS_INVALID, "%s:%" PRIu64 ":%u: %s", csv->source, csv->line,
                     csv_column(csv, at), message);
}

enum status csv_error_at(const struct csv *csv, const char *at, struct error *error,
                         const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const enum status status = fail(csv, at, error, format, arguments);
    va_end(arguments);
    return status;
}

enum status csv_error(const struct csv *csv, uint32_t field, struct error *error,
                      const char *format, ...)
{
    const char *at = csv->line_begin;
    if (field < csv->field_count) {
        at = csv->fields[field].text;
    } else if (csv->field_count > 0) {
        const struct csv_field *last = &csv->fields[csv->field_count - 1];
        at = last->text + last->size;
    }
    va_list arguments;
    va_start(arguments, format);
    const enum status status = fail(csv, at, error, format, arguments);
    va_end(arguments);
    return status;
}
