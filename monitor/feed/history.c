#include "monitor/feed/history.h"

#include <string.h>

void history_init(struct history *history, guint size, guint capacity)
{
    *history = (struct history){
        .points = g_array_new(FALSE, FALSE, size),
        .stride = 1,
        .capacity = capacity,
    };
}

void history_fini(struct history *history)
{
    if (history->points != NULL)
        g_array_free(history->points, TRUE);
    *history = (struct history){0};
}

static char *place(struct history *history, guint index)
{
    return history->points->data + (size_t)index * g_array_get_element_size(history->points);
}

static void thin_out(struct history *history)
{
    const guint size = g_array_get_element_size(history->points);
    const guint kept = history->points->len / 2;
    for (guint i = 1; i < kept; i++)
        memcpy(place(history, i), place(history, 2 * i), size);
    g_array_set_size(history->points, kept);
    history->stride *= 2;
    history->rewrites++;
}

void history_add(struct history *history, const void *point)
{
    // The newest point stands at the end even when it will not stay: the next one replaces it.
    const bool last_stays = history->added == 0 || (history->added - 1) % history->stride == 0;
    if (last_stays) {
        if (history->points->len == history->capacity)
            thin_out(history);
        g_array_append_vals(history->points, point, 1);
    } else {
        history_replace(history, point);
    }
    history->added++;
}

void history_replace(struct history *history, const void *point)
{
    memcpy(place(history, history->points->len - 1), point,
           g_array_get_element_size(history->points));
}

void history_cut(struct history *history, guint count)
{
    if (count == 0)
        return;
    g_array_set_size(history->points, history->points->len - MIN(count, history->points->len));
    const uint64_t left = history->points->len;
    history->added = left > 0 ? (left - 1) * history->stride + 1 : 0;
    history->rewrites++;
}
