// A binary heap whose entries live inside the things they order: what is due next, who has least to
// do. Nothing is allocated but the heap's own array, and an entry knows its place, so that it is
// moved and removed in O(log n) without a search.
#ifndef SOBOX_COORDINATOR_SCHEDULE_HEAP_H
#define SOBOX_COORDINATOR_SCHEDULE_HEAP_H

#include <stddef.h>
#include <stdint.h>

struct heap_entry {
    int64_t key;
    uint64_t tie;    // orders equal keys; set by the owner before the first heap_put()
    size_t position; // 1 is the root; 0: in no heap
};

struct heap {
    struct heap_entry **entries; // (capacity + 1) from position 1 on
    size_t count;
    size_t capacity;
};

// Puts `entry` in under `key`, or moves it there when it is in already.
void heap_put(struct heap *heap, struct heap_entry *entry, int64_t key);

// Takes `entry` out; nothing happens when it is in no heap.
void heap_remove(struct heap *heap, struct heap_entry *entry);

// The entry with the least key, or NULL.
struct heap_entry *heap_first(const struct heap *heap);

// The entry that would be first without the first one, or NULL.
struct heap_entry *heap_second(const struct heap *heap);

// Releases the heap's array. A zeroed struct is an empty heap.
void heap_fini(struct heap *heap);

#endif
