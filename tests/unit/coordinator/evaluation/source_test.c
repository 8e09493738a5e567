#include "coordinator/evaluation/source.h"
#include "sample_scenario.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <unistd.h>

static char *folder;

static int set_up(void **state)
{
    (void)state;
    folder = g_dir_make_tmp("sobox-source-XXXXXX", NULL);
    return folder != NULL ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    g_rmdir(folder);
    g_free(folder);
    return 0;
}

static char *write_file(const char *text, size_t size)
{
    char *path = g_build_filename(folder, "table.csv", NULL);
    assert_true(g_file_set_contents(path, text, (gssize)size, NULL));
    return path;
}

static struct source *open_text(const char *text, size_t size)
{
    char *path = write_file(text, size);
    struct source *source;
    struct error error = {0};
    if (source_open(&source, path, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    g_unlink(path);
    g_free(path);
    return source;
}

// All pieces of a source, checked on the way; returns how many.
static size_t read_all(struct source *source, GString *text)
{
    size_t pieces = 0;
    uint64_t line = 0;
    while (!source_ended(source)) {
        struct source_piece piece;
        struct error error = {0};
        assert_int_equal(source_piece(source, &piece, &error), STATUS_OK);
        if (piece.text == NULL) {
            assert_int_equal(source_fill(source, &error), STATUS_OK);
            continue;
        }
        assert_in_range(piece.size, 1, SOURCE_PIECE_SIZE);
        assert_true(piece.line > line);
        line = piece.line;
        g_string_append_len(text, piece.text, (gssize)piece.size);
        pieces++;
        g_free(piece.text);
    }
    return pieces;
}

static struct source_piece header_of(struct source *source)
{
    struct source_piece header;
    struct error error = {0};
    if (source_header(source, &header, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    return header;
}

// Nothing is lost or doubled at the seams, wherever lines end, and lines are counted through.
static void pieces_make_the_whole(void **state)
{
    (void)state;
    GString *text = g_string_new("h\n");
    for (int i = 0; i < 60000; i++)
        g_string_append_printf(text, "%d,%0*d\n", i, i % 90 + 1, i);
    struct source *source = open_text(text->str, text->len);
    struct source_piece header = header_of(source);
    GString *found = g_string_new_len(header.text, (gssize)header.size);
    assert_in_range(read_all(source, found), 3, 6);
    assert_int_equal(found->len, text->len);
    assert_memory_equal(found->str, text->str, text->len);
    g_free(header.text);
    source_close(source);
    g_string_free(found, TRUE);
    g_string_free(text, TRUE);
}

// A pipe gives what it has, a byte or a megabyte: the pieces are those of a file all the same, or
// what is read again could not be known again.
static void pieces_of_a_pipe_are_those_of_a_file(void **state)
{
    (void)state;
    GString *text = g_string_new(NULL);
    for (int i = 0; i < 40000; i++)
        g_string_append_printf(text, "%d,%0*d\n", i, i % 60 + 1, i);
    uint64_t ends[2][16];
    size_t count[2] = {0};
    for (int way = 0; way < 2; way++) {
        struct source *source = open_text(text->str, text->len);
        int ends_of_pipe[2] = {-1, -1};
        size_t sent = 0;
        if (way == 1) {
            source_close(source);
            assert_int_equal(pipe(ends_of_pipe), 0);
            char *path = g_strdup_printf("/dev/fd/%d", ends_of_pipe[0]);
            struct error error = {0};
            assert_int_equal(source_open(&source, path, &error), STATUS_OK);
            assert_int_equal(source_size(source), 0);
            g_free(path);
        }
        while (!source_ended(source)) {
            struct source_piece piece;
            struct error error = {0};
            assert_int_equal(source_piece(source, &piece, &error), STATUS_OK);
            if (piece.text != NULL) {
                ends[way][count[way]++] = piece.end;
                g_free(piece.text);
                continue;
            }
            if (way == 1 && sent < text->len) {
                const size_t some = MIN(777, text->len - sent);
                assert_int_equal(write(ends_of_pipe[1], text->str + sent, some), some);
                sent += some;
            } else if (way == 1 && ends_of_pipe[1] >= 0) {
                close(ends_of_pipe[1]);
                ends_of_pipe[1] = -1;
            }
            assert_int_equal(source_fill(source, &error), STATUS_OK);
        }
        source_close(source);
        if (way == 1)
            close(ends_of_pipe[0]);
    }
    assert_int_equal(count[0], count[1]);
    assert_in_range(count[0], 2, 16);
    assert_memory_equal(ends[0], ends[1], count[0] * sizeof ends[0][0]);
    g_string_free(text, TRUE);
}

// Comments in front of the header, and the mark that some editors put there.
static void header_is_the_first_line_that_says_something(void **state)
{
    (void)state;
    static const char text[] = "\xEF\xBB\xBF# made by hand\n\n \t\r\na,b\r\n1,2";
    struct source *source = open_text(text, sizeof text - 1);
    struct source_piece header = header_of(source);
    assert_int_equal(header.line, 4);
    assert_memory_equal(header.text, "a,b\r\n", header.size);
    GString *rest = g_string_new(NULL);
    assert_int_equal(read_all(source, rest), 1);
    assert_string_equal(rest->str, "1,2");
    g_string_free(rest, TRUE);
    g_free(header.text);
    source_close(source);
}

static void assert_header_refused(const char *text, size_t size, const char *complaint)
{
    struct source *source = open_text(text, size);
    struct source_piece header;
    struct error error = {0};
    assert_int_equal(source_header(source, &header, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, complaint));
    source_close(source);
}

// An empty file, one of comments only, and one that is no table at all but a line without end.
static void file_without_header_is_refused(void **state)
{
    (void)state;
    assert_header_refused("", 0,
                          "table.csv:1:1: expected a header with the names of the variables");
    assert_header_refused("# a\n\n", 5, "table.csv:3:1: expected a header");
    char *huge = g_malloc(SOURCE_PIECE_SIZE + 10);
    memset(huge, 'x', SOURCE_PIECE_SIZE + 10);
    assert_header_refused(huge, SOURCE_PIECE_SIZE + 10,
                          "table.csv:1:1: expected lines of at most 1048576 bytes");
    g_free(huge);
}

// A line without end in the middle is refused, and its number told.
static void line_without_end_is_refused(void **state)
{
    (void)state;
    char *text = g_malloc(SOURCE_PIECE_SIZE + 100);
    memset(text, '1', SOURCE_PIECE_SIZE + 100);
    memcpy(text, "a\n1\n", 4);
    struct source *source = open_text(text, SOURCE_PIECE_SIZE + 100);
    struct source_piece piece = header_of(source);
    g_free(piece.text);
    struct error error = {0};
    enum status status = STATUS_OK;
    while (status == STATUS_OK && !source_ended(source)) {
        status = source_piece(source, &piece, &error);
        if (status == STATUS_OK && piece.text == NULL)
            assert_int_equal(source_fill(source, &error), STATUS_OK);
        if (status == STATUS_OK)
            g_free(piece.text);
    }
    assert_int_equal(status, STATUS_INVALID);
    assert_non_null(strstr(error.text, "table.csv:3:1: expected lines of at most"));
    source_close(source);
    g_free(text);
}

// What is not there, and what is no file.
static void what_cannot_be_read_is_said(void **state)
{
    (void)state;
    struct source *source;
    struct error error = {0};
    assert_int_equal(source_open(&source, "nowhere/table.csv", &error), STATUS_INVALID);
    assert_complaint(&error, "nowhere/table.csv: cannot be read: ");
    struct source_piece header;
    assert_int_equal(source_open(&source, folder, &error), STATUS_OK);
    assert_int_equal(source_header(source, &header, &error), STATUS_IO);
    source_close(source);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_make_the_whole),
        cmocka_unit_test(pieces_of_a_pipe_are_those_of_a_file),
        cmocka_unit_test(header_is_the_first_line_that_says_something),
        cmocka_unit_test(file_without_header_is_refused),
        cmocka_unit_test(line_without_end_is_refused),
        cmocka_unit_test(what_cannot_be_read_is_said),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
