#include "worker/batch/turns.h"

// A coordinator for whom something waits.
struct client {
    uint64_t coordinator;
    GQueue waiting; // never empty but in passing
    GList link;     // in the order
};

void turns_init(struct turns *turns)
{
    turns->clients = g_hash_table_new_full(g_int64_hash, g_int64_equal, NULL, g_free);
    g_queue_init(&turns->order);
}

void turns_fini(struct turns *turns)
{
    g_hash_table_destroy(turns->clients);
    *turns = (struct turns){0};
}

static struct client *client_of(struct turns *turns, uint64_t coordinator)
{
    struct client *client = g_hash_table_lookup(turns->clients, &coordinator);
    if (client != NULL)
        return client;
    client = g_new0(struct client, 1);
    client->coordinator = coordinator;
    client->link.data = client;
    g_queue_init(&client->waiting);
    g_hash_table_insert(turns->clients, &client->coordinator, client);
    g_queue_push_tail_link(&turns->order, &client->link);
    return client;
}

void turns_add(struct turns *turns, struct turn *turn)
{
    GQueue *waiting = &client_of(turns, turn->coordinator)->waiting;
    GList *before = waiting->tail; // most often it is the last
    while (before != NULL && ((const struct turn *)before->data)->arrival > turn->arrival)
        before = before->prev;
    turn->link = (GList){.data = turn};
    if (before == NULL)
        g_queue_push_head_link(waiting, &turn->link);
    else
        g_queue_insert_after_link(waiting, before, &turn->link);
}

struct turn *turns_take(struct turns *turns)
{
    GList *first = g_queue_pop_head_link(&turns->order);
    if (first == NULL)
        return NULL;
    struct client *client = first->data;
    struct turn *turn = g_queue_pop_head_link(&client->waiting)->data;
    if (g_queue_is_empty(&client->waiting))
        g_hash_table_remove(turns->clients, &client->coordinator);
    else
        g_queue_push_tail_link(&turns->order, &client->link);
    return turn;
}
