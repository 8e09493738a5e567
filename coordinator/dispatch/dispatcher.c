// Design notes. The schedule answers an event with a list of effects that lives in the dispatcher
// and is reused. A call that led back to dispatcher_take() would empty the list while it is being
// carried out, so steps that are finished are kept aside until the list is done: whoever hears of
// one will most likely ask for the next. A text goes to all workers at once, since the others will
// soon want it too.
#include "coordinator/dispatch/dispatcher.h"

#include <assert.h>
#include <glib.h>

enum {
    TEXT_PIECES_MAX = 64, // answered to one request; the worker asks on from there
};

struct step {
    uint32_t search;
    uint32_t step;
};

struct dispatcher {
    const struct dispatcher_calls *calls;
    void *user;
    size_t piece_size;
    struct schedule *schedule;
    struct schedule_effects effects;
    struct text_server *texts;
    GArray *finished; // struct step, of which the user has not heard yet
    bool busy;        // effects are being carried out
};

struct dispatcher *dispatcher_create(const struct schedule_settings *settings, size_t piece_size,
                                     const struct dispatcher_calls *calls, void *user)
{
    assert(piece_size > 0);
    struct dispatcher *dispatcher = g_new(struct dispatcher, 1);
    *dispatcher = (struct dispatcher){
        .calls = calls,
        .user = user,
        .piece_size = piece_size,
        .schedule = schedule_create(settings),
        .effects.wake_ns = INT64_MAX,
        .texts = text_server_create(),
        .finished = g_array_new(FALSE, FALSE, sizeof(struct step)),
    };
    return dispatcher;
}

void dispatcher_free(struct dispatcher *dispatcher)
{
    if (dispatcher == NULL)
        return;
    g_array_unref(dispatcher->finished);
    text_server_free(dispatcher->texts);
    schedule_effects_fini(&dispatcher->effects);
    schedule_free(dispatcher->schedule);
    g_free(dispatcher);
}

static void carry_out(struct dispatcher *dispatcher, const struct schedule_effect *effect)
{
    const struct dispatcher_calls *calls = dispatcher->calls;
    switch (effect->kind) {
    case SCHEDULE_EFFECT_SEND:
        calls->send(dispatcher->user, effect->send.worker, &effect->send.batch);
        break;
    case SCHEDULE_EFFECT_COUNT:
        calls->count(dispatcher->user, &effect->count.batch);
        break;
    case SCHEDULE_EFFECT_STEP: {
        const struct step step = {effect->step.search, effect->step.step};
        g_array_append_val(dispatcher->finished, step);
        break;
    }
    case SCHEDULE_EFFECT_NOTE:
        calls->note(dispatcher->user, effect->note);
        break;
    }
}

// The list is taken from the front one by one, because a user that is told may finish more steps.
static void tell_finished(struct dispatcher *dispatcher)
{
    while (dispatcher->finished->len > 0) {
        const struct step step = g_array_index(dispatcher->finished, struct step, 0);
        g_array_remove_index(dispatcher->finished, 0);
        dispatcher->calls->finished(dispatcher->user, step.search, step.step);
    }
}

void dispatcher_take(struct dispatcher *dispatcher, const struct schedule_event *event)
{
    assert(!dispatcher->busy);
    dispatcher->busy = true;
    schedule_step(dispatcher->schedule, event, &dispatcher->effects);
    for (size_t i = 0; i < dispatcher->effects.count; i++)
        carry_out(dispatcher, &dispatcher->effects.items[i]);
    dispatcher->busy = false;
    tell_finished(dispatcher);
}

void dispatcher_request(struct dispatcher *dispatcher, const struct digest *digest, size_t offset,
                        int64_t now_ns)
{
    size_t total = 0;
    const uint8_t *text = text_server_ask(dispatcher->texts, digest, offset, now_ns, &total);
    if (text == NULL)
        return;
    for (int count = 0; count < TEXT_PIECES_MAX && offset < total; count++) {
        const struct text_piece piece = {
            .digest = *digest,
            .total = total,
            .offset = offset,
            .bytes = text + offset,
            .size = MIN(dispatcher->piece_size, total - offset),
        };
        dispatcher->calls->piece(dispatcher->user, &piece);
        offset += piece.size;
    }
}

struct text_server *dispatcher_texts(struct dispatcher *dispatcher)
{
    return dispatcher->texts;
}

int64_t dispatcher_wake_ns(const struct dispatcher *dispatcher)
{
    return dispatcher->effects.wake_ns;
}

void dispatcher_counters(const struct dispatcher *dispatcher, struct schedule_counters *counters)
{
    schedule_counters(dispatcher->schedule, counters);
}
