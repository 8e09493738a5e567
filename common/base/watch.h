// A descriptor in the main loop, as g_unix_fd_add() has it, at a third of its cost.
//
// GLib takes a source out of the set it polls while it dispatches it, unless the source may
// recurse, and wakes its own loop for each change of that set: four system calls and an empty turn
// of the loop for every event. None of our handlers runs a loop of its own, so whether they might
// be called within themselves makes no difference to them.
#ifndef SOBOX_COMMON_BASE_WATCH_H
#define SOBOX_COMMON_BASE_WATCH_H

#include <glib-unix.h>
#include <glib.h>

// Calls `handler` whenever the descriptor is readable, until it returns G_SOURCE_REMOVE or
// g_source_remove() is given the number returned. The handler must not run a main loop.
guint watch_add(int descriptor, GUnixFDSourceFunc handler, gpointer user) G_GNUC_WARN_UNUSED_RESULT;

#endif
