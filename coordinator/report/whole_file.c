#include "coordinator/report/whole_file.h"

#include <glib.h>

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
