#include "tests/cluster/coordinator_node.h"

#include "common/sampling/box_text.h"

#include "tests/cluster/trace.h"

#include <stdio.h>
#include <string.h>

enum { COORDINATOR_NODE_SOCKET_MAX = 2000 }; // packets that wait while it is stopped

void coordinator_node_init(struct coordinator_node *node, struct network *network,
                           struct dice *dice, const struct problem *problem, uint32_t search_count,
                           const struct schedule_settings *settings)
{
    *node = (struct coordinator_node){
        .network = network,
        .dice = dice,
        .settings = settings,
        .search_count = search_count,
        .piece_size = 1300,
        .run = dice_sender(dice),
        .stopped_until_ns = INT64_MIN,
    };
    g_queue_init(&node->socket);
    g_queue_init(&node->ready);
    for (uint32_t i = 0; i < search_count; i++) {
        node->searches[i].scenario = &problem->scenarios[i];
        node->searches[i].text = g_byte_array_new();
        node->searches[i].journal = g_ptr_array_new_with_free_func(g_free);
    }
}

static void search_send(struct coordinator_node *node, uint32_t place, uint64_t holder,
                        const struct batch_identity *batch, int64_t now_ns)
{
    const struct coordinator_search *search = &node->searches[batch->search];
    struct message message = {
        .kind = MESSAGE_BATCH,
        .sender = node->sender,
        .run = node->run,
        .batch = {.holder = holder,
                  .identity = *batch,
                  .scenario = search->scenario->digest,
                  .box = search->box,
                  .sampling = search->request.sampling,
                  .detail = search->request.detail},
    };
    message.batch.variables = search->scenario->design_space.count;
    if (!node->boxes_by_request) {
        message.payload = search->text->data;
        message.payload_size = search->text->len;
    }
    node->batches_sent++;
    network_send(node->network, 0, place, &message, now_ns);
}

// ---- What the dispatcher asks ----

static void send_batch(void *user, uint64_t worker, const struct batch_identity *batch)
{
    struct coordinator_node *node = user;
    const struct coordinator_search *search = &node->searches[batch->search];
    const int64_t now_ns = node->now_ns;
    gpointer place = g_hash_table_lookup(node->places, &worker);
    TRACE_CHECK(now_ns, place != NULL);
    TRACE_CHECK(now_ns, search->active);
    TRACE_CHECK(now_ns, batch->step == search->request.sampling.step);
    TRACE_CHECK(now_ns, batch->count > 0);
    TRACE_CHECK(now_ns, batch->first + batch->count <= search->request.sampling.samples);
    trace_line(now_ns, "coordinator", "search %u step %u batch %u attempt %u: %u + %u to worker %u",
               batch->search, batch->step, batch->batch, batch->attempt, batch->first, batch->count,
               GPOINTER_TO_UINT(place));
    search_send(node, GPOINTER_TO_UINT(place), worker, batch, now_ns);
}

static void count_batch(void *user, const struct batch_identity *batch)
{
    struct coordinator_node *node = user;
    struct coordinator_search *search = &node->searches[batch->search];
    TRACE_CHECK(node->now_ns, node->heard != NULL);
    memcpy(search->verdicts + batch->first, node->heard, batch->count * sizeof *node->heard);
    for (uint32_t i = 0; i < batch->count; i++)
        TRACE_CHECK(node->now_ns, ++search->counted[batch->first + i] == 1);
}

static void step_sampled(void *user, uint32_t index, uint32_t step)
{
    struct coordinator_node *node = user;
    struct coordinator_search *search = &node->searches[index];
    TRACE_CHECK(node->now_ns, search->active);
    TRACE_CHECK(node->now_ns, step == search->request.sampling.step);
    for (uint32_t i = 0; i < search->request.sampling.samples; i++)
        TRACE_CHECK(node->now_ns, search->counted[i] == 1);
    trace_line(node->now_ns, "coordinator", "search %u step %u done", index, step);
    text_server_withdraw(dispatcher_texts(node->dispatcher), &search->box);
    g_queue_push_tail(&node->ready, GUINT_TO_POINTER(index));
}

static void send_piece(void *user, const struct text_piece *piece)
{
    struct coordinator_node *node = user;
    struct message message = {
        .kind = MESSAGE_TEXT,
        .sender = node->sender,
        .run = node->run,
        .text = {.digest = piece->digest,
                 .total = (uint32_t)piece->total,
                 .offset = (uint32_t)piece->offset},
        .payload = piece->bytes,
        .payload_size = (uint32_t)piece->size,
    };
    // Text goes to everybody.
    for (uint32_t place = 1; place <= node->worker_count; place++)
        network_send(node->network, 0, place, &message, node->now_ns);
}

static void note(void *user, const char *text)
{
    const struct coordinator_node *node = user;
    trace_line(node->now_ns, "coordinator", "%s", text);
}

static const struct dispatcher_calls calls = {
    .send = send_batch,
    .count = count_batch,
    .finished = step_sampled,
    .piece = send_piece,
    .note = note,
};

// Hands an event to the dispatcher. `verdicts` are the outcome's.
static void node_take(struct coordinator_node *node, struct schedule_event *event,
                      const struct verdict *verdicts, int64_t now_ns)
{
    struct schedule_counters before, counters;
    dispatcher_counters(node->dispatcher, &before);
    event->now_ns = node->now_ns = now_ns;
    node->heard = verdicts;
    dispatcher_take(node->dispatcher, event);
    node->heard = NULL;
    dispatcher_counters(node->dispatcher, &counters);
    if (counters.released > before.released)
        trace_line(now_ns, "coordinator", "%llu leases released",
                   (unsigned long long)(counters.released - before.released));
    if (counters.copies > before.copies)
        trace_line(now_ns, "coordinator", "%llu late batches copied",
                   (unsigned long long)(counters.copies - before.copies));
    TRACE_CHECK(now_ns, counters.batches_leased <= counters.workers * node->settings->window_max);
    const int64_t wake_ns = dispatcher_wake_ns(node->dispatcher);
    TRACE_CHECK(now_ns, wake_ns >= now_ns || wake_ns == INT64_MAX);
}

// ---- Searches ----

// Asks the search for its next step and wants it sampled.
static void search_next(struct coordinator_node *node, uint32_t index, int64_t now_ns)
{
    struct coordinator_search *search = &node->searches[index];
    search->active = search_request(search->search, &search->request);
    if (!search->active) {
        node->done_count++;
        return;
    }
    const uint32_t samples = search->request.sampling.samples;
    g_byte_array_set_size(search->text, 0);
    box_text_put(search->text, search->request.box, search->request.sampling.moves);
    search->box = digest_of(search->text->data, search->text->len);
    text_server_offer(dispatcher_texts(node->dispatcher), &search->box, search->text->data,
                      search->text->len);
    search->verdicts = g_renew(struct verdict, search->verdicts, samples);
    search->counted = g_realloc(search->counted, samples);
    memset(search->counted, 0, samples);
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_STEP,
        .step = {.search = index,
                 .step = search->request.sampling.step,
                 .samples = samples,
                 .detail = search->request.detail},
    };
    node_take(node, &event, NULL, now_ns);
}

// Completed steps go into the journal, then to their searches.
static void node_advance(struct coordinator_node *node, int64_t now_ns)
{
    while (node->ready.length > 0) {
        uint32_t index = GPOINTER_TO_UINT(g_queue_pop_head(&node->ready));
        struct coordinator_search *search = &node->searches[index];
        g_ptr_array_add(search->journal, search->verdicts);
        search_complete(search->search, search->verdicts);
        search->verdicts = NULL;
        search_next(node, index, now_ns);
    }
}

void coordinator_node_start(struct coordinator_node *node, int64_t now_ns)
{
    if (node->running)
        return;
    node->running = true;
    node->sender = dice_sender(node->dice);
    node->stopped_until_ns = INT64_MIN;
    node->dispatcher = dispatcher_create(node->settings, node->piece_size, &calls, node);
    node->places = g_hash_table_new_full(g_int64_hash, g_int64_equal, g_free, NULL);
    node->done_count = 0;
    trace_line(now_ns, "coordinator", "starts");
    for (uint32_t i = 0; i < node->search_count; i++) {
        struct coordinator_search *search = &node->searches[i];
        text_server_offer(dispatcher_texts(node->dispatcher), &search->scenario->digest,
                          search->scenario->text, search->scenario->text_size);
        search->search = search_create(search->scenario, search->scenario->search.seed, 1);
        for (guint step = 0; step < search->journal->len; step++) {
            TRACE_CHECK(now_ns, search_request(search->search, &search->request));
            search_complete(search->search, search->journal->pdata[step]);
        }
        search_next(node, i, now_ns);
    }
}

// Adds what only grows.
static void counters_add(struct schedule_counters *sum, const struct schedule_counters *more)
{
    sum->batches_counted += more->batches_counted;
    sum->samples_counted += more->samples_counted;
    sum->released += more->released;
    sum->copies += more->copies;
    sum->duplicates += more->duplicates;
    sum->unknown += more->unknown;
    sum->service_ns += more->service_ns;
}

void coordinator_node_kill(struct coordinator_node *node)
{
    if (!node->running)
        return;
    node->running = false;
    struct schedule_counters counters;
    dispatcher_counters(node->dispatcher, &counters);
    counters_add(&node->counters, &counters);
    dispatcher_free(node->dispatcher);
    g_hash_table_destroy(node->places);
    g_queue_clear(&node->ready);
    struct packet *packet;
    while ((packet = g_queue_pop_head(&node->socket)) != NULL)
        network_drop(packet);
    for (uint32_t i = 0; i < node->search_count; i++) {
        struct coordinator_search *search = &node->searches[i];
        search_free(search->search);
        g_free(search->verdicts);
        search->verdicts = NULL;
        search->active = false;
    }
}

void coordinator_node_fini(struct coordinator_node *node)
{
    coordinator_node_kill(node);
    for (uint32_t i = 0; i < node->search_count; i++) {
        g_ptr_array_free(node->searches[i].journal, TRUE);
        g_byte_array_unref(node->searches[i].text);
        g_free(node->searches[i].counted);
    }
}

// As the runtime does: what does not unpack is dropped, and only the open step is unpacked.
static void node_outcome(struct coordinator_node *node, const struct message *message,
                         int64_t now_ns)
{
    const struct batch_identity *identity = &message->outcome.identity;
    TRACE_CHECK(now_ns, identity->search < node->search_count);
    const struct coordinator_search *search = &node->searches[identity->search];
    struct verdict *verdicts = NULL;
    if (search->active && identity->step == search->request.sampling.step) {
        verdicts = g_new(struct verdict, identity->count);
        TRACE_CHECK(now_ns, verdict_unpack(verdicts, identity->count, message->outcome.detail,
                                           search->scenario->constraint_count, message->payload,
                                           message->payload_size));
    }
    trace_line(now_ns, "coordinator", "outcome of search %u step %u batch %u attempt %u, queue %u",
               identity->search, identity->step, identity->batch, identity->attempt,
               message->outcome.queue);
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_OUTCOME,
        .outcome = {.worker = message->sender,
                    .batch = *identity,
                    .queue = message->outcome.queue,
                    .service_ns = message->outcome.service_ns},
    };
    node_take(node, &event, verdicts, now_ns);
    g_free(verdicts);
    node_advance(node, now_ns);
}

static void node_worker(struct coordinator_node *node, const struct message *message,
                        uint32_t place, int64_t now_ns)
{
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_WORKER,
        .worker = {.id = message->sender,
                   .threads = message->worker.threads,
                   .queue = message->worker.queue,
                   .leaving = message->worker.leaving,
                   .acceptable = message->worker.acceptable},
    };
    snprintf(event.worker.name, sizeof event.worker.name, "host%u/%04x", place,
             (unsigned)(message->sender >> 48));
    g_hash_table_insert(node->places, g_memdup2(&message->sender, sizeof message->sender),
                        GUINT_TO_POINTER(place));
    node_take(node, &event, NULL, now_ns);
}

static void node_request(struct coordinator_node *node, const struct message *message,
                         int64_t now_ns)
{
    node->now_ns = now_ns;
    dispatcher_request(node->dispatcher, &message->request.digest, message->request.offset, now_ns);
}

static void node_handle(struct coordinator_node *node, struct packet *packet, int64_t now_ns)
{
    const struct message *message = &packet->message;
    if (message->kind == MESSAGE_OUTCOME)
        node_outcome(node, message, now_ns);
    else if (message->kind == MESSAGE_TEXT_REQUEST)
        node_request(node, message, now_ns);
    else if (message->kind == MESSAGE_WORKER)
        node_worker(node, message, packet->from, now_ns);
    network_drop(packet);
}

void coordinator_node_receive(struct coordinator_node *node, struct packet *packet, int64_t now_ns)
{
    bool stopped = node->running && now_ns < node->stopped_until_ns;
    if (stopped && node->socket.length < COORDINATOR_NODE_SOCKET_MAX)
        g_queue_push_tail(&node->socket, packet);
    else if (!node->running || stopped)
        network_drop(packet);
    else
        node_handle(node, packet, now_ns);
}

void coordinator_node_wake(struct coordinator_node *node, int64_t now_ns)
{
    if (!node->running || now_ns < node->stopped_until_ns)
        return;
    // After a pause the clock is often looked at before the socket: the harder case.
    if (dispatcher_wake_ns(node->dispatcher) <= now_ns) {
        struct schedule_event event = {.kind = SCHEDULE_EVENT_TICK};
        node_take(node, &event, NULL, now_ns);
    }
    struct packet *packet;
    while ((packet = g_queue_pop_head(&node->socket)) != NULL)
        node_handle(node, packet, now_ns);
}

int64_t coordinator_node_wake_ns(const struct coordinator_node *node)
{
    if (!node->running)
        return INT64_MAX;
    if (node->socket.length > 0)
        return node->stopped_until_ns;
    return MAX(dispatcher_wake_ns(node->dispatcher), node->stopped_until_ns);
}

bool coordinator_node_done(const struct coordinator_node *node)
{
    return node->running && node->done_count == node->search_count;
}

void coordinator_node_counters(const struct coordinator_node *node,
                               struct schedule_counters *counters)
{
    *counters = (struct schedule_counters){0};
    if (node->running)
        dispatcher_counters(node->dispatcher, counters);
    counters_add(counters, &node->counters);
}
