#include "tests/cluster/worker_node.h"

#include "tests/cluster/trace.h"

#include <glib.h>
#include <stdio.h>
#include <string.h>

#define STATUS_INTERVAL_NS INT64_C(1000000000)

enum { WORKER_NODE_BOUND_MAX = 256 }; // of a box that travels with its batch

static const char *node_name(const struct worker_node *node)
{
    static char name[16];
    snprintf(name, sizeof name, "worker %u", node->place);
    return name;
}

void worker_node_init(struct worker_node *node, struct network *network, struct dice *dice,
                      uint32_t place)
{
    *node = (struct worker_node){
        .network = network,
        .dice = dice,
        .place = place,
        .threads = 1,
        .slowness = 1,
        .stopped_until_ns = INT64_MIN,
        .stuck_until_ns = INT64_MIN,
    };
    g_queue_init(&node->socket);
}

static void node_announce(struct worker_node *node, bool leaving, int64_t now_ns)
{
    struct message message = {
        .kind = MESSAGE_WORKER,
        .sender = node->sender,
        .worker = {.threads = node->threads,
                   .queue = intake_queue(node->intake),
                   .leaving = leaving,
                   .acceptable = !node->wrong_version},
    };
    network_send(node->network, node->place, 0, &message, now_ns);
}

void worker_node_start(struct worker_node *node, int64_t now_ns)
{
    if (node->running)
        return;
    node->running = true;
    node->sender = dice_sender(node->dice);
    node->intake = intake_create();
    node->busy = false;
    node->stopped_until_ns = node->stuck_until_ns = INT64_MIN;
    node->slowness = 1;
    node->status_ns = now_ns + STATUS_INTERVAL_NS;
    trace_line(now_ns, node_name(node), "starts as %016llx", (unsigned long long)node->sender);
    node_announce(node, false, now_ns);
}

void worker_node_kill(struct worker_node *node)
{
    if (!node->running)
        return;
    node->running = false;
    intake_free(node->intake);
    node->intake = NULL;
    struct packet *packet;
    while ((packet = g_queue_pop_head(&node->socket)) != NULL)
        network_drop(packet);
}

void worker_node_leave(struct worker_node *node, int64_t now_ns)
{
    if (!node->running)
        return;
    node_announce(node, true, now_ns);
    worker_node_kill(node);
}

void worker_node_fini(struct worker_node *node)
{
    worker_node_kill(node);
}

static void node_take_batch(struct worker_node *node, const struct message *message, int64_t now_ns)
{
    if (message->batch.holder != node->sender)
        return;
    TRACE_CHECK(now_ns, !node->wrong_version);
    struct intake_batch batch = {
        .run = message->run,
        .coordinator = message->sender,
        .scenario = message->batch.scenario,
        .box = message->batch.box,
        .identity = message->batch.identity,
        .sampling = message->batch.sampling,
        .detail = message->batch.detail,
        .variables = message->batch.variables,
        .text = message->payload,
        .text_size = message->payload_size,
    };
    struct error error;
    enum status status = intake_batch(node->intake, &batch, now_ns, &error);
    // A full queue may happen; a batch that is wrong may not.
    if (status != STATUS_OK && status != STATUS_REFUSED)
        trace_fail(now_ns, "%s: %s", node_name(node), error.text);
}

static void node_take_text(struct worker_node *node, const struct message *message, int64_t now_ns)
{
    struct error error;
    if (intake_text(node->intake, &message->text.digest, message->text.total, message->text.offset,
                    message->payload, message->payload_size, now_ns, &error) != STATUS_OK)
        trace_fail(now_ns, "%s: %s", node_name(node), error.text);
}

static void node_request(struct worker_node *node, int64_t now_ns)
{
    struct intake_request request;
    while (intake_request(node->intake, now_ns, &request)) {
        struct message message = {
            .kind = MESSAGE_TEXT_REQUEST,
            .sender = node->sender,
            .run = request.run,
            .request = {.digest = request.digest, .offset = request.offset},
        };
        network_send(node->network, node->place, 0, &message, now_ns);
    }
}

// Starts the next evaluation when there is one.
static void node_work(struct worker_node *node, int64_t now_ns)
{
    if (node->busy || !intake_take(node->intake, &node->work))
        return;
    node->busy = true;
    node->work_start_ns = now_ns;
    double noise = 0.9 + 0.2 * dice_unit(node->dice);
    double duration_ns =
        node->overhead_ns + node->sample_ns * node->work.batch.identity.count / node->threads;
    node->work_end_ns = now_ns + 1 + (int64_t)(duration_ns * node->slowness * noise);
    if (node->work_end_ns < node->stuck_until_ns)
        node->work_end_ns = node->stuck_until_ns;
}

static void node_finish(struct worker_node *node, int64_t now_ns)
{
    const struct intake_work *work = &node->work;
    const struct intake_batch *batch = &work->batch;
    const struct batch samples = intake_samples(batch);
    const uint32_t count = batch->identity.count;
    struct verdict *verdicts = g_new(struct verdict, count);
    batch_evaluate(work->scenario, work->model, work->box, &samples, 1, verdicts);
    uint8_t *packed = g_malloc(verdict_packed_size_max(count, batch->detail));
    size_t size = verdict_pack(verdicts, count, batch->detail, packed);
    struct message message = {
        .kind = MESSAGE_OUTCOME,
        .sender = node->sender,
        .run = batch->run,
        .outcome = {.identity = batch->identity,
                    .detail = batch->detail,
                    .service_ns = now_ns - node->work_start_ns},
        .payload = packed,
        .payload_size = (uint32_t)size,
    };
    intake_done(node->intake, work);
    node->busy = false;
    node->evaluated += count;
    message.outcome.queue = intake_queue(node->intake);
    network_send(node->network, node->place, 0, &message, now_ns);
    g_free(packed);
    g_free(verdicts);
}

static void node_handle(struct worker_node *node, struct packet *packet, int64_t now_ns)
{
    if (packet->message.kind == MESSAGE_BATCH)
        node_take_batch(node, &packet->message, now_ns);
    else if (packet->message.kind == MESSAGE_TEXT)
        node_take_text(node, &packet->message, now_ns);
    network_drop(packet);
    uint32_t queue = intake_queue(node->intake);
    TRACE_CHECK(now_ns, queue <= INTAKE_QUEUE_MAX);
    if (queue > node->queue_most)
        node->queue_most = queue;
}

void worker_node_receive(struct worker_node *node, struct packet *packet, int64_t now_ns)
{
    bool stopped = node->running && now_ns < node->stopped_until_ns;
    if (stopped && node->socket.length < WORKER_NODE_SOCKET_MAX) {
        g_queue_push_tail(&node->socket, packet);
    } else if (!node->running || stopped) {
        network_drop(packet);
    } else {
        node_handle(node, packet, now_ns);
        worker_node_wake(node, now_ns);
    }
}

void worker_node_wake(struct worker_node *node, int64_t now_ns)
{
    if (!node->running || now_ns < node->stopped_until_ns)
        return;
    struct packet *packet;
    while ((packet = g_queue_pop_head(&node->socket)) != NULL)
        node_handle(node, packet, now_ns);
    if (node->busy && node->work_end_ns <= now_ns)
        node_finish(node, now_ns);
    node_request(node, now_ns);
    node_work(node, now_ns);
    if (node->status_ns <= now_ns) {
        node->status_ns = now_ns + STATUS_INTERVAL_NS;
        node_announce(node, false, now_ns);
    }
}

int64_t worker_node_wake_ns(const struct worker_node *node)
{
    if (!node->running)
        return INT64_MAX;
    int64_t wake_ns = node->status_ns;
    if (node->busy)
        wake_ns = MIN(wake_ns, node->work_end_ns);
    wake_ns = MIN(wake_ns, intake_wake_ns(node->intake));
    return MAX(wake_ns, node->stopped_until_ns);
}
