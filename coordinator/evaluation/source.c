#include "coordinator/evaluation/source.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <inttypes.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { READ_SIZE = 1 << 18 }; // [bytes] asked for at once

struct source {
    char *name;
    int descriptor;
    uint64_t file_size; // 0: not known
    GByteArray *bytes;  // read and not given yet
    uint64_t given;     // bytes
    uint64_t line;      // of the first byte in `bytes`
    bool at_end;        // nothing more is to be read
};

enum status source_open(struct source **opened, const char *path, struct error *error)
{
    const bool standard = strcmp(path, "-") == 0;
    *opened = NULL;
    const int descriptor = standard ? dup(STDIN_FILENO) : open(path, O_RDONLY | O_CLOEXEC);
    struct stat file;
    if (descriptor < 0 || fstat(descriptor, &file) != 0) {
        const enum status status = error_set(error, STATUS_INVALID, "%s: cannot be read: %s",
                                             standard ? "standard input" : path, g_strerror(errno));
        if (descriptor >= 0)
            close(descriptor);
        return status;
    }
    struct source *source = g_new0(struct source, 1);
    source->name = g_strdup(standard ? "standard input" : path);
    source->descriptor = descriptor;
    source->file_size = S_ISREG(file.st_mode) ? (uint64_t)file.st_size : 0;
    source->bytes = g_byte_array_new();
    source->line = 1;
    *opened = source;
    return STATUS_OK;
}

void source_close(struct source *source)
{
    if (source == NULL)
        return;
    close(source->descriptor);
    g_byte_array_unref(source->bytes);
    g_free(source->name);
    g_free(source);
}

const char *source_name(const struct source *source)
{
    return source->name;
}

int source_descriptor(const struct source *source)
{
    return source->descriptor;
}

uint64_t source_size(const struct source *source)
{
    return source->file_size;
}

bool source_ended(const struct source *source)
{
    return source->at_end && source->bytes->len == 0;
}

enum status source_fill(struct source *source, struct error *error)
{
    const guint have = source->bytes->len;
    g_byte_array_set_size(source->bytes, have + READ_SIZE);
    ssize_t size;
    do {
        size = read(source->descriptor, source->bytes->data + have, READ_SIZE);
    } while (size < 0 && errno == EINTR);
    g_byte_array_set_size(source->bytes, have + (guint)MAX(size, 0));
    if (size < 0 && errno != EAGAIN)
        return error_set(error, STATUS_IO, "%s: cannot be read: %s", source->name,
                         g_strerror(errno));
    source->at_end = size == 0;
    return STATUS_OK;
}

// Drops bytes that have been given.
static void drop(struct source *source, size_t size, uint64_t lines)
{
    g_byte_array_remove_range(source->bytes, 0, (guint)size);
    source->given += size;
    source->line += lines;
}

static enum status too_long(const struct source *source, uint64_t line, struct error *error)
{
    return error_set(error, STATUS_INVALID,
                     "%s:%" PRIu64 ":1: expected lines of at most %d bytes, one for each design",
                     source->name, line, SOURCE_PIECE_SIZE);
}

enum status source_piece(struct source *source, struct source_piece *piece, struct error *error)
{
    *piece = (struct source_piece){.line = source->line};
    const guint have = source->bytes->len;
    if (have < SOURCE_PIECE_SIZE && !source->at_end)
        return STATUS_OK;
    const char *text = (const char *)source->bytes->data;
    const size_t reach = MIN(have, SOURCE_PIECE_SIZE);
    size_t size = 0; // of whole lines
    uint64_t lines = 0;
    while (lines < SOURCE_PIECE_LINES && size < reach) {
        const char *newline = memchr(text + size, '\n', reach - size);
        if (newline == NULL)
            break;
        size = (size_t)(newline + 1 - text);
        lines++;
    }
    // The last line may end with the file.
    if (lines < SOURCE_PIECE_LINES && source->at_end && reach == have)
        size = have;
    if (size == 0)
        return have == 0 ? STATUS_OK : too_long(source, source->line, error);
    piece->text = g_memdup2(text, size);
    piece->size = size;
    drop(source, size, lines);
    piece->end = source->given;
    return STATUS_OK;
}

static void skip_byte_order_mark(struct source *source)
{
    static const char mark[] = {'\xEF', '\xBB', '\xBF'};
    if (source->bytes->len >= sizeof mark && memcmp(source->bytes->data, mark, sizeof mark) == 0)
        drop(source, sizeof mark, 0);
}

static bool is_blank(const char *line, const char *end)
{
    while (line < end && (g_ascii_isspace(*line)))
        line++;
    return line == end || *line == '#';
}

// Reads on until a whole line is there; its size with its newline, 0 at the end.
static enum status fill_line(struct source *source, size_t *size, struct error *error)
{
    size_t looked = 0; // bytes without a newline
    for (;;) {
        const guint have = source->bytes->len;
        const uint8_t *newline =
            have > looked ? memchr(source->bytes->data + looked, '\n', have - looked) : NULL;
        looked = have;
        *size = newline != NULL ? (size_t)(newline + 1 - source->bytes->data) : have;
        if (newline != NULL || source->at_end)
            return *size <= SOURCE_PIECE_SIZE ? STATUS_OK : too_long(source, source->line, error);
        if (have > SOURCE_PIECE_SIZE)
            return too_long(source, source->line, error);
        const enum status status = source_fill(source, error);
        if (status != STATUS_OK)
            return status;
    }
}

enum status source_header(struct source *source, struct source_piece *header, struct error *error)
{
    assert(source->given == 0);
    *header = (struct source_piece){0};
    for (bool first = true;; first = false) {
        size_t size;
        enum status status = fill_line(source, &size, error);
        if (status != STATUS_OK)
            return status;
        if (first) {
            skip_byte_order_mark(source);
            size -= (size_t)source->given;
        }
        if (size == 0)
            return error_set(error, STATUS_INVALID,
                             "%s:%" PRIu64 ":1: expected a header with the names of the variables, "
                             "found the end",
                             source->name, source->line);
        const char *line = (const char *)source->bytes->data;
        if (!is_blank(line, line + size)) {
            *header = (struct source_piece){
                .text = g_memdup2(line, size), .size = size, .line = source->line};
            drop(source, size, 1);
            header->end = source->given;
            return STATUS_OK;
        }
        drop(source, size, 1);
    }
}
