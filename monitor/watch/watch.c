#include "monitor/watch/watch.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/numeric/identity.h"
#include "common/wire/source.h"
#include "common/wire/wire.h"

#include <glib.h>

enum { ASK_MS = 50 };

// Scenarios are asked for unasked, as soon as a search is heard of, but of a sweep's thousands only
// one in a while: the others when somebody looks at them. [ns]
static const int64_t EAGER_NS = 500 * CLOCK_MILLISECOND_NS;

struct watch {
    char *url;
    const struct key *key;
    struct feed *feed;
    struct texts *texts;
    struct wire *wire;   // of the status messages
    struct wire *asking; // of the texts; NULL while none is asked for
    guint ask;           // GLib source; 0 likewise
    int64_t eager_ns;    // when the next text may be asked for unasked
    bool failed;         // asking failed, and it was said
};

static enum status wire_make(struct wire **wire, const struct watch *watch, struct error *error)
{
    struct wire_settings settings = wire_settings_default();
    settings.url = watch->url;
    settings.key = watch->key;
    return wire_open(wire, &settings, identity_random(), error);
}

// ---- Texts ----

static void asking_end(struct watch *watch)
{
    if (watch->ask != 0)
        g_source_remove(watch->ask);
    watch->ask = 0;
    if (watch->asking != NULL)
        wire_source_detach(watch->asking);
    wire_close(watch->asking);
    watch->asking = NULL;
}

static void text_heard(void *user, enum wire_kind kind, const void *message)
{
    (void)kind;
    struct watch *watch = user;
    texts_heard(watch->texts, message);
}

// The wire is closed here and not where a text is heard: that is inside its dispatch.
static gboolean ask(gpointer user)
{
    struct watch *watch = user;
    sobox_text_request_t message;
    while (texts_ask(watch->texts, clock_monotonic_ns(), &message))
        (void)!wire_publish(watch->asking, WIRE_TEXT_REQUEST, &message);
    if (texts_waiting(watch->texts))
        return G_SOURCE_CONTINUE;
    watch->ask = 0;
    asking_end(watch);
    return G_SOURCE_REMOVE;
}

static void asking_begin(struct watch *watch)
{
    if (watch->asking != NULL || watch->failed)
        return;
    struct error error = {0};
    enum status status = wire_make(&watch->asking, watch, &error);
    if (status == STATUS_OK)
        status = wire_subscribe(watch->asking, WIRE_TEXT, text_heard, watch, &error);
    if (status != STATUS_OK) {
        watch->failed = true;
        log_note("corridors cannot be drawn over their design space: %s", error.text);
        asking_end(watch);
        return;
    }
    wire_source_attach(watch->asking);
    watch->ask = g_timeout_add(ASK_MS, ask, watch);
    if (ask(watch) == G_SOURCE_REMOVE)
        asking_end(watch);
}

void watch_want(struct watch *watch, uint64_t run, const struct digest *scenario)
{
    if (texts_want(watch->texts, run, scenario, clock_monotonic_ns()))
        asking_begin(watch);
}

static void want_eagerly(struct watch *watch, const sobox_search_status_t *message, int64_t now_ns)
{
    if (now_ns < watch->eager_ns)
        return;
    struct digest scenario;
    memcpy(scenario.bytes, message->scenario, DIGEST_SIZE);
    if (texts_find(watch->texts, &scenario) != NULL)
        return;
    watch->eager_ns = now_ns + EAGER_NS;
    watch_want(watch, (uint64_t)message->header.run, &scenario);
}

// ---- Status ----

static void heard(void *user, enum wire_kind kind, const void *message)
{
    struct watch *watch = user;
    const int64_t now_ns = clock_monotonic_ns();
    if (kind == WIRE_RUN_STATUS) {
        feed_run_heard(watch->feed, message, now_ns);
    } else if (kind == WIRE_SEARCH_STATUS) {
        feed_search_heard(watch->feed, message, now_ns);
        want_eagerly(watch, message, now_ns);
    } else if (kind == WIRE_STEP_STATUS) {
        feed_step_heard(watch->feed, message, now_ns);
    } else if (kind == WIRE_CASES) {
        feed_cases_heard(watch->feed, message, now_ns);
    } else if (kind == WIRE_WORKER_STATUS) {
        feed_worker_heard(watch->feed, message, now_ns);
    }
}

void watch_count(struct watch *watch, int64_t now_ns)
{
    struct wire_counters counters;
    wire_counters(watch->wire, &counters);
    feed_own_counted(watch->feed,
                     &(struct feed_own){
                         .received = counters.received,
                         .rejected = counters.rejected,
                         .foreign = counters.foreign,
                         .unopened = counters.unopened,
                         .lost = counters.lost,
                         .dropped = counters.dropped,
                         .buffer_size = counters.buffer_size,
                     },
                     now_ns);
}

enum status watch_start(struct watch **made, const char *url, const struct key *key,
                        struct feed *feed, struct texts *texts, struct error *error)
{
    struct watch *watch = g_new0(struct watch, 1);
    *watch = (struct watch){.url = g_strdup(url), .key = key, .feed = feed, .texts = texts};
    enum status status = wire_make(&watch->wire, watch, error);
    if (status == STATUS_OK)
        status = wire_subscribe(watch->wire, WIRE_RUN_STATUS, heard, watch, error);
    if (status == STATUS_OK)
        status = wire_subscribe(watch->wire, WIRE_SEARCH_STATUS, heard, watch, error);
    if (status == STATUS_OK)
        status = wire_subscribe(watch->wire, WIRE_STEP_STATUS, heard, watch, error);
    if (status == STATUS_OK)
        status = wire_subscribe(watch->wire, WIRE_CASES, heard, watch, error);
    // With a key each worker is asked once for a proof that it is there: no recording is shown.
    if (status == STATUS_OK)
        status = wire_subscribe(watch->wire, WIRE_WORKER_STATUS, heard, watch, error);
    if (status != STATUS_OK) {
        wire_close(watch->wire);
        g_free(watch->url);
        g_free(watch);
        *made = NULL;
        return status;
    }
    wire_source_attach(watch->wire);
    *made = watch;
    return STATUS_OK;
}

void watch_stop(struct watch *watch)
{
    if (watch == NULL)
        return;
    asking_end(watch);
    wire_source_detach(watch->wire);
    wire_close(watch->wire);
    g_free(watch->url);
    g_free(watch);
}
