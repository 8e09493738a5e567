#include "tests/bench/scale/fleet.h"

#include <math.h>
#include <stddef.h>

// A new coordinator is greeted within this time, then each second (worker/runtime README).
#define GREETING_NS INT64_C(20000000)
#define STATUS_NS INT64_C(1000000000)

enum { LANES = 8 }; // samples that a core computes at once

void fleet_init(struct fleet *fleet, const struct costs *costs, struct network *network,
                struct dice *dice, uint32_t count, uint32_t threads)
{
    *fleet = (struct fleet){
        .costs = costs,
        .network = network,
        .dice = dice,
        .count = count,
        .threads = threads,
        .workers = g_new0(struct fleet_worker, count),
        .status_every_ns = GREETING_NS / count,
    };
    for (uint32_t i = 0; i < count; i++) {
        struct fleet_worker *worker = &fleet->workers[i];
        worker->sender = dice_sender(dice);
        worker->place = i + 1;
        worker->due.tie = i;
    }
}

void fleet_fini(struct fleet *fleet)
{
    for (uint32_t i = 0; i < fleet->count; i++) {
        struct fleet_worker *worker = &fleet->workers[i];
        struct packet *packet;
        while ((packet = g_queue_pop_head(&worker->queue)) != NULL)
            network_drop(packet);
        g_queue_clear_full(&worker->answers, g_free);
    }
    heap_fini(&fleet->due);
    g_free(fleet->workers);
}

static void worker_set_due(struct fleet *fleet, struct fleet_worker *worker)
{
    const int64_t *first = g_queue_peek_head(&worker->answers);
    if (first != NULL)
        heap_put(&fleet->due, &worker->due, *first);
    else
        heap_remove(&fleet->due, &worker->due);
}

// What a batch takes one core, a little more or less.
static double work_ns(const struct fleet *fleet, uint32_t samples)
{
    return samples * fleet->costs->sample_ns * (0.95 + 0.1 * dice_unit(fleet->dice));
}

void fleet_receive(struct fleet *fleet, struct packet *packet, int64_t now_ns)
{
    struct fleet_worker *worker = &fleet->workers[packet->to - 1];
    const uint32_t samples = packet->message.batch.identity.count;
    // The message thread goes before the computing ones, and all cores make up for it.
    const double heard_ns =
        (double)(fleet->told - worker->heard) * fleet->costs->hear_ns / fleet->threads;
    worker->heard = fleet->told;
    const int64_t begin_ns = MAX(worker->free_ns, now_ns + (int64_t)fleet->costs->answer_ns / 2);
    worker->free_ns = begin_ns + (int64_t)(heard_ns + work_ns(fleet, samples) / fleet->threads) + 1;
    // A core computes a whole vector of samples, so a batch takes as long as one at least.
    const int64_t part_ns = (int64_t)(MIN(samples, LANES) * fleet->costs->sample_ns);
    const int64_t done_ns = MAX(worker->free_ns, begin_ns + part_ns);
    worker->answer_ns = MAX(worker->answer_ns, done_ns + (int64_t)fleet->costs->answer_ns / 2);
    g_queue_push_tail(&worker->queue, packet);
    g_queue_push_tail(&worker->answers, g_memdup2(&worker->answer_ns, sizeof worker->answer_ns));
    worker_set_due(fleet, worker);
}

static void worker_answer(struct fleet *fleet, struct fleet_worker *worker, int64_t now_ns)
{
    struct packet *packet = g_queue_pop_head(&worker->queue);
    g_free(g_queue_pop_head(&worker->answers));
    worker_set_due(fleet, worker);
    const struct message *batch = &packet->message;
    const double share_ns = batch->batch.identity.count * fleet->costs->sample_ns / fleet->threads;
    const struct message outcome = {
        .kind = MESSAGE_OUTCOME,
        .sender = worker->sender,
        .outcome = {.identity = batch->batch.identity,
                    .detail = batch->batch.detail,
                    .queue = worker->queue.length,
                    .service_ns = (int64_t)share_ns + 1},
    };
    network_send(fleet->network, worker->place, 0, &outcome, now_ns);
    network_drop(packet);
}

static void announce(struct fleet *fleet, int64_t now_ns)
{
    const struct fleet_worker *worker = &fleet->workers[fleet->status_next];
    const struct message status = {
        .kind = MESSAGE_WORKER,
        .sender = worker->sender,
        .worker = {.threads = fleet->threads, .queue = worker->queue.length, .acceptable = true},
    };
    fleet->told++;
    network_send(fleet->network, worker->place, 0, &status, now_ns);
    fleet->status_next = (fleet->status_next + 1) % fleet->count;
    if (fleet->status_next == 0)
        fleet->status_every_ns = STATUS_NS / fleet->count;
    fleet->status_ns += fleet->status_every_ns;
}

void fleet_wake(struct fleet *fleet, int64_t now_ns)
{
    while (fleet->status_ns <= now_ns)
        announce(fleet, now_ns);
    struct heap_entry *first;
    while ((first = heap_first(&fleet->due)) != NULL && first->key <= now_ns) {
        struct fleet_worker *worker =
            (struct fleet_worker *)((char *)first - offsetof(struct fleet_worker, due));
        worker_answer(fleet, worker, now_ns);
    }
}

int64_t fleet_wake_ns(const struct fleet *fleet)
{
    const struct heap_entry *first = heap_first(&fleet->due);
    return first != NULL ? MIN(first->key, fleet->status_ns) : fleet->status_ns;
}
