#include "common/scenario/sheet.h"

#include <assert.h>
#include <errno.h>
#include <glib.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

// The reading in progress.
struct reader {
    const char *source;
    const char *at;
    const char *end;
    uint32_t line;
    uint32_t column; // of `at`
    GString *text;   // of the cell being read
    GArray *cells;   // of struct sheet_cell
    struct error *error;
};

static enum status fail(const struct reader *reader, uint32_t line, uint32_t column,
                        const char *format, ...) __attribute__((format(printf, 4, 5)));

static enum status fail(const struct reader *reader, uint32_t line, uint32_t column,
                        const char *format, ...)
{
    char message[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return error_set(reader->error, STATUS_INVALID, "%s:%u:%u: %s", reader->source, line, column,
                     message);
}

// ---- characters ----

static bool at_end(const struct reader *reader)
{
    return reader->at == reader->end;
}

static bool at_line_end(const struct reader *reader)
{
    return at_end(reader) || *reader->at == '\n' || *reader->at == '\r';
}

// Moves behind the character at hand.
static void step(struct reader *reader)
{
    const char character = *reader->at++;
    if (character == '\n') {
        reader->line++;
        reader->column = 1;
    } else if (((unsigned char)character & 0xC0) != 0x80) { // a character's first byte
        reader->column++;
    }
}

static void skip_blanks(struct reader *reader)
{
    while (!at_end(reader) && (*reader->at == ' ' || *reader->at == '\t'))
        step(reader);
}

static void skip_line_end(struct reader *reader)
{
    while (!at_end(reader) && *reader->at == '\r')
        step(reader);
    if (!at_end(reader) && *reader->at == '\n')
        step(reader);
}

// ---- cells ----

// A control character would spoil the messages and tables in which the text appears.
static enum status check_character(const struct reader *reader)
{
    const unsigned char character = (unsigned char)*reader->at;
    if (character >= 0x20 && character != 0x7f)
        return STATUS_OK;
    return fail(reader, reader->line, reader->column,
                "expected text, found the control character 0x%02x", character);
}

static enum status read_quoted(struct reader *reader, const struct sheet_cell *cell)
{
    step(reader);
    for (;;) {
        if (at_line_end(reader))
            return fail(reader, cell->line, cell->column,
                        "expected a closing quote (\") on the same line");
        if (*reader->at == '"') {
            step(reader);
            if (at_end(reader) || *reader->at != '"')
                break;
        } else if (check_character(reader) != STATUS_OK) {
            return STATUS_INVALID;
        }
        g_string_append_c(reader->text, *reader->at);
        step(reader);
    }
    skip_blanks(reader);
    if (!at_line_end(reader) && *reader->at != ',')
        return fail(reader, reader->line, reader->column,
                    "expected a comma or the line's end behind the closing quote");
    return STATUS_OK;
}

static enum status read_plain(struct reader *reader)
{
    while (!at_line_end(reader) && *reader->at != ',') {
        if (check_character(reader) != STATUS_OK)
            return STATUS_INVALID;
        g_string_append_c(reader->text, *reader->at);
        step(reader);
    }
    g_strchomp(reader->text->str);
    return STATUS_OK;
}

static enum status read_cell(struct reader *reader)
{
    skip_blanks(reader);
    struct sheet_cell cell = {.line = reader->line, .column = reader->column};
    g_string_truncate(reader->text, 0);
    bool quoted = !at_end(reader) && *reader->at == '"';
    enum status status = quoted ? read_quoted(reader, &cell) : read_plain(reader);
    if (status != STATUS_OK)
        return status;
    cell.column += quoted ? 1 : 0;
    cell.text = g_strdup(reader->text->str);
    g_array_append_val(reader->cells, cell);
    return STATUS_OK;
}

// ---- rows ----

static enum status read_row(struct reader *reader, uint32_t *count)
{
    for (*count = 1;; ++*count) {
        if (*count > SHEET_COLUMN_MAX)
            return fail(reader, reader->line, reader->column, "expected at most %d columns",
                        SHEET_COLUMN_MAX);
        enum status status = read_cell(reader);
        if (status != STATUS_OK)
            return status;
        if (at_line_end(reader))
            break;
        step(reader); // the comma
    }
    skip_line_end(reader);
    return STATUS_OK;
}

// Empty lines and comments are not rows.
static bool find_row(struct reader *reader)
{
    while (!at_end(reader)) {
        skip_blanks(reader);
        if (!at_line_end(reader) && *reader->at != '#')
            return true;
        while (!at_line_end(reader))
            step(reader);
        skip_line_end(reader);
    }
    return false;
}

static enum status read_rows(struct reader *reader, struct sheet *sheet, uint32_t row_max)
{
    if (!find_row(reader))
        return fail(reader, 1, 1, "expected a header and rows, found nothing");
    enum status status = read_row(reader, &sheet->column_count);
    while (status == STATUS_OK && find_row(reader)) {
        const uint32_t line = reader->line;
        uint32_t count;
        if (sheet->row_count == row_max)
            return fail(reader, line, 1, "expected at most %u rows", row_max);
        status = read_row(reader, &count);
        if (status == STATUS_OK && count != sheet->column_count)
            return fail(reader, line, 1, "expected %u cells as in the header, found %u",
                        sheet->column_count, count);
        sheet->row_count++;
    }
    if (status == STATUS_OK && sheet->row_count == 0)
        return fail(reader, reader->line, 1, "expected rows below the header, found none");
    return status;
}

enum status sheet_read_text(struct sheet *sheet, const char *source, const char *text, size_t size,
                            uint32_t row_max, struct error *error)
{
    static const char mark[] = "\xef\xbb\xbf"; // in which spreadsheets like to begin a file
    *sheet = (struct sheet){.source = g_strdup(source)};
    struct reader reader = {.source = source,
                            .at = text,
                            .end = text + size,
                            .line = 1,
                            .column = 1,
                            .text = g_string_new(NULL),
                            .cells = g_array_new(FALSE, FALSE, sizeof(struct sheet_cell)),
                            .error = error};
    if (size >= sizeof mark - 1 && memcmp(text, mark, sizeof mark - 1) == 0)
        reader.at += sizeof mark - 1;
    enum status status;
    if (size > SHEET_TEXT_SIZE_MAX)
        status = fail(&reader, 1, 1, "expected at most %d bytes", SHEET_TEXT_SIZE_MAX);
    else if (!g_utf8_validate(text, (gssize)size, NULL))
        status = fail(&reader, 1, 1, "expected UTF-8 text");
    else
        status = read_rows(&reader, sheet, row_max);
    const guint count = reader.cells->len;
    g_string_free(reader.text, TRUE);
    sheet->cells = (struct sheet_cell *)(void *)g_array_free(reader.cells, FALSE);
    if (status != STATUS_OK) {
        for (guint i = 0; i < count; i++)
            g_free(sheet->cells[i].text);
        sheet->column_count = sheet->row_count = 0;
        g_free(sheet->cells);
        g_free(sheet->source);
        *sheet = (struct sheet){0};
    }
    return status;
}

enum status sheet_read_file(struct sheet *sheet, const char *path, uint32_t row_max,
                            struct error *error)
{
    *sheet = (struct sheet){0};
    FILE *file = fopen(path, "rb");
    const int reason = errno;
    // One byte more than allowed tells a file that is too long, even one that never ends.
    GByteArray *bytes = g_byte_array_new();
    guint8 piece[65536];
    size_t size = 1;
    while (file != NULL && size > 0 && bytes->len <= SHEET_TEXT_SIZE_MAX) {
        size = fread(piece, 1, sizeof piece, file);
        g_byte_array_append(bytes, piece, (guint)size);
    }
    enum status status;
    if (file == NULL || ferror(file))
        status = error_set(error, STATUS_INVALID, "%s:1:1: expected a file that can be read: %s",
                           path, g_strerror(file == NULL ? reason : EIO));
    else
        status =
            sheet_read_text(sheet, path, (const char *)bytes->data, bytes->len, row_max, error);
    g_byte_array_unref(bytes);
    if (file != NULL)
        fclose(file);
    return status;
}

const struct sheet_cell *sheet_cell(const struct sheet *sheet, uint32_t row, uint32_t column)
{
    assert(row <= sheet->row_count);
    assert(column < sheet->column_count);
    return &sheet->cells[(size_t)row * sheet->column_count + column];
}

void sheet_fini(struct sheet *sheet)
{
    const size_t count =
        sheet->cells != NULL ? (1 + (size_t)sheet->row_count) * sheet->column_count : 0;
    for (size_t i = 0; i < count; i++)
        g_free(sheet->cells[i].text);
    g_free(sheet->cells);
    g_free(sheet->source);
    *sheet = (struct sheet){0};
}
