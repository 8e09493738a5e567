// A course of values that stays bounded however long it grows: when it is full every second point
// goes, and from then on only every second, fourth, ... point is kept. So it always spans the whole
// course, evenly, and ends with the newest point.
#ifndef SOBOX_MONITOR_FEED_HISTORY_H
#define SOBOX_MONITOR_FEED_HISTORY_H

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

struct history {
    GArray *points;    // read-only
    uint32_t rewrites; // how often points that were there changed or went
    uint32_t stride;   // of so many added points one stays
    uint64_t added;    // points so far
    guint capacity;
};

// A course of at most `capacity` (even) points of `size` bytes.
void history_init(struct history *history, guint size, guint capacity);
void history_fini(struct history *history);

// Adds a copy of the point at the end.
void history_add(struct history *history, const void *point);

// Puts a copy of the point in place of the last one.
void history_replace(struct history *history, const void *point);

// Takes the last `count` points away.
void history_cut(struct history *history, guint count);

#endif
