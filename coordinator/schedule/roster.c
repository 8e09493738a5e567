#include "coordinator/schedule/roster.h"

#include "common/base/pace.h"
#include "coordinator/schedule/lease.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>

enum {
    ROSTER_FORGET_SILENCES = 200, // silences after which one that is gone is forgotten: 10 minutes
                                  // at 3 s, longer than a reboot
    ROSTER_CALM_DIVISOR = 16,     // see roster_hurry()
    ROSTER_QUEUE_MAX = 65536,     // what a worker may claim to have waiting
    ROSTER_THREADS_MAX = 4096,    // and to compute with: more than any machine has
    ROSTER_LANES = 8,             // samples in a vector of doubles (AVX-512)
};

// What a rate is counted in: what one core is thought to do. Rates are integers so that the total
// is exact whatever comes and goes.
#define ROSTER_RATE_CORE 1e6

// The greatest rate of one worker, a million cores: whatever workers claim, the total fits.
#define ROSTER_RATE_MAX 1e12

// A delay below this is never too long to be taken for what it is [ns].
#define ROSTER_DELAY_LEAST_NS 1e6

// What is more than this ranks as this [ns]; stalled workers rank behind it.
#define ROSTER_LOAD_MAX (INT64_C(1) << 60)

static const bool roster_moves[ROSTER_STATE_COUNT][ROSTER_STATE_COUNT] = {
    [ROSTER_WORKING] = {[ROSTER_SILENT] = true, [ROSTER_REFUSED] = true, [ROSTER_LEFT] = true},
    [ROSTER_SILENT] = {[ROSTER_WORKING] = true, [ROSTER_REFUSED] = true, [ROSTER_LEFT] = true},
};

void roster_init(struct roster *roster, const struct schedule_settings *settings)
{
    *roster = (struct roster){.settings = settings};
    roster->workers = g_hash_table_new(g_int64_hash, g_int64_equal);
    g_queue_init(&roster->heard);
    g_queue_init(&roster->gone);
}

static void worker_free(struct roster_worker *worker)
{
    g_free(worker->leases);
    g_free(worker);
}

void roster_fini(struct roster *roster)
{
    GHashTableIter iter;
    gpointer worker;
    g_hash_table_iter_init(&iter, roster->workers);
    while (g_hash_table_iter_next(&iter, NULL, &worker))
        worker_free(worker);
    g_hash_table_destroy(roster->workers);
    heap_fini(&roster->room);
    heap_fini(&roster->idle);
    *roster = (struct roster){0};
}

struct roster_worker *roster_find(const struct roster *roster, uint64_t id)
{
    return g_hash_table_lookup(roster->workers, &id);
}

static GQueue *worker_queue(struct roster *roster, const struct roster_worker *worker)
{
    return worker->state == ROSTER_WORKING ? &roster->heard : &roster->gone;
}

bool roster_stalled(const struct roster_worker *worker)
{
    return worker->stalls >= ROSTER_STALL_COUNT;
}

double roster_service(const struct roster *roster, const struct roster_worker *worker)
{
    if (worker->service.measured)
        return worker->service.mean;
    return (roster->core.measured ? roster->core.mean : 1) / worker->threads;
}

int64_t roster_turn_ns(const struct roster *roster)
{
    return 2 * roster->settings->message_ns * (int64_t)roster->heard.length;
}

int64_t roster_target_ns(const struct roster *roster)
{
    return MAX(roster->settings->batch_target_ns, roster_turn_ns(roster));
}

// How long it will be busy with what it has: our batches, and other coordinators' as if they were
// like ours.
static double worker_load_ns(const struct roster *roster, const struct roster_worker *worker)
{
    double load_ns = (double)worker->load_ns * roster_service(roster, worker);
    double batch_ns = worker->lease_count > 0 ? load_ns / worker->lease_count : 1;
    return load_ns + batch_ns * worker->queue;
}

// Two batches hide the round trip: one in work, one waiting. More are needed only where they are
// known to be short: up to two batches' target time; or small: a vector of samples is computed by
// one thread, so two vectors for each.
static bool worker_room(const struct roster *roster, const struct roster_worker *worker)
{
    if (worker->state != ROSTER_WORKING || worker->lease_count >= roster->settings->window_max)
        return false;
    if (roster_stalled(worker))
        return worker->lease_count == 0;
    if (worker->lease_count < 2)
        return true;
    if (!worker->service.measured)
        return false;
    return worker->samples < 2 * ROSTER_LANES * worker->threads ||
           (double)worker->load_ns * worker->service.mean < 2 * (double)roster_target_ns(roster);
}

// Has nothing to do, as far as one can know. What is late would have been answered: it was lost on
// its way there or back, or the worker hangs.
static bool worker_idle(const struct roster *roster, const struct roster_worker *worker)
{
    return worker->state == ROSTER_WORKING && worker->late_count == worker->lease_count &&
           worker->lease_count < roster->settings->window_max && worker->queue == 0;
}

// Brings the worker's place and its part of the total rate up to date; after every change.
static void roster_rank(struct roster *roster, struct roster_worker *worker)
{
    roster->rate_total -= worker->rate;
    worker->rate = 0;
    if (worker->state == ROSTER_WORKING && !roster_stalled(worker))
        worker->rate =
            1 + (uint64_t)fmin(ROSTER_RATE_CORE / roster_service(roster, worker), ROSTER_RATE_MAX);
    roster->rate_total += worker->rate;

    if (worker_idle(roster, worker))
        heap_put(&roster->idle, &worker->idle_rank,
                 roster_stalled(worker) ? 2 : worker->lease_count > 0);
    else
        heap_remove(&roster->idle, &worker->idle_rank);

    if (!worker_room(roster, worker)) {
        heap_remove(&roster->room, &worker->rank);
        return;
    }
    double load_ns = fmin(worker_load_ns(roster, worker), (double)ROSTER_LOAD_MAX);
    heap_put(&roster->room, &worker->rank,
             roster_stalled(worker) ? ROSTER_LOAD_MAX + 1 : (int64_t)load_ns);
}

static void roster_remove(struct roster *roster, struct roster_worker *worker)
{
    assert(worker->state != ROSTER_WORKING);
    assert(worker->lease_count == 0);
    roster->refused -= worker->state == ROSTER_REFUSED;
    g_queue_unlink(&roster->gone, &worker->link);
    g_hash_table_remove(roster->workers, &worker->id);
    worker_free(worker);
}

// The name came from the network and goes to a terminal.
static void worker_set_name(struct roster_worker *worker, const char *name)
{
    snprintf(worker->name, sizeof worker->name, "%s", name);
    for (char *at = worker->name; *at != '\0'; at++) {
        if ((unsigned char)*at < ' ' || *at == 0x7f)
            *at = '?';
    }
}

struct roster_worker *roster_add(struct roster *roster, uint64_t id, const char *name,
                                 uint32_t threads, enum roster_state state, int64_t now_ns)
{
    assert(state == ROSTER_WORKING || state == ROSTER_REFUSED);
    if (g_hash_table_size(roster->workers) >= ROSTER_WORKER_MAX) {
        if (roster->gone.head == NULL)
            return NULL;
        roster_remove(roster, roster->gone.head->data);
    }
    struct roster_worker *worker = g_new0(struct roster_worker, 1);
    worker->id = id;
    worker_set_name(worker, name);
    worker->threads = CLAMP(threads, 1, ROSTER_THREADS_MAX);
    worker->state = state;
    worker->heard_ns = now_ns;
    worker->outcome_ns = INT64_MIN;
    worker->least_ns = roster->settings->lease_new_ns;
    worker->leases = g_new0(struct lease *, roster->settings->window_max);
    worker->rank.tie = worker->idle_rank.tie = roster->joined++;
    worker->link.data = worker;
    g_hash_table_insert(roster->workers, &worker->id, worker);
    g_queue_push_tail_link(worker_queue(roster, worker), &worker->link);
    roster->refused += state == ROSTER_REFUSED;
    roster_rank(roster, worker);
    return worker;
}

void roster_move(struct roster *roster, struct roster_worker *worker, enum roster_state state)
{
    assert(roster_moves[worker->state][state]);
    assert(worker->lease_count == 0);
    g_queue_unlink(worker_queue(roster, worker), &worker->link);
    worker->state = state;
    worker->stalls = 0;
    worker->queue = 0;
    roster->refused += state == ROSTER_REFUSED;
    g_queue_push_tail_link(worker_queue(roster, worker), &worker->link);
    roster_rank(roster, worker);
}

void roster_hear(struct roster *roster, struct roster_worker *worker, int64_t now_ns)
{
    GQueue *queue = worker_queue(roster, worker);
    g_queue_unlink(queue, &worker->link);
    g_queue_push_tail_link(queue, &worker->link);
    worker->heard_ns = now_ns;
}

void roster_queue(struct roster *roster, struct roster_worker *worker, uint32_t queue)
{
    // What is leased to it may be among what it has, or lost: only what is more is others'. To
    // remember ours too would keep it busy in our eyes when its last outcome is lost.
    const uint32_t others = queue > worker->lease_count ? queue - worker->lease_count : 0;
    worker->queue = others < ROSTER_QUEUE_MAX ? others : ROSTER_QUEUE_MAX;
    if (queue == 0)
        worker->stalls = 0;
    roster_rank(roster, worker);
}

void roster_hold(struct roster *roster, struct roster_worker *worker, struct lease *lease)
{
    assert(worker->lease_count < roster->settings->window_max);
    worker->leases[worker->lease_count++] = lease;
    worker->samples += lease->samples;
    worker->load_ns += lease->cost_ns;
    roster_rank(roster, worker);
}

void roster_drop(struct roster *roster, struct roster_worker *worker, struct lease *lease)
{
    uint32_t index = 0;
    while (worker->leases[index] != lease) {
        index++;
        assert(index < worker->lease_count);
    }
    worker->leases[index] = worker->leases[--worker->lease_count];
    worker->samples -= lease->samples;
    worker->load_ns -= lease->cost_ns;
    worker->late_count -= lease->late;
    assert(worker->lease_count > 0 || worker->load_ns == 0);
    roster_rank(roster, worker);
}

void roster_late(struct roster *roster, struct roster_worker *worker, struct lease *lease)
{
    assert(!lease->late);
    lease->late = true;
    worker->late_count++;
    roster_rank(roster, worker);
}

void roster_measure(struct roster *roster, struct roster_worker *worker, double cost_ns,
                    double service_ns, double delay_ns)
{
    double service = fmax(service_ns, 1) / cost_ns;
    estimate_add(&worker->service, service, 0);
    // The first outcome came after the scenario's text had been fetched: the second one tells more.
    if (worker->measured_count == 1 && delay_ns < worker->delay.mean)
        worker->delay = (struct estimate){0};
    estimate_add(&worker->delay, delay_ns, ROSTER_DELAY_LEAST_NS);
    if (worker->measured_count < UINT32_MAX)
        worker->measured_count++;
    estimate_add(&roster->core, service * worker->threads, 0);
    roster_rank(roster, worker);
}

static void worker_set_least(const struct roster *roster, struct roster_worker *worker,
                             int64_t least_ns)
{
    worker->least_ns =
        MAX(MIN(least_ns, roster->settings->lease_new_ns), roster->settings->lease_min_ns);
}

void roster_hurry(const struct roster *roster, struct roster_worker *worker)
{
    worker_set_least(roster, worker,
                     worker->least_ns -
                         worker->least_ns / (worker->hurried ? ROSTER_CALM_DIVISOR : 2));
}

void roster_too_soon(const struct roster *roster, struct roster_worker *worker)
{
    worker->hurried = true;
    worker_set_least(roster, worker, 2 * worker->least_ns);
}

void roster_missed(const struct roster *roster, struct roster_worker *worker,
                   const struct batch_identity *batch, uint32_t attempt)
{
    struct roster_missed *missed = &worker->missed[worker->missed_next++ % ROSTER_MISSED_MAX];
    if (missed->open)
        worker_set_least(roster, worker, worker->least_ns - worker->least_ns / 4);
    *missed = (struct roster_missed){.batch = *batch, .open = true};
    missed->batch.attempt = attempt;
}

void roster_came(const struct roster *roster, struct roster_worker *worker,
                 const struct batch_identity *batch)
{
    for (uint32_t i = 0; i < ROSTER_MISSED_MAX; i++) {
        struct roster_missed *missed = &worker->missed[i];
        if (!missed->open || missed->batch.search != batch->search ||
            missed->batch.step != batch->step || missed->batch.batch != batch->batch ||
            missed->batch.attempt != batch->attempt)
            continue;
        missed->open = false;
        roster_too_soon(roster, worker);
        return;
    }
}

void roster_answered(struct roster *roster, struct roster_worker *worker, int64_t now_ns)
{
    worker->outcome_ns = now_ns;
    worker->stalls = 0;
    roster_rank(roster, worker);
}

void roster_lapsed(struct roster *roster, struct roster_worker *worker, int64_t start_ns)
{
    if (worker->outcome_ns < start_ns)
        worker->stalls++;
    roster_rank(roster, worker);
}

static struct roster_worker *worker_of_rank(struct heap_entry *rank)
{
    return (struct roster_worker *)((char *)rank - offsetof(struct roster_worker, rank));
}

struct roster_worker *roster_pick(const struct roster *roster, const struct roster_worker *other)
{
    struct heap_entry *first = heap_first(&roster->room);
    if (first == NULL)
        return NULL;
    struct heap_entry *second = heap_second(&roster->room);
    if (worker_of_rank(first) != other || second == NULL || roster_stalled(worker_of_rank(second)))
        return worker_of_rank(first);
    return worker_of_rank(second);
}

static bool worker_holds(const struct roster_worker *worker, const struct backlog_batch *batch)
{
    for (uint32_t i = 0; i < worker->lease_count; i++) {
        if (worker->leases[i]->batch == batch)
            return true;
    }
    return false;
}

struct roster_worker *roster_idle(const struct roster *roster, const struct backlog_batch *batch)
{
    struct heap_entry *const ranks[] = {heap_first(&roster->idle), heap_second(&roster->idle)};
    for (size_t i = 0; i < 2 && ranks[i] != NULL; i++) {
        struct roster_worker *worker =
            (struct roster_worker *)((char *)ranks[i] - offsetof(struct roster_worker, idle_rank));
        if (!worker_holds(worker, batch))
            return worker;
    }
    return NULL;
}

struct roster_worker *roster_silent(const struct roster *roster, int64_t now_ns)
{
    return roster_wake_ns(roster) <= now_ns ? roster->heard.head->data : NULL;
}

int64_t roster_silence_ns(const struct roster *roster)
{
    return roster->settings->silence_ns * pace_most(roster->heard.length);
}

int64_t roster_wake_ns(const struct roster *roster)
{
    if (roster->heard.head == NULL)
        return INT64_MAX;
    const struct roster_worker *worker = roster->heard.head->data;
    return worker->heard_ns + roster_silence_ns(roster);
}

void roster_forget(struct roster *roster, int64_t now_ns)
{
    int64_t forget_ns = ROSTER_FORGET_SILENCES * roster->settings->silence_ns;
    while (roster->gone.head != NULL) {
        struct roster_worker *worker = roster->gone.head->data;
        if (now_ns - worker->heard_ns < forget_ns)
            return;
        roster_remove(roster, worker);
    }
}
