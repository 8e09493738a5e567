// Entries that are heard of again and again, found by key at once however many there are. A full
// table forgets the entry unheard for longest, so a flood of invented names costs a bounded memory.
#ifndef SOBOX_MONITOR_FEED_TABLE_H
#define SOBOX_MONITOR_FEED_TABLE_H

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

// Opens every entry of a table.
struct table_entry {
    uint64_t key[2];
    GList link; // in the table's queue
};

// Read `entries` and `removed`, leave the rest alone.
struct table {
    GPtrArray *entries; // in the order in which they were first heard of
    uint64_t removed;   // entries that are gone: who keeps a copy of the table starts anew
    GHashTable *index;
    GQueue heard; // longest unheard first
    guint capacity;
    GDestroyNotify release;
};

// A table of at most `capacity` entries; `release` frees one.
void table_init(struct table *table, guint capacity, GDestroyNotify release);
void table_fini(struct table *table);

// The entry of that key, or NULL.
void *table_find(const struct table *table, uint64_t key, uint64_t more);

// Puts an entry of a key that is not in the table, and takes it over.
void table_add(struct table *table, struct table_entry *entry, uint64_t key, uint64_t more);

// The entry was heard of just now: it is the last to be forgotten.
void table_touch(struct table *table, struct table_entry *entry);

// Forgets an entry and releases it.
void table_remove(struct table *table, struct table_entry *entry);

#endif
