#include "common/wire/fresh.h"

#include <glib.h>
#include <sodium.h>
#include <string.h>

enum { WORD_BITS = 64, WINDOW_WORDS = FRESH_WINDOW / WORD_BITS + 1 };

// Which numbers of one kind have been heard: a ring of bits, in which the words that the greatest
// number has moved into are cleared (as RFC 6479 does for IPsec).
struct window {
    uint64_t greatest;
    uint64_t bits[WINDOW_WORDS];
};

struct name {
    uint64_t sender;
    uint64_t salt;
};

struct proven {
    struct name name;
    GList link;     // in `order`; its data is this
    uint64_t floor; // numbers up to here are refused
    struct window windows[WIRE_KIND_COUNT];
};

struct waiting {
    struct name name; // sender 0: free
    int64_t heard_ns;
    int64_t asked_ns;
    GQueue held; // of struct fresh_message, owned
};

struct fresh {
    uint8_t challenge[FRESH_CHALLENGE_SIZE];
    int64_t drawn_ns;   // the challenge was
    GHashTable *proven; // struct name -> struct proven, owned
    GQueue order;       // the proven, last heard first
    struct waiting waiting[FRESH_WAITING_MAX];
    unsigned holding; // of the waiting, those with held messages
    GQueue released;  // of struct fresh_message, owned
    size_t held_bytes;
    uint64_t refused;
};

static guint name_hash(gconstpointer key)
{
    const struct name *name = key; // both numbers are random
    return (guint)(name->sender ^ name->salt);
}

static gboolean name_equal(gconstpointer a, gconstpointer b)
{
    const struct name *one = a, *other = b;
    return one->sender == other->sender && one->salt == other->salt;
}

static struct name name_of(const struct seal_origin *origin)
{
    return (struct name){.sender = origin->sender, .salt = origin->salt};
}

static void draw_challenge(struct fresh *fresh, int64_t now_ns)
{
    randombytes_buf(fresh->challenge, sizeof fresh->challenge);
    fresh->drawn_ns = now_ns;
}

struct fresh *fresh_create(int64_t now_ns)
{
    struct fresh *fresh = g_new0(struct fresh, 1);
    draw_challenge(fresh, now_ns);
    fresh->proven = g_hash_table_new_full(name_hash, name_equal, NULL, g_free);
    return fresh;
}

void fresh_free(struct fresh *fresh)
{
    if (fresh == NULL)
        return;
    for (unsigned i = 0; i < FRESH_WAITING_MAX; i++)
        g_queue_clear_full(&fresh->waiting[i].held, g_free);
    g_queue_clear_full(&fresh->released, g_free);
    g_hash_table_destroy(fresh->proven); // the links of `order` live inside
    g_free(fresh);
}

const uint8_t *fresh_challenge(const struct fresh *fresh)
{
    return fresh->challenge;
}

int64_t fresh_age_ns(const struct fresh *fresh, int64_t now_ns)
{
    return now_ns - fresh->drawn_ns;
}

uint64_t fresh_refused(const struct fresh *fresh)
{
    return fresh->refused;
}

// ---- Numbers of a proven sender ----

static bool window_take(struct window *window, uint64_t number)
{
    if (number > window->greatest) {
        uint64_t word = window->greatest / WORD_BITS, last = number / WORD_BITS;
        if (last - word > WINDOW_WORDS)
            word = last - WINDOW_WORDS;
        while (word < last)
            window->bits[++word % WINDOW_WORDS] = 0;
        window->greatest = number;
    } else if (window->greatest - number >= FRESH_WINDOW) {
        return false;
    }
    uint64_t *bits = &window->bits[number / WORD_BITS % WINDOW_WORDS];
    uint64_t bit = UINT64_C(1) << number % WORD_BITS;
    if ((*bits & bit) != 0)
        return false;
    *bits |= bit;
    return true;
}

enum fresh_result fresh_hear(struct fresh *fresh, enum wire_kind kind,
                             const struct seal_origin *origin)
{
    struct name name = name_of(origin);
    struct proven *proven = g_hash_table_lookup(fresh->proven, &name);
    if (proven == NULL)
        return FRESH_UNPROVEN;
    if (origin->number <= proven->floor || !window_take(&proven->windows[kind], origin->number))
        return FRESH_OLD;
    g_queue_unlink(&fresh->order, &proven->link);
    g_queue_push_head_link(&fresh->order, &proven->link);
    return FRESH_NEW;
}

// ---- Senders that are not proven ----

static void drop_front(struct fresh *fresh, struct waiting *waiting)
{
    struct fresh_message *message = g_queue_pop_head(&waiting->held);
    fresh->held_bytes -= message->size;
    fresh->holding -= g_queue_is_empty(&waiting->held);
    fresh->refused++;
    g_free(message);
}

static struct waiting *find_waiting(struct fresh *fresh, const struct name *name)
{
    for (unsigned i = 0; i < FRESH_WAITING_MAX; i++)
        if (name_equal(&fresh->waiting[i].name, name))
            return &fresh->waiting[i];
    return NULL;
}

// A place for a new one: a free one (it was heard at 0), or that of the one unheard longest.
static struct waiting *place_waiting(struct fresh *fresh, const struct name *name, int64_t now_ns)
{
    struct waiting *place = &fresh->waiting[0];
    for (unsigned i = 1; i < FRESH_WAITING_MAX && place->name.sender != 0; i++)
        if (fresh->waiting[i].name.sender == 0 || fresh->waiting[i].heard_ns < place->heard_ns)
            place = &fresh->waiting[i];
    while (!g_queue_is_empty(&place->held))
        drop_front(fresh, place);
    *place =
        (struct waiting){.name = *name, .asked_ns = now_ns - FRESH_ASK_NS, .held = G_QUEUE_INIT};
    return place;
}

static void keep(struct fresh *fresh, struct waiting *waiting, const struct fresh_message *head,
                 const uint8_t *bytes)
{
    if (g_queue_get_length(&waiting->held) >= FRESH_HELD_MAX ||
        fresh->held_bytes + head->size > FRESH_HELD_BYTES) {
        fresh->refused++;
        return;
    }
    struct fresh_message *message = g_malloc(sizeof *message + head->size);
    *message = *head;
    memcpy(message->bytes, bytes, head->size);
    fresh->holding += g_queue_is_empty(&waiting->held);
    g_queue_push_tail(&waiting->held, message);
    fresh->held_bytes += head->size;
}

void fresh_hold(struct fresh *fresh, enum wire_kind kind, const struct seal_origin *origin,
                const uint8_t *bytes, size_t size, int64_t now_ns)
{
    struct name name = name_of(origin);
    fresh_expire(fresh, now_ns);
    struct waiting *waiting = find_waiting(fresh, &name);
    if (waiting == NULL)
        waiting = place_waiting(fresh, &name, now_ns);
    waiting->heard_ns = now_ns;
    const struct fresh_message head = {
        .origin = *origin, .kind = kind, .held_ns = now_ns, .size = size};
    keep(fresh, waiting, &head, bytes);
}

uint64_t fresh_ask(struct fresh *fresh, int64_t now_ns)
{
    for (unsigned i = 0; i < FRESH_WAITING_MAX && fresh->holding > 0; i++) {
        struct waiting *waiting = &fresh->waiting[i];
        if (g_queue_is_empty(&waiting->held) || now_ns - waiting->asked_ns < FRESH_ASK_NS)
            continue;
        waiting->asked_ns = now_ns;
        return waiting->name.sender;
    }
    return 0;
}

int64_t fresh_wake_ns(const struct fresh *fresh)
{
    int64_t wake_ns = INT64_MAX;
    for (unsigned i = 0; i < FRESH_WAITING_MAX && fresh->holding > 0; i++) {
        const struct waiting *waiting = &fresh->waiting[i];
        if (waiting->held.head == NULL)
            continue;
        const struct fresh_message *first = waiting->held.head->data;
        int64_t ask_ns = waiting->asked_ns + FRESH_ASK_NS;
        int64_t end_ns = first->held_ns + FRESH_PATIENCE_NS;
        wake_ns = MIN(wake_ns, MIN(ask_ns, end_ns));
    }
    return wake_ns;
}

void fresh_expire(struct fresh *fresh, int64_t now_ns)
{
    for (unsigned i = 0; i < FRESH_WAITING_MAX && fresh->holding > 0; i++) {
        struct waiting *waiting = &fresh->waiting[i];
        const struct fresh_message *first;
        while ((first = g_queue_peek_head(&waiting->held)) != NULL &&
               now_ns - first->held_ns >= FRESH_PATIENCE_NS)
            drop_front(fresh, waiting);
    }
}

// ---- Proof ----

static void forget_oldest(struct fresh *fresh, int64_t now_ns)
{
    struct proven *oldest = g_queue_peek_tail(&fresh->order);
    g_queue_unlink(&fresh->order, &oldest->link);
    g_hash_table_remove(fresh->proven, &oldest->name);
    // Its proof was recorded perhaps: it must not count a second time.
    draw_challenge(fresh, now_ns);
}

// What is older than the receiver is no offence: it goes without being counted.
static void release_held(struct fresh *fresh, struct waiting *waiting, uint64_t floor)
{
    struct fresh_message *message;
    fresh->holding -= !g_queue_is_empty(&waiting->held);
    while ((message = g_queue_pop_head(&waiting->held)) != NULL) {
        fresh->held_bytes -= message->size;
        if (message->origin.number > floor)
            g_queue_push_tail(&fresh->released, message);
        else
            g_free(message);
    }
    *waiting = (struct waiting){.held = G_QUEUE_INIT};
}

void fresh_prove(struct fresh *fresh, const struct seal_origin *origin, uint64_t floor,
                 int64_t now_ns)
{
    struct name name = name_of(origin);
    if (g_hash_table_contains(fresh->proven, &name))
        return;
    if (g_hash_table_size(fresh->proven) >= FRESH_PROVEN_MAX)
        forget_oldest(fresh, now_ns);
    struct proven *proven = g_new0(struct proven, 1);
    proven->name = name;
    proven->link.data = proven;
    proven->floor = MIN(floor, origin->number);
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        proven->windows[kind].greatest = proven->floor;
    window_take(&proven->windows[WIRE_HAIL], origin->number);
    g_hash_table_insert(fresh->proven, &proven->name, proven);
    g_queue_push_head_link(&fresh->order, &proven->link);
    struct waiting *waiting = find_waiting(fresh, &name);
    if (waiting != NULL)
        release_held(fresh, waiting, proven->floor);
}

struct fresh_message *fresh_release(struct fresh *fresh)
{
    return g_queue_pop_head(&fresh->released);
}
