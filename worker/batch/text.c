#include "worker/batch/text.h"

#include <assert.h>
#include <glib.h>
#include <stdbool.h>
#include <string.h>

void text_clear(struct text *text)
{
    g_free(text->bytes);
    g_free(text->parts);
    *text = (struct text){0};
}

static void text_start(struct text *text, uint32_t total)
{
    text_clear(text);
    text->bytes = g_malloc0(total);
    text->size = total;
    text->parts = g_new(struct text_part, TEXT_PART_MAX);
}

// Adds a part and melts it with those it touches. Returns false when it brings nothing new or when
// there is no room for another part.
static bool part_add(struct text *text, struct text_part part)
{
    uint32_t first = 0; // the first part that touches or follows the new one
    while (first < text->part_count && text->parts[first].end < part.begin)
        first++;
    uint32_t after = first; // the first part that lies wholly behind it
    while (after < text->part_count && text->parts[after].begin <= part.end)
        after++;
    if (after > first) {
        const struct text_part *low = &text->parts[first], *high = &text->parts[after - 1];
        if (low->begin <= part.begin && part.end <= low->end)
            return false;
        part.begin = MIN(part.begin, low->begin);
        part.end = MAX(part.end, high->end);
    } else if (text->part_count == TEXT_PART_MAX) {
        return false;
    }
    memmove(&text->parts[first + 1], &text->parts[after],
            (text->part_count - after) * sizeof *text->parts);
    text->parts[first] = part;
    text->part_count = text->part_count - (after - first) + 1;
    return true;
}

enum text_progress text_piece(struct text *text, uint32_t total, uint32_t offset,
                              const uint8_t *piece, uint32_t size)
{
    assert(size > 0);
    assert(offset <= total && size <= total - offset);
    if (text->size != total)
        text_start(text, total);
    if (!part_add(text, (struct text_part){offset, offset + size}))
        return TEXT_NOTHING;
    memcpy(text->bytes + offset, piece, size);
    if (text_missing(text) == total)
        return TEXT_WHOLE;
    return offset + size == total ? TEXT_GAP : TEXT_MORE;
}

uint32_t text_missing(const struct text *text)
{
    return text->part_count > 0 && text->parts[0].begin == 0 ? text->parts[0].end : 0;
}
