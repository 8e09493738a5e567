#include "common/wire/sequence.h"

#include <glib.h>

// What was heard of one kind from one sender: bit i of `window` is number `greatest - i`.
struct track {
    uint64_t window; // 0: nothing heard yet
    uint32_t greatest;
};

struct sender {
    uint64_t number;
    GList link; // in `order`; its data is this sender
    struct track tracks[WIRE_KIND_COUNT];
};

struct sequence {
    GHashTable *senders; // number -> struct sender, owned
    GQueue order;        // the senders, last heard first
    uint64_t lost;
};

struct sequence *sequence_create(void)
{
    struct sequence *sequence = g_new0(struct sequence, 1);
    sequence->senders = g_hash_table_new_full(g_int64_hash, g_int64_equal, NULL, g_free);
    g_queue_init(&sequence->order);
    return sequence;
}

void sequence_free(struct sequence *sequence)
{
    if (sequence == NULL)
        return;
    g_hash_table_destroy(sequence->senders); // the links of `order` live inside
    g_free(sequence);
}

static void forget_oldest(struct sequence *sequence)
{
    struct sender *oldest = g_queue_peek_tail(&sequence->order);
    g_queue_unlink(&sequence->order, &oldest->link);
    g_hash_table_remove(sequence->senders, &oldest->number);
}

// The sender's entry, made when it is new, now the last heard.
static struct sender *sender_of(struct sequence *sequence, uint64_t number)
{
    struct sender *sender = g_hash_table_lookup(sequence->senders, &number);
    if (sender != NULL) {
        g_queue_unlink(&sequence->order, &sender->link);
    } else {
        if (g_hash_table_size(sequence->senders) >= SEQUENCE_SENDERS_MAX)
            forget_oldest(sequence);
        sender = g_new0(struct sender, 1);
        sender->number = number;
        sender->link.data = sender;
        g_hash_table_insert(sequence->senders, &sender->number, sender);
    }
    g_queue_push_head_link(&sequence->order, &sender->link);
    return sender;
}

void sequence_hear(struct sequence *sequence, uint64_t sender, enum wire_kind kind, uint32_t number)
{
    struct track *track = &sender_of(sequence, sender)->tracks[kind];
    uint32_t ahead = number - track->greatest; // wraps as the numbers do
    uint32_t behind = track->greatest - number;
    if (track->window != 0 && behind < SEQUENCE_WINDOW) {
        uint64_t bit = UINT64_C(1) << behind;
        // Bits of numbers before the first one heard are set, so they take nothing back.
        if ((track->window & bit) == 0 && sequence->lost > 0)
            sequence->lost--;
        track->window |= bit;
    } else if (track->window != 0 && ahead <= SEQUENCE_LEAP_MAX) {
        sequence->lost += ahead - 1;
        track->window = ahead < SEQUENCE_WINDOW ? track->window << ahead | 1 : 1;
        track->greatest = number;
    } else if (track->window == 0 || behind > SEQUENCE_LEAP_MAX) {
        track->window = UINT64_MAX;
        track->greatest = number;
    }
    // Else it is older than the window: its loss, if it was one, stays counted.
}

uint64_t sequence_lost(const struct sequence *sequence)
{
    return sequence->lost;
}

size_t sequence_senders(const struct sequence *sequence)
{
    return g_hash_table_size(sequence->senders);
}
