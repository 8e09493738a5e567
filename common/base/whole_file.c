#include "common/base/whole_file.h"

#include <errno.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <stdbool.h>
#include <stdlib.h>
#include <unistd.h>

// ---- Reading ----

char *whole_file_read(const char *path, size_t size_max, size_t *size, struct error *error)
{
    enum { PIECE_SIZE = 1 << 16 };
    FILE *file = fopen(path, "rb");
    int reason = errno;
    char *text = NULL;
    size_t added = 1;
    *size = 0;
    while (file != NULL && added > 0 && *size <= size_max) {
        const size_t room = MIN(size_max + 1 - *size, (size_t)PIECE_SIZE);
        text = g_realloc(text, *size + room);
        added = fread(text + *size, 1, room, file);
        *size += added;
    }
    const bool failed = file == NULL || ferror(file) != 0;
    if (file != NULL) {
        reason = errno;
        fclose(file);
    }
    if (failed) {
        error_set(error, STATUS_INVALID, "%s:1:1: expected a file that can be read: %s", path,
                  g_strerror(reason));
        g_free(text);
        return NULL;
    }
    return text;
}

// ---- Writing ----

static enum status failure(const char *path, int reason, struct error *error)
{
    return error_set(error, STATUS_IO, "%s: cannot be written: %s", path, g_strerror(reason));
}

static void release(struct whole_file *whole)
{
    g_free(whole->path);
    g_free(whole->beside);
    *whole = (struct whole_file){0};
}

// The path behind symbolic links, where there is something.
static char *resolved(const char *path)
{
    char *found = realpath(path, NULL);
    char *kept = g_strdup(found != NULL ? found : path);
    free(found);
    return kept;
}

enum status whole_file_begin(struct whole_file *whole, const char *path, struct error *error)
{
    GStatBuf there;
    const bool replace = g_stat(path, &there) != 0 || S_ISREG(there.st_mode);
    *whole = (struct whole_file){.path = replace ? resolved(path) : g_strdup(path)};
    if (replace)
        whole->beside = g_strdup_printf("%s.part-%d", whole->path, (int)getpid());
    whole->file = fopen(replace ? whole->beside : path, "w");
    if (whole->file != NULL)
        return STATUS_OK;
    enum status status = failure(path, errno, error);
    release(whole);
    return status;
}

enum status whole_file_end(struct whole_file *whole, enum status status, struct error *error)
{
    if (whole->file == NULL)
        return status;
    errno = 0;
    bool written = fflush(whole->file) == 0 && !ferror(whole->file);
    int reason = errno != 0 ? errno : EIO;
    if (fclose(whole->file) != 0 && written) {
        reason = errno;
        written = false;
    }
    if (written && status == STATUS_OK && whole->beside != NULL &&
        g_rename(whole->beside, whole->path) != 0) {
        reason = errno;
        written = false;
    }
    if (!written && status == STATUS_OK)
        status = failure(whole->path, reason, error);
    if (status != STATUS_OK && whole->beside != NULL)
        g_unlink(whole->beside);
    release(whole);
    return status;
}

enum status whole_file_write(const char *path, const void *bytes, size_t size, struct error *error)
{
    struct whole_file whole;
    enum status status = whole_file_begin(&whole, path, error);
    if (status != STATUS_OK)
        return status;
    if (fwrite(bytes, 1, size, whole.file) != size)
        status = failure(path, errno, error);
    return whole_file_end(&whole, status, error);
}
