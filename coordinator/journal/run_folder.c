#include "coordinator/journal/run_folder.h"

#include <errno.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <unistd.h>

enum { FOLDER_TRIES = 100000 }; // runs/NAME-2 .. runs/NAME-100000

static bool folder_empty(const char *path)
{
    GDir *dir = g_dir_open(path, 0, NULL);
    if (dir == NULL)
        return false;
    bool empty = g_dir_read_name(dir) == NULL;
    g_dir_close(dir);
    return empty;
}

// The first of runs/NAME, runs/NAME-2, ... that does not exist.
static char *folder_pick(const char *name)
{
    char *path = g_build_filename("runs", name, NULL);
    for (int number = 2; number < FOLDER_TRIES && g_file_test(path, G_FILE_TEST_EXISTS); number++) {
        g_free(path);
        path = g_strdup_printf("runs/%s-%d", name, number);
    }
    return path;
}

static enum status folder_make(const char *path, struct error *error)
{
    if (g_mkdir_with_parents(path, 0777) != 0)
        return error_set(error, STATUS_INVALID, "%s: cannot make the run folder: %s", path,
                         g_strerror(errno));
    if (!folder_empty(path))
        return error_set(error, STATUS_INVALID,
                         "%s: the run folder is not empty: name another with --out, or continue "
                         "the run in it with --resume",
                         path);
    if (access(path, W_OK | X_OK) != 0)
        return error_set(error, STATUS_INVALID, "%s: cannot write into the run folder: %s", path,
                         g_strerror(errno));
    return STATUS_OK;
}

enum status run_folder_make(const char *path, const char *name, char **folder, bool *made,
                            struct error *error)
{
    *folder = path != NULL ? g_strdup(path) : folder_pick(name);
    *made = !g_file_test(*folder, G_FILE_TEST_IS_DIR);
    enum status status = folder_make(*folder, error);
    if (status != STATUS_OK) {
        g_free(*folder);
        *folder = NULL;
    }
    return status;
}

void run_folder_remove(const char *folder)
{
    g_rmdir(folder);
    // The folder of picked folders too, when it was made for this run: it goes only if it is empty.
    if (g_str_has_prefix(folder, "runs/"))
        g_rmdir("runs");
}
