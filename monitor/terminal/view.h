// The feed as a full screen of text: which lines, and what the keys do. Pure: a size comes in,
// lines that fit it come out; screen.h paints them.
//
//     sobox monitor  udpm://239.255.76.67:7667?ttl=1
//     ! worker host7/42 is silent since 12 s: the batches it held (3) are handed out again
//
//       RUN                   STATE    SEARCHES  DESIGNS   RATE  WORKERS  ...
//     > sedan-two-springs     running    0 of 1   5.39 M  225 k        3
//
//     search 0: explore, step 103 of about 202  [##########----------]  12 s left
//     ln(volume)   ▁▁▂▆▇▇██████  -2.46        good  ▂▆▁▅▆▇██████  70 %
//
//       WORKER                THREADS  BUSY  RATE   QUEUE  ...
//       host7/41                    8  97 %  80 k       4
//     q quit  up/down run  left/right search  s sort: name  r reverse
#ifndef SOBOX_MONITOR_TERMINAL_VIEW_H
#define SOBOX_MONITOR_TERMINAL_VIEW_H

#include "monitor/feed/feed.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

enum view_style {
    VIEW_PLAIN,
    VIEW_TITLE,
    VIEW_HEAD,
    VIEW_CHOSEN,
    VIEW_FAINT,
    VIEW_PROBLEM,
};

enum { VIEW_TEXT_SIZE = 1024 }; // [bytes]

struct view_line {
    enum view_style style;
    char text[VIEW_TEXT_SIZE]; // UTF-8, at most as many columns as the screen has
};

enum view_sort { VIEW_SORT_NAME, VIEW_SORT_BUSY, VIEW_SORT_RATE, VIEW_SORT_LOST, VIEW_SORT_COUNT };

enum view_key {
    VIEW_KEY_UP,    // the run before
    VIEW_KEY_DOWN,  // the run after
    VIEW_KEY_LEFT,  // the search before
    VIEW_KEY_RIGHT, // the search after
    VIEW_KEY_PAGE_UP,
    VIEW_KEY_PAGE_DOWN, // of the workers
    VIEW_KEY_SORT,      // workers by the next column
    VIEW_KEY_REVERSE,
};

// What the user has chosen, and the screen. Zeroed but for width and height: the newest run, its
// latest search, workers by name.
struct view_state {
    unsigned width, height; // [columns], [lines]
    bool unicode;           // the terminal shows more than ASCII
    bool has_run, has_search;
    uint64_t run;
    uint32_t search;
    enum view_sort sort;
    bool reverse;
    unsigned scroll; // workers above the first that is shown
};

void view_press(struct view_state *state, const struct feed *feed, enum view_key key);

// Fills `lines` (of struct view_line) with at most `height` lines. `source` names what is watched.
void view_lines(struct view_state *state, const struct feed *feed, const char *source,
                int64_t now_ns, GArray *lines);

#endif
