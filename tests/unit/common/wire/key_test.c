#include "messages.h"

#include "common/wire/key.h"

#include <fcntl.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];
static char *path;
static struct error error;

static int in_a_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/key-test-XXXXXX");
    path = g_build_filename(g_mkdtemp(folder), "key", NULL);
    return 0;
}

static int without_the_folder(void **state)
{
    (void)state;
    g_unlink(path);
    g_free(path);
    return g_rmdir(folder);
}

// Puts `text` into the file, with this mode.
static void write_file(const char *text, mode_t mode)
{
    assert_true(g_file_set_contents(path, text, -1, NULL));
    assert_int_equal(chmod(path, mode), 0);
}

static char *read_text(void)
{
    static char *text; // not automatic: gcc 12 takes that for a pointer that dangles
    assert_true(g_file_get_contents(path, &text, NULL, NULL));
    return text;
}

static void assert_refused(const char *because)
{
    struct key *key = NULL;
    assert_int_equal(key_read(&key, path, &error), STATUS_INVALID);
    assert_null(key);
    assert_non_null(strstr(error.text, path));
    if (strstr(error.text, because) == NULL)
        fail_msg("expected '%s' in '%s'", because, error.text);
}

// The way of every key: made, copied as text, read. Two programs must come to the same bytes.
static void key_written_is_the_key_read(void **state)
{
    (void)state;
    struct key *key, *copy;
    char name[KEY_NAME_SIZE], name_of_copy[KEY_NAME_SIZE];
    assert_int_equal(key_write_new(path, &error), STATUS_OK);
    assert_int_equal(key_read(&key, path, &error), STATUS_OK);
    char *text = read_text();
    write_file(text, 0400);
    assert_int_equal(key_read(&copy, path, &error), STATUS_OK);
    assert_memory_equal(key->bytes, copy->bytes, KEY_SIZE);
    assert_string_equal(key_name(key, name), key_name(copy, name_of_copy));
    g_free(text);
    key_free(key);
    key_free(copy);
}

// The digits are the bytes, in order, and the name is not among them.
static void digits_are_the_bytes(void **state)
{
    (void)state;
    struct key *key;
    char name[KEY_NAME_SIZE];
    assert_int_equal(key_write_new(path, &error), STATUS_OK);
    assert_int_equal(key_read(&key, path, &error), STATUS_OK);
    char hex[2 * KEY_SIZE + 1], *text = read_text();
    sodium_bin2hex(hex, sizeof hex, key->bytes, KEY_SIZE);
    assert_non_null(strstr(text, hex));
    key_name(key, name);
    assert_int_equal(strlen(name), KEY_NAME_SIZE - 1);
    name[4] = '\0';
    assert_null(strstr(hex, name));
    g_free(text);
    key_free(key);
}

// From the first moment nobody else may read it, whatever the umask.
static void new_key_is_its_owners_alone(void **state)
{
    (void)state;
    struct stat about;
    mode_t before = umask(0);
    assert_int_equal(key_write_new(path, &error), STATUS_OK);
    umask(before);
    assert_int_equal(stat(path, &about), 0);
    assert_int_equal(about.st_mode & 07777, 0600);
}

// A key that is in use would be gone for good.
static void key_is_never_overwritten(void **state)
{
    (void)state;
    assert_int_equal(key_write_new(path, &error), STATUS_OK);
    char *before = read_text();
    assert_int_equal(key_write_new(path, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "never overwritten"));
    char *after = read_text();
    assert_string_equal(before, after);
    g_free(before);
    g_free(after);
}

// Nor is the file that a link leads to, and none is made where it leads to nothing.
static void new_key_follows_no_link(void **state)
{
    (void)state;
    char *target = g_build_filename(folder, "target", NULL);
    assert_int_equal(symlink(target, path), 0);
    assert_int_equal(key_write_new(path, &error), STATUS_INVALID);
    assert_int_not_equal(access(target, F_OK), 0);
    g_free(target);
}

static void new_key_needs_its_folder(void **state)
{
    (void)state;
    char *nowhere = g_build_filename(folder, "nowhere", "key", NULL);
    assert_int_equal(key_write_new(nowhere, &error), STATUS_IO);
    g_free(nowhere);
}

// Each bit that lets somebody else in is refused, and the remedy named.
static void key_that_others_may_use_is_refused(void **state)
{
    (void)state;
    static const mode_t modes[] = {0640, 0620, 0610, 0604, 0602, 0601, 0644, 0666, 0440, 0777};
    assert_int_equal(key_write_new(path, &error), STATUS_OK);
    for (size_t i = 0; i < G_N_ELEMENTS(modes); i++) {
        assert_int_equal(chmod(path, modes[i]), 0);
        assert_refused("chmod 600");
    }
}

// A link with strict permissions to a file with loose ones must not be judged by the link.
static void link_is_judged_by_its_target(void **state)
{
    (void)state;
    struct key *key;
    char *target = g_build_filename(folder, "target", NULL);
    assert_int_equal(key_write_new(target, &error), STATUS_OK);
    assert_int_equal(symlink(target, path), 0);
    assert_int_equal(key_read(&key, path, &error), STATUS_OK);
    key_free(key);
    assert_int_equal(chmod(target, 0644), 0);
    assert_refused("chmod 600");
    g_unlink(target);
    g_free(target);
}

static void what_is_no_file_is_refused(void **state)
{
    (void)state;
    assert_refused("--new-key");
    assert_int_equal(mkfifo(path, 0600), 0); // must not wait for a writer
    assert_refused("this is none");
    g_unlink(path);
    assert_int_equal(g_mkdir(path, 0700), 0);
    assert_refused("this is none");
    assert_int_equal(g_rmdir(path), 0);
}

// Takes the text.
static void assert_text_refused(char *text)
{
    write_file(text, 0600);
    assert_refused("not a key file");
    g_free(text);
}

// Half a key, a key with something behind it, another header: none may pass for a key.
static void what_is_no_key_is_refused(void **state)
{
    (void)state;
    assert_int_equal(key_write_new(path, &error), STATUS_OK);
    char *good = read_text();
    char *digits = strchr(good, '\n') + 1;
    for (size_t size = 0; size < strlen(good) - 1; size++)
        assert_text_refused(g_strndup(good, size));
    assert_text_refused(g_strdup(digits));
    assert_text_refused(g_strdup("sobox-key 2\n"));
    assert_text_refused(g_strconcat(good, "0", NULL));
    assert_text_refused(g_strdup_printf("%.*s\n00%s", (int)(digits - good - 1), good, digits));
    digits[5] = 'g';
    assert_text_refused(g_strdup(good));
    g_free(good);
}

// Copied through a mail or an editor of another system, it is the same key.
static void line_ends_of_other_systems_are_taken(void **state)
{
    (void)state;
    struct key *key, *same;
    assert_int_equal(key_write_new(path, &error), STATUS_OK);
    assert_int_equal(key_read(&key, path, &error), STATUS_OK);
    char *good = read_text();
    char **lines = g_strsplit(good, "\n", 3);
    char *texts[] = {g_strdup_printf("%s\r\n%s\r\n", lines[0], lines[1]),
                     g_strdup_printf("%s\n%s", lines[0], lines[1]),
                     g_strdup_printf("%s\n%s\n\n", lines[0], lines[1])};
    for (size_t i = 0; i < G_N_ELEMENTS(texts); i++) {
        write_file(texts[i], 0600);
        assert_int_equal(key_read(&same, path, &error), STATUS_OK);
        assert_memory_equal(same->bytes, key->bytes, KEY_SIZE);
        key_free(same);
        g_free(texts[i]);
    }
    g_strfreev(lines);
    g_free(good);
    key_free(key);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, in_a_folder, without_the_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(key_written_is_the_key_read),
        TEST(digits_are_the_bytes),
        TEST(new_key_is_its_owners_alone),
        TEST(key_is_never_overwritten),
        TEST(new_key_follows_no_link),
        TEST(new_key_needs_its_folder),
        TEST(key_that_others_may_use_is_refused),
        TEST(link_is_judged_by_its_target),
        TEST(what_is_no_file_is_refused),
        TEST(what_is_no_key_is_refused),
        TEST(line_ends_of_other_systems_are_taken),
    };
    return sodium_init() < 0 ? 1 : cmocka_run_group_tests(tests, NULL, NULL);
}
