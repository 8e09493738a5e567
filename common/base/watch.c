#include "common/base/watch.h"

guint watch_add(int descriptor, GUnixFDSourceFunc handler, gpointer user)
{
    GSource *source = g_unix_fd_source_new(descriptor, G_IO_IN);
    g_source_set_callback(source, G_SOURCE_FUNC(handler), user, NULL);
    g_source_set_can_recurse(source, TRUE);
    const guint number = g_source_attach(source, NULL);
    g_source_unref(source);
    return number;
}
