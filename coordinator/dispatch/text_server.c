#include "coordinator/dispatch/text_server.h"

#include <glib.h>
#include <string.h>

struct text {
    struct digest digest; // the key
    uint8_t *bytes;       // (size) owned
    size_t size;
    uint32_t offers;    // text_server_offer() calls not yet taken back
    size_t sent_offset; // where the last sending began
    int64_t sent_ns;    // when; INT64_MIN before the first
};

struct text_server {
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

static void text_free(gpointer data)
{
    struct text *text = data;
    g_free(text->bytes);
    g_free(text);
}

struct text_server *text_server_create(void)
{
    struct text_server *server = g_new(struct text_server, 1);
    server->table = g_hash_table_new_full(key_hash, key_equal, NULL, text_free);
    return server;
}

void text_server_free(struct text_server *server)
{
    if (server == NULL)
        return;
    g_hash_table_destroy(server->table);
    g_free(server);
}

void text_server_offer(struct text_server *server, const struct digest *digest, const void *bytes,
                       size_t size)
{
    struct text *text = g_hash_table_lookup(server->table, digest);
    if (text == NULL) {
        text = g_new(struct text, 1);
        *text = (struct text){
            .digest = *digest, .bytes = g_memdup2(bytes, size), .size = size, .sent_ns = INT64_MIN};
        g_hash_table_insert(server->table, &text->digest, text);
    }
    text->offers++;
}

void text_server_withdraw(struct text_server *server, const struct digest *digest)
{
    struct text *text = g_hash_table_lookup(server->table, digest);
    if (text != NULL && --text->offers == 0)
        g_hash_table_remove(server->table, digest);
}

const uint8_t *text_server_ask(struct text_server *server, const struct digest *digest,
                               size_t offset, int64_t now_ns, size_t *size)
{
    struct text *text = g_hash_table_lookup(server->table, digest);
    if (text == NULL || offset >= text->size)
        return NULL;
    const int64_t repeat_ns = (int64_t)text->size * TEXT_SERVER_BYTE_NS;
    const bool sent_before = text->sent_ns != INT64_MIN;
    if (sent_before && text->sent_offset == offset && now_ns - text->sent_ns < repeat_ns)
        return NULL;
    text->sent_offset = offset;
    text->sent_ns = now_ns;
    *size = text->size;
    return text->bytes;
}
