#include "monitor/texts/texts.h"

#include "common/scenario/scenario_read.h"
#include "monitor/feed/table.h"

#include <glib.h>
#include <string.h>

struct known {
    struct table_entry entry; // keys: the halves of the digest
    struct scenario scenario;
};

struct wanted {
    struct digest digest;
    uint64_t run;
    GByteArray *bytes;  // received so far, without a gap; NULL: the place is free
    uint32_t total;     // [bytes] 0 until the first piece
    unsigned tries;     // since the last piece
    int64_t asked_ns;   // INT64_MIN before the first time
    guint asked_offset; // where the last request began
};

struct given_up {
    struct table_entry entry;
    int64_t since_ns;
};

struct texts {
    struct table known;
    struct table given_up;
    struct wanted wanted[TEXTS_WANTED_MAX];
};

static void release_known(gpointer user)
{
    struct known *known = user;
    scenario_fini(&known->scenario);
    g_free(known);
}

static void halves(const struct digest *digest, uint64_t key[2])
{
    memcpy(key, digest->bytes, sizeof digest->bytes);
}

struct texts *texts_create(void)
{
    struct texts *texts = g_new0(struct texts, 1);
    table_init(&texts->known, TEXTS_KNOWN_MAX, release_known);
    table_init(&texts->given_up, TEXTS_GIVEN_UP_MAX, g_free);
    return texts;
}

static void wanted_clear(struct wanted *wanted)
{
    if (wanted->bytes != NULL)
        g_byte_array_free(wanted->bytes, TRUE);
    *wanted = (struct wanted){0};
}

void texts_free(struct texts *texts)
{
    if (texts == NULL)
        return;
    for (int i = 0; i < TEXTS_WANTED_MAX; i++)
        wanted_clear(&texts->wanted[i]);
    table_fini(&texts->known);
    table_fini(&texts->given_up);
    g_free(texts);
}

const struct scenario *texts_find(struct texts *texts, const struct digest *digest)
{
    uint64_t key[2];
    halves(digest, key);
    struct known *known = table_find(&texts->known, key[0], key[1]);
    if (known == NULL)
        return NULL;
    table_touch(&texts->known, &known->entry);
    return &known->scenario;
}

static struct wanted *wanted_find(struct texts *texts, const struct digest *digest)
{
    for (int i = 0; i < TEXTS_WANTED_MAX; i++) {
        struct wanted *wanted = &texts->wanted[i];
        if (wanted->bytes != NULL && digest_equal(&wanted->digest, digest))
            return wanted;
    }
    return NULL;
}

static bool is_given_up(struct texts *texts, const struct digest *digest, int64_t now_ns)
{
    uint64_t key[2];
    halves(digest, key);
    struct given_up *given_up = table_find(&texts->given_up, key[0], key[1]);
    if (given_up == NULL)
        return false;
    if (now_ns - given_up->since_ns < TEXTS_FORGIVE_NS)
        return true;
    table_remove(&texts->given_up, &given_up->entry);
    return false;
}

static void give_up(struct texts *texts, struct wanted *wanted, int64_t now_ns)
{
    uint64_t key[2];
    halves(&wanted->digest, key);
    struct given_up *given_up = g_new0(struct given_up, 1);
    given_up->since_ns = now_ns;
    table_add(&texts->given_up, &given_up->entry, key[0], key[1]);
    wanted_clear(wanted);
}

bool texts_want(struct texts *texts, uint64_t run, const struct digest *digest, int64_t now_ns)
{
    if (texts_find(texts, digest) != NULL || is_given_up(texts, digest, now_ns))
        return false;
    if (wanted_find(texts, digest) != NULL)
        return true;
    for (int i = 0; i < TEXTS_WANTED_MAX; i++) {
        if (texts->wanted[i].bytes == NULL) {
            texts->wanted[i] = (struct wanted){
                .digest = *digest,
                .run = run,
                .bytes = g_byte_array_new(),
                .asked_ns = INT64_MIN,
            };
            return true;
        }
    }
    return false;
}

bool texts_waiting(const struct texts *texts)
{
    for (int i = 0; i < TEXTS_WANTED_MAX; i++) {
        if (texts->wanted[i].bytes != NULL)
            return true;
    }
    return false;
}

// A request is answered with many pieces: while they come, nothing is asked.
static bool is_due(const struct wanted *wanted, int64_t now_ns)
{
    return wanted->asked_ns == INT64_MIN || now_ns - wanted->asked_ns >= TEXTS_AGAIN_NS;
}

bool texts_ask(struct texts *texts, int64_t now_ns, sobox_text_request_t *message)
{
    for (int i = 0; i < TEXTS_WANTED_MAX; i++) {
        struct wanted *wanted = &texts->wanted[i];
        if (wanted->bytes == NULL || !is_due(wanted, now_ns))
            continue;
        wanted->tries = wanted->bytes->len > wanted->asked_offset ? 0 : wanted->tries;
        if (wanted->tries == TEXTS_TRIES) {
            give_up(texts, wanted, now_ns);
            continue;
        }
        wanted->tries++;
        wanted->asked_ns = now_ns;
        wanted->asked_offset = wanted->bytes->len;
        *message = (sobox_text_request_t){
            .header.run = (int64_t)wanted->run,
            .offset = (int32_t)wanted->bytes->len,
        };
        memcpy(message->digest, wanted->digest.bytes, DIGEST_SIZE);
        return true;
    }
    return false;
}

bool texts_learn(struct texts *texts, const struct digest *digest, const char *text, size_t size)
{
    const struct digest found = digest_of(text, size);
    struct error error = {0};
    struct known *known = g_new0(struct known, 1);
    if (!digest_equal(&found, digest) || texts_find(texts, digest) != NULL ||
        scenario_read_text(&known->scenario, "scenario", text, size, NULL, 0, &error) !=
            STATUS_OK) {
        g_free(known);
        return false;
    }
    uint64_t key[2];
    halves(digest, key);
    table_add(&texts->known, &known->entry, key[0], key[1]);
    return true;
}

bool texts_heard(struct texts *texts, const sobox_text_t *message)
{
    struct digest digest;
    memcpy(digest.bytes, message->digest, DIGEST_SIZE);
    struct wanted *wanted = wanted_find(texts, &digest);
    if (wanted == NULL)
        return false;
    if (wanted->total == 0)
        wanted->total = (uint32_t)message->total_size;
    // A piece beyond a gap is asked for again when its turn comes: texts have few pieces.
    if ((uint32_t)message->total_size != wanted->total ||
        (guint)message->offset != wanted->bytes->len)
        return false;
    g_byte_array_append(wanted->bytes, message->piece, (guint)message->piece_size);
    if (wanted->bytes->len < wanted->total)
        return false;
    const bool known =
        texts_learn(texts, &digest, (const char *)wanted->bytes->data, wanted->bytes->len);
    if (known)
        wanted_clear(wanted);
    else // a lie in between: anew, as often as after a loss
        g_byte_array_set_size(wanted->bytes, 0);
    return known;
}
