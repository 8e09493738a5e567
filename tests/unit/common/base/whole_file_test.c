#include "common/base/whole_file.h"

#include <fcntl.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

struct folder {
    char *path;
    char *file; // in it
};

static int setup(void **state)
{
    struct folder *folder = g_new0(struct folder, 1);
    folder->path = g_dir_make_tmp("sobox-whole-XXXXXX", NULL);
    folder->file = g_build_filename(folder->path, "file", NULL);
    *state = folder;
    return folder->path == NULL;
}

static int teardown(void **state)
{
    struct folder *folder = *state;
    g_unlink(folder->file);
    g_rmdir(folder->path);
    g_free(folder->path);
    g_free(folder->file);
    g_free(folder);
    return 0;
}

static void assert_holds(const char *path, const char *expected)
{
    char *text = NULL;
    assert_true(g_file_get_contents(path, &text, NULL, NULL));
    assert_string_equal(text, expected);
    g_free(text);
}

static void assert_only_entry(const char *folder, const char *expected)
{
    GDir *entries = g_dir_open(folder, 0, NULL);
    assert_non_null(entries);
    const char *name;
    while ((name = g_dir_read_name(entries)) != NULL)
        assert_string_equal(name, expected);
    g_dir_close(entries);
}

// A file that is there is replaced, and nothing is left beside it.
static void file_is_replaced_whole(void **state)
{
    const struct folder *folder = *state;
    struct error error = {0};
    assert_int_equal(whole_file_write(folder->file, "old and long", 12, &error), STATUS_OK);
    assert_int_equal(whole_file_write(folder->file, "new", 3, &error), STATUS_OK);
    assert_holds(folder->file, "new");
    assert_only_entry(folder->path, "file");
}

// What fails half-way leaves the old file, and nothing beside it.
static void failure_leaves_what_was_there(void **state)
{
    const struct folder *folder = *state;
    struct error error = {0};
    struct whole_file whole;
    assert_int_equal(whole_file_write(folder->file, "old", 3, &error), STATUS_OK);
    assert_int_equal(whole_file_begin(&whole, folder->file, &error), STATUS_OK);
    fputs("half", whole.file);
    assert_int_equal(whole_file_end(&whole, STATUS_FAILED, &error), STATUS_FAILED);
    assert_holds(folder->file, "old");
    assert_only_entry(folder->path, "file");
}

// Root may rename over anything: a pipe, or /dev/stdout, would be gone after the first write.
static void pipe_is_written_to_and_stays(void **state)
{
    const struct folder *folder = *state;
    struct error error = {0};
    assert_int_equal(mkfifo(folder->file, 0600), 0);
    // Opened for both ways a pipe waits for nobody.
    FILE *pipe = fopen(folder->file, "r+");
    assert_non_null(pipe);
    assert_int_equal(whole_file_write(folder->file, "news\n", 5, &error), STATUS_OK);
    char line[8];
    assert_non_null(fgets(line, sizeof line, pipe));
    assert_string_equal(line, "news\n");
    fclose(pipe);
    GStatBuf there;
    assert_int_equal(g_stat(folder->file, &there), 0);
    assert_true(S_ISFIFO(there.st_mode));
}

// A full disk is an error that is told: without a look at the end the bytes would be lost in a
// buffer. The device goes by another name, for fear of a file put into its place.
static void full_disk_is_told(void **state)
{
    (void)state;
    struct error error = {0};
    const int device = open("/dev/full", O_WRONLY);
    assert_true(device >= 0);
    char *path = g_strdup_printf("/proc/self/fd/%d", device);
    assert_int_equal(whole_file_write(path, "news", 4, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "cannot be written: No space left on device"));
    g_free(path);
    close(device);
}

// A link leads to where the file really is, for instance on another disk: it is followed.
static void link_stays_and_its_file_is_replaced(void **state)
{
    const struct folder *folder = *state;
    struct error error = {0};
    char *link = g_build_filename(folder->path, "link", NULL);
    assert_int_equal(whole_file_write(folder->file, "old", 3, &error), STATUS_OK);
    assert_int_equal(symlink("file", link), 0);
    assert_int_equal(whole_file_write(link, "new", 3, &error), STATUS_OK);
    assert_holds(folder->file, "new");
    assert_true(g_file_test(link, G_FILE_TEST_IS_SYMLINK));
    g_unlink(link);
    g_free(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(file_is_replaced_whole, setup, teardown),
        cmocka_unit_test_setup_teardown(failure_leaves_what_was_there, setup, teardown),
        cmocka_unit_test_setup_teardown(pipe_is_written_to_and_stays, setup, teardown),
        cmocka_unit_test(full_disk_is_told),
        cmocka_unit_test_setup_teardown(link_stays_and_its_file_is_replaced, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
