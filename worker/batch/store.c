#include "worker/batch/store.h"

#include "common/sampling/box_text.h"
#include "common/scenario/scenario_read.h"

#include <assert.h>
#include <math.h>
#include <string.h>

// Digests are hashes: any part of one serves.
static guint digest_hash(gconstpointer key)
{
    guint hash;
    memcpy(&hash, ((const struct digest *)key)->bytes, sizeof hash);
    return hash;
}

static gboolean digest_same(gconstpointer a, gconstpointer b)
{
    return digest_equal(a, b);
}

static void item_free(gpointer data)
{
    struct item *item = data;
    text_clear(&item->text);
    if (item->model != NULL)
        model_free(item->model);
    scenario_fini(&item->scenario);
    box_fini(&item->box);
    moves_fini(&item->moves);
    g_free(item);
}

void store_init(struct store *store, uint32_t scenario_max, uint64_t scenario_size_max,
                uint32_t box_max)
{
    *store = (struct store){.item_max = {[ITEM_SCENARIO] = scenario_max, [ITEM_BOX] = box_max},
                            .scenario_size_max = scenario_size_max};
    for (int kind = 0; kind < ITEM_KIND_COUNT; kind++) {
        store->items[kind] = g_hash_table_new_full(digest_hash, digest_same, NULL, item_free);
        g_queue_init(&store->idle[kind]);
    }
    g_queue_init(&store->missing);
}

void store_fini(struct store *store)
{
    for (int kind = 0; kind < ITEM_KIND_COUNT; kind++)
        g_hash_table_unref(store->items[kind]);
    *store = (struct store){0};
}

static bool store_full(const struct store *store, enum item_kind kind)
{
    return g_hash_table_size(store->items[kind]) >= store->item_max[kind] ||
           (kind == ITEM_SCENARIO && store->scenario_size >= store->scenario_size_max);
}

// Whether there is room for one more item, after forgetting those unused for longest if need be.
static bool store_make_room(struct store *store, enum item_kind kind)
{
    while (store_full(store, kind)) {
        GList *link = g_queue_pop_head_link(&store->idle[kind]);
        if (link == NULL)
            return false;
        struct item *item = link->data;
        store->scenario_size -= item->scenario.text_size;
        g_hash_table_remove(store->items[kind], &item->digest);
    }
    return true;
}

static struct item *item_create(struct store *store, enum item_kind kind,
                                const struct digest *digest, uint64_t run, int64_t now_ns)
{
    if (!store_make_room(store, kind))
        return NULL;
    struct item *item = g_new0(struct item, 1);
    item->digest = *digest;
    item->kind = kind;
    item->run = run;
    item->ask_ns = now_ns;
    item->link.data = item;
    g_hash_table_insert(store->items[kind], &item->digest, item);
    g_queue_push_tail_link(&store->missing, &item->link);
    return item;
}

struct item *store_acquire(struct store *store, enum item_kind kind, const struct digest *digest,
                           uint64_t run, int64_t now_ns)
{
    struct item *item = g_hash_table_lookup(store->items[kind], digest);
    if (item == NULL)
        item = item_create(store, kind, digest, run, now_ns);
    else if (item->users == 0)
        g_queue_unlink(&store->idle[kind], &item->link);
    if (item != NULL)
        item->users++;
    return item;
}

static void item_drop_text(struct store *store, struct item *item)
{
    store->partial_size -= item->text.size;
    text_clear(&item->text);
}

void store_release(struct store *store, struct item *item)
{
    assert(item->users > 0);
    if (--item->users > 0)
        return;
    if (item->ready) {
        g_queue_push_tail_link(&store->idle[item->kind], &item->link);
        return;
    }
    item_drop_text(store, item);
    g_queue_unlink(&store->missing, &item->link);
    g_hash_table_remove(store->items[item->kind], &item->digest);
}

struct item *store_missing(struct store *store, enum item_kind kind, const struct digest *digest)
{
    struct item *item = g_hash_table_lookup(store->items[kind], digest);
    return item != NULL && !item->ready ? item : NULL;
}

static bool size_possible(const struct item *item, uint32_t total)
{
    if (item->kind == ITEM_SCENARIO)
        return total <= SCENARIO_TEXT_SIZE_MAX;
    return total <= PROTOCOL_TEXT_SIZE_MAX && box_text_size_ok(total, item->variables);
}

// Whether a text of `total` bytes fits, after dropping pieces of those needed later than it.
static bool store_make_room_for_text(struct store *store, struct item *item, uint32_t total)
{
    item_drop_text(store, item);
    for (GList *link = store->missing.tail; link != &item->link; link = link->prev) {
        if (store->partial_size + total <= STORE_PARTIAL_SIZE_MAX)
            break;
        item_drop_text(store, link->data);
    }
    return store->partial_size + total <= STORE_PARTIAL_SIZE_MAX;
}

enum text_progress store_piece(struct store *store, struct item *item, uint32_t total,
                               uint32_t offset, const uint8_t *piece, uint32_t size)
{
    assert(!item->ready);
    if (!size_possible(item, total))
        return TEXT_NOTHING;
    if (item->text.size != total) {
        if (!store_make_room_for_text(store, item, total))
            return TEXT_NOTHING;
        store->partial_size += total;
    }
    return text_piece(&item->text, total, offset, piece, size);
}

static void item_ready(struct store *store, struct item *item)
{
    item->ready = true;
    store->scenario_size += item->scenario.text_size;
    g_queue_unlink(&store->missing, &item->link);
}

static enum status finish_scenario(struct item *item, struct error *error)
{
    char hex[DIGEST_HEX_SIZE];
    enum status status =
        scenario_read_text(&item->scenario, digest_hex(&item->digest, hex),
                           (const char *)item->text.bytes, item->text.size, NULL, 0, error);
    if (status == STATUS_OK)
        item->model = model_create(&item->scenario);
    return status;
}

static enum status finish_box(struct item *item, const uint8_t *text, uint32_t size,
                              struct error *error)
{
    const char *wrong = box_text_get(text, size, item->variables, &item->box, &item->moves);
    if (wrong != NULL)
        return error_set(error, STATUS_INVALID, "%s", wrong);
    return STATUS_OK;
}

enum status store_finish(struct store *store, struct item *item, struct error *error)
{
    assert(!item->ready);
    enum status status;
    struct digest digest = digest_of(item->text.bytes, item->text.size);
    if (!digest_equal(&digest, &item->digest))
        status = error_set(error, STATUS_INVALID, "what arrived is not what was promised");
    else if (item->kind == ITEM_SCENARIO)
        status = finish_scenario(item, error);
    else
        status = finish_box(item, item->text.bytes, item->text.size, error);
    item_drop_text(store, item);
    if (status == STATUS_OK)
        item_ready(store, item);
    return status;
}

enum status store_finish_box(struct store *store, struct item *item, const uint8_t *text,
                             uint32_t size, struct error *error)
{
    assert(!item->ready && item->kind == ITEM_BOX);
    const struct digest digest = digest_of(text, size);
    if (!digest_equal(&digest, &item->digest))
        return error_set(error, STATUS_INVALID, "its text is not that of the box it names");
    enum status status = finish_box(item, text, size, error);
    if (status == STATUS_OK) {
        item_drop_text(store, item);
        item_ready(store, item);
    }
    return status;
}
