#include "hub/relay/queue.h"

#include <assert.h>

void queue_init(struct queue *queue, size_t size_max)
{
    *queue = (struct queue){.parcels = G_QUEUE_INIT, .size_max = size_max};
}

void queue_fini(struct queue *queue)
{
    struct parcel *parcel;
    while ((parcel = g_queue_pop_head(&queue->parcels)) != NULL)
        parcel_release(parcel);
    queue_init(queue, queue->size_max);
}

bool queue_push(struct queue *queue, struct parcel *parcel)
{
    if (queue->size > 0 && queue->size + parcel->size > queue->size_max)
        return false;
    parcel->holders++;
    queue->size += parcel->size;
    g_queue_push_tail(&queue->parcels, parcel);
    return true;
}

size_t queue_peek(struct queue *queue, struct iovec *pieces, size_t max)
{
    size_t count = 0, written = queue->written;
    for (GList *item = queue->parcels.head; item != NULL && count < max; item = item->next) {
        struct parcel *parcel = item->data;
        pieces[count++] = (struct iovec){parcel->bytes + written, parcel->size - written};
        written = 0;
    }
    return count;
}

void queue_pop(struct queue *queue, size_t size)
{
    assert(size <= queue->size - queue->written);
    queue->written += size;
    for (;;) {
        struct parcel *first = g_queue_peek_head(&queue->parcels);
        if (first == NULL || queue->written < first->size)
            return;
        queue->written -= first->size;
        queue->size -= first->size;
        g_queue_pop_head(&queue->parcels);
        parcel_release(first);
    }
}
