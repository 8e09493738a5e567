// replay PATH...: gives a target each file, or each file of a folder, once. In place of libFuzzer
// in ordinary builds, so that what was once found is tried again in every test run.
#include "tests/fuzz/fuzz.h"

#include <glib.h>
#include <stdio.h>
#include <stdlib.h>

static unsigned count;

static void replay_file(const char *path)
{
    g_autofree char *text = NULL;
    gsize size;
    if (!g_file_get_contents(path, &text, &size, NULL)) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(EXIT_FAILURE);
    }
    // A copy of exactly its size, so that a sanitizer sees each byte read too far.
    g_autofree uint8_t *data = g_malloc(size > 0 ? size : 1);
    for (gsize i = 0; i < size; i++)
        data[i] = (uint8_t)text[i];
    LLVMFuzzerTestOneInput(data, size);
    count++;
}

static void replay(const char *path)
{
    GDir *folder = g_dir_open(path, 0, NULL);
    const char *name;
    if (folder == NULL) {
        replay_file(path);
        return;
    }
    while ((name = g_dir_read_name(folder)) != NULL) {
        g_autofree char *file = g_build_filename(path, name, NULL);
        replay_file(file);
    }
    g_dir_close(folder);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        replay(argv[i]);
    printf("%u inputs\n", count);
    return count > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
