#include "monitor/feed/table.h"

static guint key_hash(gconstpointer key)
{
    const uint64_t *part = key;
    // Multipliers that are odd and without a pattern spread counted keys over all bits.
    const uint64_t mixed =
        part[0] * UINT64_C(0x9e3779b97f4a7c15) ^ (part[1] + 1) * UINT64_C(0xd6e8feb86659fd93);
    return (guint)(mixed >> 32);
}

static gboolean key_equal(gconstpointer a, gconstpointer b)
{
    const uint64_t *left = a, *right = b;
    return left[0] == right[0] && left[1] == right[1];
}

void table_init(struct table *table, guint capacity, GDestroyNotify release)
{
    *table = (struct table){
        .entries = g_ptr_array_new_with_free_func(release),
        .index = g_hash_table_new(key_hash, key_equal),
        .heard = G_QUEUE_INIT,
        .capacity = capacity,
        .release = release,
    };
}

void table_fini(struct table *table)
{
    if (table->entries == NULL)
        return;
    g_hash_table_destroy(table->index);
    g_ptr_array_free(table->entries, TRUE);
    *table = (struct table){0};
}

void *table_find(const struct table *table, uint64_t key, uint64_t more)
{
    const uint64_t both[2] = {key, more};
    return g_hash_table_lookup(table->index, both); // the key opens the entry: it is its address
}

void table_add(struct table *table, struct table_entry *entry, uint64_t key, uint64_t more)
{
    if (table->entries->len == table->capacity)
        table_remove(table, table->heard.head->data);
    entry->key[0] = key;
    entry->key[1] = more;
    entry->link = (GList){.data = entry};
    g_ptr_array_add(table->entries, entry);
    g_hash_table_add(table->index, entry->key);
    g_queue_push_tail_link(&table->heard, &entry->link);
}

void table_touch(struct table *table, struct table_entry *entry)
{
    g_queue_unlink(&table->heard, &entry->link);
    g_queue_push_tail_link(&table->heard, &entry->link);
}

void table_remove(struct table *table, struct table_entry *entry)
{
    g_hash_table_remove(table->index, entry->key);
    g_queue_unlink(&table->heard, &entry->link);
    g_ptr_array_remove(table->entries, entry);
    table->removed++;
}
