#include "worker/models/csv.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void csv_start(struct csv *csv, const char *source, const char *text, size_t size)
{
    csv->source = source;
    csv->rest = text;
    csv->end = text + size;
    csv->line = 0;
    csv->field_count = 0;
}

void csv_continue(struct csv *csv, const char *text, size_t size)
{
    assert(csv->rest == csv->end && csv->field_count == 0);
    csv->line--; // which csv_row() had set behind the last line
    csv->rest = text;
    csv->end = text + size;
}

static bool csv_is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

// The text from `from` to `to` without blanks at both ends.
static struct csv_field csv_trimmed(const char *line, const char *from, const char *to)
{
    while (from < to && csv_is_blank(*from)) {
        from++;
    }
    while (from < to && csv_is_blank(to[-1])) {
        to--;
    }
    return (struct csv_field){from, (size_t)(to - from), (uint32_t)(from - line) + 1};
}

// Splits a line at its commas.
static enum status csv_split(struct csv *csv, const char *line, const char *line_end,
                             struct error *error)
{
    const char *from = line;
    for (;;) {
        const char *comma = memchr(from, ',', (size_t)(line_end - from));
        const char *to = comma != NULL ? comma : line_end;
        if (csv->field_count == CSV_FIELD_MAX) {
            csv->field_count = 0;
            return csv_error(csv, 0, error, "expected at most %d fields", CSV_FIELD_MAX);
        }
        csv->fields[csv->field_count++] = csv_trimmed(line, from, to);
        if (comma == NULL) {
            return STATUS_OK;
        }
        from = comma + 1;
    }
}

enum status csv_row(struct csv *csv, struct error *error)
{
    csv->field_count = 0;
    while (csv->rest < csv->end) {
        const char *line = csv->rest;
        const char *newline = memchr(line, '\n', (size_t)(csv->end - line));
        const char *line_end = newline != NULL ? newline : csv->end;
        csv->rest = newline != NULL ? newline + 1 : csv->end;
        csv->line++;
        if (csv_trimmed(line, line, line_end).size > 0 && *line != '#') {
            return csv_split(csv, line, line_end, error);
        }
    }
    csv->line++; // so that a message about what is missing points behind the last line
    return STATUS_OK;
}

bool csv_is(const struct csv_field *field, const char *word)
{
    return field->size == strlen(word) && memcmp(field->text, word, field->size) == 0;
}

enum status csv_number(const struct csv *csv, uint32_t field, const char *name, const char *unit,
                       double *number, struct error *error)
{
    enum { NUMBER_SIZE = 64 }; // [bytes] with the NUL; longer than any double needs
    const struct csv_field *at = &csv->fields[field];
    char text[NUMBER_SIZE];
    bool whole = false;
    double value = NAN;
    if (at->size > 0 && at->size < sizeof text) {
        char *end;
        memcpy(text, at->text, at->size);
        text[at->size] = '\0';
        value = g_ascii_strtod(text, &end);
        whole = end == text + at->size;
    }
    if (!whole || !isfinite(value)) {
        return csv_error(csv, field, error, "%s: expected a finite number [%s], found \"%.*s\"",
                         name, unit, (int)MIN(at->size, sizeof text), at->text);
    }
    *number = value;
    return STATUS_OK;
}

enum status csv_error(const struct csv *csv, uint32_t field, struct error *error,
                      const char *format, ...)
{
    char message[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    uint32_t column = 1;
    if (field < csv->field_count) {
        column = csv->fields[field].column;
    } else if (csv->field_count > 0) {
        const struct csv_field *last = &csv->fields[csv->field_count - 1];
        column = last->column + (uint32_t)last->size;
    }
    return error_set(error, STATUS_INVALID, "%s:%u:%u: %s", csv->source, csv->line, column,
                     message);
}
