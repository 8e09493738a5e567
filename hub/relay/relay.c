#include "hub/relay/relay.h"

#include "common/wire/check.h"
#include "common/wire/frame.h"
#include "common/wire/seal.h"
#include "hub/relay/parcel.h"
#include "hub/relay/pattern.h"
#include "hub/relay/queue.h"

#include <glib.h>
#include <string.h>

struct relay_client {
    char name[RELAY_NAME_SIZE];
    void *user;
    int64_t joined_ns;
    int64_t cut_ns;      // since when a frame is incomplete; INT64_MAX: none is
    bool greeted;        // has said hello
    bool proven;         // has sent a message with the right seal
    bool to_write;       // stands in the relay's list
    uint64_t skip;       // [bytes] of a message too large that are still to come
    uint64_t lost;       // messages since last asked
    GByteArray *pending; // the beginning of a frame
    GPtrArray *patterns; // of struct pattern
    struct queue queue;
};

struct relay {
    struct relay_settings settings;
    struct relay_counters counters;
    size_t held;        // [bytes] in the queues of all
    size_t pending;     // [bytes] of frames that are not whole
    GPtrArray *clients; // in the order in which they came
    GQueue to_write;    // clients
    GHashTable *routes; // channel -> GPtrArray of clients; forgotten when anything changes
    uint8_t *opened;    // message_max bytes; what is in a seal
};

struct relay_settings relay_settings_default(void)
{
    return (struct relay_settings){
        .clients_max = 1024,
        .message_max = 1 << 20,
        .queue_max = 4 << 20,
        .memory_max = 256 << 20,
    };
}

struct relay *relay_create(const struct relay_settings *settings)
{
    struct relay *relay = g_new0(struct relay, 1);
    relay->settings = *settings;
    relay->clients = g_ptr_array_new();
    relay->routes =
        g_hash_table_new_full(g_str_hash, g_str_equal, g_free, (GDestroyNotify)g_ptr_array_unref);
    relay->opened = g_malloc(settings->message_max);
    g_queue_init(&relay->to_write);
    return relay;
}

void relay_free(struct relay *relay)
{
    if (relay == NULL)
        return;
    while (relay->clients->len > 0)
        relay_leave(relay, relay->clients->pdata[relay->clients->len - 1]);
    g_ptr_array_unref(relay->clients);
    g_hash_table_unref(relay->routes);
    g_free(relay->opened);
    g_free(relay);
}

// ---- Coming and going ----

struct relay_client *relay_join(struct relay *relay, const char *name, void *user, int64_t now_ns)
{
    if (relay->clients->len >= relay->settings.clients_max)
        return NULL;
    struct relay_client *client = g_new0(struct relay_client, 1);
    g_strlcpy(client->name, name, sizeof client->name);
    client->user = user;
    client->joined_ns = now_ns;
    client->cut_ns = INT64_MAX;
    client->pending = g_byte_array_new();
    client->patterns = g_ptr_array_new_with_free_func((GDestroyNotify)pattern_free);
    queue_init(&client->queue, relay->settings.queue_max);
    g_ptr_array_add(relay->clients, client);
    relay->counters.joined++;
    return client;
}

void relay_leave(struct relay *relay, struct relay_client *client)
{
    g_ptr_array_remove(relay->clients, client); // keeps the order of the others
    g_queue_remove(&relay->to_write, client);
    if (client->patterns->len > 0)
        g_hash_table_remove_all(relay->routes);
    relay->pending -= client->pending->len;
    queue_fini(&client->queue);
    g_byte_array_unref(client->pending);
    g_ptr_array_unref(client->patterns);
    g_free(client);
}

struct relay_client *relay_victim(struct relay *relay, int64_t now_ns)
{
    struct relay_client *unproven = NULL;
    for (guint i = 0; i < relay->clients->len; i++) {
        struct relay_client *client = relay->clients->pdata[i];
        if (!client->greeted)
            return client;
        bool had_time = now_ns - client->joined_ns >= RELAY_HELLO_NS;
        if (relay->settings.key != NULL && !client->proven && had_time && unproven == NULL)
            unproven = client;
    }
    return unproven;
}

struct relay_client *relay_overdue(struct relay *relay, int64_t now_ns)
{
    for (guint i = 0; i < relay->clients->len; i++) {
        struct relay_client *client = relay->clients->pdata[i];
        if (!client->greeted && now_ns - client->joined_ns >= RELAY_HELLO_NS)
            return client;
        if (client->cut_ns != INT64_MAX && now_ns - client->cut_ns >= RELAY_FRAME_NS)
            return client;
    }
    return NULL;
}

// ---- Passing on ----

static void put(struct relay *relay, struct relay_client *client, struct parcel *parcel)
{
    // Where memory is short those who read at once are still served.
    bool short_of_memory = relay->held > relay->settings.memory_max && client->queue.size > 0;
    if (short_of_memory || !queue_push(&client->queue, parcel)) {
        client->lost++;
        relay->counters.lost++;
        return;
    }
    relay->counters.delivered++;
    if (!client->to_write)
        g_queue_push_tail(&relay->to_write, client);
    client->to_write = true;
}

static bool wants(const struct relay_client *client, const char *channel)
{
    for (guint i = 0; i < client->patterns->len; i++)
        if (pattern_matches(client->patterns->pdata[i], channel))
            return true;
    return false;
}

static const GPtrArray *route(struct relay *relay, const char *channel)
{
    GPtrArray *route = g_hash_table_lookup(relay->routes, channel);
    if (route != NULL)
        return route;
    if (g_hash_table_size(relay->routes) >= RELAY_ROUTES_MAX)
        g_hash_table_remove_all(relay->routes);
    route = g_ptr_array_new();
    for (guint i = 0; i < relay->clients->len; i++)
        if (wants(relay->clients->pdata[i], channel))
            g_ptr_array_add(route, relay->clients->pdata[i]);
    g_hash_table_insert(relay->routes, g_strdup(channel), route);
    return route;
}

// The key is checked here, at the door: what it does not open reaches nobody.
static bool admit(struct relay *relay, struct relay_client *client, const char *channel,
                  const struct frame *frame)
{
    struct seal_origin origin;
    if (relay->settings.key == NULL)
        return true;
    bool sealed = seal_is(frame->data, frame->data_size) && frame->data_size >= SEAL_SIZE &&
                  seal_open(relay->opened, frame->data, frame->data_size, channel,
                            relay->settings.key, &origin);
    client->proven |= sealed;
    relay->counters.refused += !sealed;
    return sealed;
}

static void publish(struct relay *relay, struct relay_client *client, const struct frame *frame)
{
    char channel[FRAME_CHANNEL_MAX + 1];
    memcpy(channel, frame->name, frame->name_size);
    channel[frame->name_size] = '\0';
    relay->counters.received++;
    if (!admit(relay, client, channel, frame))
        return;
    const GPtrArray *receivers = route(relay, channel);
    if (receivers->len == 0)
        return;
    // What a client writes to publish is what others are given to read.
    size_t head_size = frame->size - frame->data_size;
    struct parcel *parcel = parcel_create(frame->size, &relay->held);
    frame_head(parcel->bytes, FRAME_PUBLISH, channel, frame->name_size, frame->data_size);
    memcpy(parcel->bytes + head_size, frame->data, frame->data_size);
    for (guint i = 0; i < receivers->len; i++)
        put(relay, receivers->pdata[i], parcel);
    parcel_release(parcel);
}

static bool subscribe(struct relay *relay, struct relay_client *client, const struct frame *frame,
                      const char **why)
{
    struct pattern *pattern = pattern_create(frame->name, frame->name_size);
    *why = "a subscription that is no regular expression";
    if (pattern == NULL)
        return false;
    if (client->patterns->len >= RELAY_PATTERNS_MAX) {
        pattern_free(pattern);
        *why = "too many subscriptions";
        return false;
    }
    g_ptr_array_add(client->patterns, pattern);
    g_hash_table_remove_all(relay->routes);
    return true;
}

static void unsubscribe(struct relay *relay, struct relay_client *client, const struct frame *frame)
{
    for (guint i = 0; i < client->patterns->len; i++)
        if (pattern_is(client->patterns->pdata[i], frame->name, frame->name_size)) {
            g_ptr_array_remove_index(client->patterns, i);
            g_hash_table_remove_all(relay->routes);
            return;
        }
}

// ---- Reading ----

// The answer to a hello, which finds the queue empty.
static void greet(struct relay *relay, struct relay_client *client)
{
    struct parcel *hello = parcel_create(FRAME_HELLO_SIZE, &relay->held);
    frame_hello(FRAME_HUB, hello->bytes);
    put(relay, client, hello);
    parcel_release(hello);
    relay->counters.delivered--; // no message
    client->greeted = true;
}

static bool carry_out(struct relay *relay, struct relay_client *client, const struct frame *frame,
                      const char **why)
{
    if (frame->type == FRAME_PUBLISH)
        publish(relay, client, frame);
    else if (frame->type == FRAME_UNSUBSCRIBE)
        unsubscribe(relay, client, frame);
    else
        return subscribe(relay, client, frame, why);
    return true;
}

// Carries out what is whole among the bytes; `taken` becomes how many that were.
static bool read_bytes(struct relay *relay, struct relay_client *client, const uint8_t *bytes,
                       size_t size, size_t *taken, const char **why)
{
    struct frame frame;
    *taken = 0;
    *why = "no hello of an LCM client";
    if (!client->greeted) {
        if (size < FRAME_HELLO_SIZE)
            return true;
        if (!frame_is_hello(FRAME_CLIENT, bytes))
            return false;
        greet(relay, client);
        *taken = FRAME_HELLO_SIZE;
    }
    for (;;) {
        size_t skipped = (size_t)MIN(client->skip, size - *taken);
        client->skip -= skipped;
        *taken += skipped;
        switch (frame_read(FRAME_CLIENT, bytes + *taken, size - *taken, relay->settings.message_max,
                           &frame)) {
        case FRAME_CUT:
            return true;
        case FRAME_WRONG:
            *why = "what is no message of LCM's protocol";
            return false;
        case FRAME_LARGE:
            relay->counters.large++;
            client->skip = frame.size;
            break;
        case FRAME_WHOLE:
            if (!carry_out(relay, client, &frame, why))
                return false;
            *taken += frame.size;
            break;
        }
    }
}

// Keeps what is not whole yet; `rest` may lie in what is kept.
static bool keep(struct relay *relay, struct relay_client *client, const uint8_t *rest, size_t size,
                 bool kept, int64_t now_ns, const char **why)
{
    guint before = client->pending->len;
    if (kept)
        g_byte_array_remove_range(client->pending, 0, before - (guint)size);
    else
        g_byte_array_append(client->pending, rest, (guint)size);
    relay->pending += client->pending->len;
    relay->pending -= before;
    *why = "a message for which there is no memory";
    bool incomplete = size > 0 || client->skip > 0;
    if (!incomplete)
        client->cut_ns = INT64_MAX;
    else if (client->cut_ns == INT64_MAX)
        client->cut_ns = now_ns;
    return size == 0 || relay->pending <= relay->settings.memory_max;
}

bool relay_take(struct relay *relay, struct relay_client *client, const uint8_t *bytes, size_t size,
                int64_t now_ns, const char **why)
{
    bool kept = client->pending->len > 0;
    size_t taken;
    if (kept) {
        g_byte_array_append(client->pending, bytes, (guint)size);
        relay->pending += size;
        bytes = client->pending->data;
        size = client->pending->len;
    }
    if (!read_bytes(relay, client, bytes, size, &taken, why))
        return false;
    if (taken > 0)
        client->cut_ns = INT64_MAX; // the frame that was incomplete is whole now
    return keep(relay, client, bytes + taken, size - taken, kept, now_ns, why);
}

// ---- Writing, looking ----

struct relay_client *relay_next_to_write(struct relay *relay)
{
    struct relay_client *client = g_queue_pop_head(&relay->to_write);
    if (client != NULL)
        client->to_write = false;
    return client;
}

size_t relay_peek(struct relay_client *client, struct iovec *pieces, size_t max)
{
    return queue_peek(&client->queue, pieces, max);
}

void relay_pop(struct relay_client *client, size_t size)
{
    queue_pop(&client->queue, size);
}

void *relay_user(const struct relay_client *client)
{
    return client->user;
}

const char *relay_name(const struct relay_client *client)
{
    return client->name;
}

uint64_t relay_lost(struct relay_client *client)
{
    uint64_t lost = client->lost;
    client->lost = 0;
    return lost;
}

void relay_each(struct relay *relay, void (*each)(struct relay_client *client, void *user),
                void *user)
{
    for (guint i = 0; i < relay->clients->len; i++)
        each(relay->clients->pdata[i], user);
}

size_t relay_count(const struct relay *relay)
{
    return relay->clients->len;
}

struct relay_counters relay_counters(const struct relay *relay)
{
    return relay->counters;
}
