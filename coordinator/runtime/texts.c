#include "coordinator/runtime/texts.h"

#include <glib.h>
#include <string.h>

struct text {
    struct digest digest; // the key
    const uint8_t *bytes;
    size_t size;
    uint32_t offers;    // texts_add() calls not yet taken back
    size_t sent_offset; // where the last sending began
    int64_t sent_ns;    // when; INT64_MIN before the first
};

struct texts {
    GHashTable *table; // struct digest * -> struct text *
};

static guint key_hash(gconstpointer key)
{
    guint hash; // a digest is random bits already
    memcpy(&hash, ((const struct digest *)key)->bytes, sizeof hash);
    return hash;
}

static gboolean key_equal(gconstpointer a, gconstpointer b)
{
    return digest_equal(a, b);
}

struct texts *texts_create(void)
{
    struct texts *texts = g_new(struct texts, 1);
    texts->table = g_hash_table_new_full(key_hash, key_equal, NULL, g_free);
    return texts;
}

void texts_free(struct texts *texts)
{
    if (texts == NULL)
        return;
    g_hash_table_destroy(texts->table);
    g_free(texts);
}

void texts_add(struct texts *texts, const struct digest *digest, const void *bytes, size_t size)
{
    struct text *text = g_hash_table_lookup(texts->table, digest);
    if (text == NULL) {
        text = g_new(struct text, 1);
        *text = (struct text){.digest = *digest, .sent_ns = INT64_MIN};
        g_hash_table_insert(texts->table, &text->digest, text);
    }
    text->bytes = bytes;
    text->size = size;
    text->offers++;
}

void texts_remove(struct texts *texts, const struct digest *digest)
{
    struct text *text = g_hash_table_lookup(texts->table, digest);
    if (text != NULL && --text->offers == 0)
        g_hash_table_remove(texts->table, digest);
}

const uint8_t *texts_ask(struct texts *texts, const struct digest *digest, size_t offset,
                         int64_t now_ns, int64_t repeat_ns, size_t *size)
{
    struct text *text = g_hash_table_lookup(texts->table, digest);
    if (text == NULL || offset >= text->size)
        return NULL;
    const bool sent_before = text->sent_ns != INT64_MIN;
    if (sent_before && text->sent_offset == offset && now_ns - text->sent_ns < repeat_ns)
        return NULL;
    text->sent_offset = offset;
    text->sent_ns = now_ns;
    *size = text->size;
    return text->bytes;
}
