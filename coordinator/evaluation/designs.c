#include "coordinator/evaluation/designs.h"

#include "common/table/decimal.h"

#include <glib.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { SHOWN_MAX = 40 }; // [bytes] of a field in a message

// A line being read, for messages.
struct place {
    const char *source;
    uint64_t line;
    const char *begin; // of the line
};

struct field {
    const char *text; // without blanks around it
    size_t size;
};

static enum status complain(const struct place *place, const char *at, struct error *error,
                            const char *format, ...) __attribute__((format(printf, 4, 5)));

static enum status complain(const struct place *place, const char *at, struct error *error,
                            const char *format, ...)
{
    char message[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return error_set(error, STATUS_INVALID, "%s:%" PRIu64 ":%zu: %s", place->source, place->line,
                     (size_t)(at - place->begin) + 1, message);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

// The field that begins at *at, which moves to the comma behind it or to the end.
static struct field next_field(const char **at, const char *end)
{
    const char *from = *at;
    const char *comma = memchr(from, ',', (size_t)(end - from));
    *at = comma != NULL ? comma : end;
    const char *to = *at;
    while (from < to && is_blank(*from))
        from++;
    while (from < to && is_blank(to[-1]))
        to--;
    return (struct field){from, (size_t)(to - from)};
}

static bool field_is(struct field field, const char *word)
{
    return field.size == strlen(word) && memcmp(field.text, word, field.size) == 0;
}

// A field as it may be shown: cut, and without characters that could steer a terminal.
static const char *shown(struct field field, char text[SHOWN_MAX + 4])
{
    const size_t size = MIN(field.size, SHOWN_MAX);
    for (size_t i = 0; i < size; i++)
        text[i] = g_ascii_isprint(field.text[i]) ? field.text[i] : '?';
    g_strlcpy(text + size, field.size > size ? "..." : "", 4);
    return text;
}

static const char *quote_hint(struct field field)
{
    return field.size > 0 && (field.text[0] == '"' || field.text[0] == '\'')
               ? "; fields are written without quotes"
               : "";
}

// ---- The header ----

static enum status take_column(struct designs_layout *layout, GHashTable *numbers,
                               struct field field, const struct place *place, GArray *columns,
                               struct error *error)
{
    char text[SHOWN_MAX + 4];
    int32_t column = DESIGNS_ID;
    if (!field_is(field, "id")) {
        g_autofree char *name = g_strndup(field.text, field.size);
        gpointer number;
        if (!g_hash_table_lookup_extended(numbers, name, NULL, &number))
            return complain(place, field.text, error,
                            "expected the name of a variable of the scenario, as %s, or id; found "
                            "\"%s\"%s",
                            layout->scenario->variables[0].name, shown(field, text),
                            quote_hint(field));
        column = GPOINTER_TO_INT(number);
    }
    for (guint i = 0; i < columns->len; i++)
        if (g_array_index(columns, int32_t, i) == column)
            return complain(place, field.text, error, "expected one column %s, found a second",
                            shown(field, text));
    if (column == DESIGNS_ID)
        layout->id = (int32_t)columns->len;
    g_array_append_val(columns, column);
    return STATUS_OK;
}

// A variable may only be left out where there is nothing to choose.
static enum status check_complete(const struct designs_layout *layout, const struct place *place,
                                  const char *end, struct error *error)
{
    const struct scenario *scenario = layout->scenario;
    const struct box *space = &scenario->design_space;
    g_autofree bool *there = g_new0(bool, space->count);
    for (uint32_t i = 0; i < layout->column_count; i++)
        if (layout->columns[i] != DESIGNS_ID)
            there[layout->columns[i]] = true;
    for (uint32_t i = 0; i < space->count; i++)
        if (!there[i] && space->lower[i] < space->upper[i])
            return complain(place, end, error,
                            "expected a column for every variable that is not fixed: %s is missing",
                            scenario->variables[i].name);
    return STATUS_OK;
}

enum status designs_layout_read(struct designs_layout *layout, const struct scenario *scenario,
                                const char *source, uint64_t line, const char *text, size_t size,
                                struct error *error)
{
    const struct place place = {.source = source, .line = line, .begin = text};
    *layout = (struct designs_layout){.scenario = scenario, .id = -1};
    GHashTable *numbers = g_hash_table_new(g_str_hash, g_str_equal);
    for (uint32_t i = 0; i < scenario->design_space.count; i++)
        g_hash_table_insert(numbers, scenario->variables[i].name, GINT_TO_POINTER((int)i));
    GArray *columns = g_array_new(FALSE, FALSE, sizeof(int32_t));
    const char *end = text + size;
    while (end > text && (is_blank(end[-1]) || end[-1] == '\n'))
        end--;
    enum status status = STATUS_OK;
    for (const char *at = text; status == STATUS_OK; at++) {
        status = take_column(layout, numbers, next_field(&at, end), &place, columns, error);
        if (at == end)
            break;
    }
    layout->column_count = columns->len;
    layout->columns = (int32_t *)(void *)g_array_free(columns, FALSE);
    g_hash_table_unref(numbers);
    if (status == STATUS_OK)
        status = check_complete(layout, &place, end, error);
    if (status != STATUS_OK)
        designs_layout_fini(layout);
    return status;
}

void designs_layout_fini(struct designs_layout *layout)
{
    g_free(layout->columns);
    *layout = (struct designs_layout){0};
}

// ---- The rows ----

static enum status refuse_number(const struct designs_layout *layout, uint32_t column,
                                 struct field field, const struct place *place, struct error *error)
{
    char text[SHOWN_MAX + 4];
    return complain(place, field.text, error, "%s: expected a finite number, found \"%s\"%s",
                    layout->scenario->variables[layout->columns[column]].name, shown(field, text),
                    quote_hint(field));
}

static enum status refuse_count(const struct designs_layout *layout, const char *at,
                                const char *end, uint32_t found, const struct place *place,
                                struct error *error)
{
    for (; at < end; at++)
        found += *at == ',';
    return complain(place, end, error, "expected %u field%s, as in the header, found %u%s",
                    layout->column_count, layout->column_count == 1 ? "" : "s", found,
                    found < layout->column_count ? ": the line is cut off, or a value is missing"
                                                 : "");
}

static enum status read_row(const struct designs_layout *layout, const struct place *place,
                            const char *end, double *values, struct field *id, struct error *error)
{
    const char *at = place->begin;
    for (uint32_t column = 0; column < layout->column_count; column++) {
        const struct field field = next_field(&at, end);
        const int32_t variable = layout->columns[column];
        if (variable == DESIGNS_ID) {
            if (memchr(field.text, '"', field.size) != NULL)
                return complain(place, field.text, error, "id: expected a text without quotes");
            *id = field;
        } else if (!decimal_read(field.text, field.size, &values[variable])) {
            return field.size == 0 && at == end && column + 1 < layout->column_count
                       ? refuse_count(layout, at, end, column + 1, place, error)
                       : refuse_number(layout, column, field, place, error);
        }
        const bool last = column + 1 == layout->column_count;
        if (last != (at == end))
            return refuse_count(layout, at, end, column + 1, place, error);
        at++;
    }
    return STATUS_OK;
}

// Whether there is nothing to read in the line.
static bool line_skipped(const char *line, const char *end)
{
    if (line < end && *line == '#')
        return true;
    while (line < end && is_blank(*line))
        line++;
    return line == end;
}

static uint32_t lines_of(const char *text, size_t size)
{
    uint32_t lines = 0;
    const char *end = text + size;
    for (const char *at = text; at < end; lines++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        at = newline != NULL ? newline + 1 : end;
    }
    return lines;
}

enum status designs_read(struct designs *designs, const struct designs_layout *layout,
                         const char *source, uint64_t line, const char *text, size_t size,
                         struct error *error)
{
    const struct box *space = &layout->scenario->design_space;
    const size_t row_size = space->count * sizeof(double);
    const uint32_t room = lines_of(text, size);
    struct place place = {.source = source, .line = line};
    *designs = (struct designs){.values = g_malloc_n(room, row_size)};
    if (layout->id >= 0) {
        designs->ids = g_new(const char *, room);
        designs->id_sizes = g_new(uint32_t, room);
    }
    const char *end = text + size;
    for (const char *at = text; at < end; place.line++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        const char *line_end = newline != NULL ? newline : end;
        place.begin = at;
        at = newline != NULL ? newline + 1 : end;
        if (line_skipped(place.begin, line_end))
            continue;
        double *values = designs->values + designs->count * (size_t)space->count;
        struct field id = {0};
        memcpy(values, space->lower, row_size); // of the variables without a column all there is
        const enum status status = read_row(layout, &place, line_end, values, &id, error);
        if (status != STATUS_OK) {
            designs_fini(designs);
            return status;
        }
        if (designs->ids != NULL) {
            designs->ids[designs->count] = id.text;
            designs->id_sizes[designs->count] = (uint32_t)id.size;
        }
        designs->count++;
    }
    return STATUS_OK;
}

void designs_fini(struct designs *designs)
{
    g_free(designs->values);
    g_free((void *)designs->ids);
    g_free(designs->id_sizes);
    *designs = (struct designs){0};
}
