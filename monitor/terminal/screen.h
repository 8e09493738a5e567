// A full screen on a terminal (ncurses), painted from view.h: keys, resizing, and the terminal as
// it was at the end.
#ifndef SOBOX_MONITOR_TERMINAL_SCREEN_H
#define SOBOX_MONITOR_TERMINAL_SCREEN_H

#include "monitor/feed/feed.h"

#include <glib.h>
#include <stdbool.h>

struct screen;

// Takes over the terminal at standard input and output; NULL when there is none, or one that cannot
// place a cursor: then lines have to do. Attaches to the default main context; `quit` is called
// when the user wants to end. `feed` and `source` are borrowed until screen_stop().
struct screen *screen_start(const struct feed *feed, const char *source, GSourceFunc quit,
                            gpointer user);

// Gives the terminal back. NULL is fine.
void screen_stop(struct screen *screen);

#endif
