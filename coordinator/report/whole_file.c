#include "coordinator/report/whole_file.h"

#include <errno.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <stdbool.h>
#include <unistd.h>

enum status whole_file_write(const char *path, const void *bytes, size_t size, struct error *error)
{
    GError *failure = NULL;
    if (g_file_set_contents_full(path, bytes, (gssize)size, G_FILE_SET_CONTENTS_CONSISTENT, 0666,
                                 &failure))
        return STATUS_OK;
    // GLib's sentence names the file.
    error_set(error, STATUS_IO, "%s", failure->message);
    g_error_free(failure);
    return STATUS_IO;
}

static enum status failure(const char *path, int reason, struct error *error)
{
    return error_set(error, STATUS_IO, "%s: cannot be written: %s", path, g_strerror(reason));
}

enum status whole_file_begin(struct whole_file *whole, const char *path, struct error *error)
{
    *whole = (struct whole_file){.path = g_strdup(path),
                                 .beside = g_strdup_printf("%s.part-%d", path, (int)getpid())};
    whole->file = fopen(whole->beside, "w");
    if (whole->file != NULL)
        return STATUS_OK;
    enum status status = failure(path, errno, error);
    g_free(whole->path);
    g_free(whole->beside);
    *whole = (struct whole_file){0};
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
    if (written && status == STATUS_OK && g_rename(whole->beside, whole->path) != 0) {
        reason = errno;
        written = false;
    }
    if (!written && status == STATUS_OK)
        status = failure(whole->path, reason, error);
    if (status != STATUS_OK)
        g_unlink(whole->beside);
    g_free(whole->path);
    g_free(whole->beside);
    *whole = (struct whole_file){0};
    return status;
}
