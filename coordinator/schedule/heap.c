#include "coordinator/schedule/heap.h"

#include <glib.h>
#include <stdbool.h>

static bool entry_before(const struct heap_entry *a, const struct heap_entry *b)
{
    return a->key != b->key ? a->key < b->key : a->tie < b->tie;
}

static void heap_place(struct heap *heap, struct heap_entry *entry, size_t position)
{
    heap->entries[position] = entry;
    entry->position = position;
}

static void heap_rise(struct heap *heap, struct heap_entry *entry)
{
    size_t position = entry->position;
    while (position > 1 && entry_before(entry, heap->entries[position / 2])) {
        heap_place(heap, heap->entries[position / 2], position);
        position /= 2;
    }
    heap_place(heap, entry, position);
}

static void heap_sink(struct heap *heap, struct heap_entry *entry)
{
    size_t position = entry->position;
    for (;;) {
        size_t child = 2 * position;
        if (child > heap->count)
            break;
        if (child < heap->count && entry_before(heap->entries[child + 1], heap->entries[child]))
            child++;
        if (!entry_before(heap->entries[child], entry))
            break;
        heap_place(heap, heap->entries[child], position);
        position = child;
    }
    heap_place(heap, entry, position);
}

void heap_put(struct heap *heap, struct heap_entry *entry, int64_t key)
{
    entry->key = key;
    if (entry->position == 0) {
        if (heap->count == heap->capacity) {
            heap->capacity = heap->capacity == 0 ? 64 : 2 * heap->capacity;
            heap->entries = g_renew(struct heap_entry *, heap->entries, heap->capacity + 1);
        }
        heap_place(heap, entry, ++heap->count);
    }
    heap_rise(heap, entry);
    heap_sink(heap, entry);
}

void heap_remove(struct heap *heap, struct heap_entry *entry)
{
    if (entry->position == 0)
        return;
    struct heap_entry *last = heap->entries[heap->count--];
    if (last != entry) {
        heap_place(heap, last, entry->position);
        heap_rise(heap, last);
        heap_sink(heap, last);
    }
    entry->position = 0;
}

struct heap_entry *heap_first(const struct heap *heap)
{
    return heap->count > 0 ? heap->entries[1] : NULL;
}

struct heap_entry *heap_second(const struct heap *heap)
{
    if (heap->count < 2)
        return NULL;
    if (heap->count == 2 || entry_before(heap->entries[2], heap->entries[3]))
        return heap->entries[2];
    return heap->entries[3];
}

void heap_fini(struct heap *heap)
{
    g_free(heap->entries);
    *heap = (struct heap){0};
}
