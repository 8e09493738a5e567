#include "tests/bench/scale/centre.h"

#include "worker/batch/batch.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

enum job_kind { JOB_PACKET, JOB_TRIMMED, JOB_OPENING };

// Something for the loop to do.
struct job {
    enum job_kind kind;
    struct packet *packet;         // JOB_PACKET
    struct centre_search *trimmed; // JOB_TRIMMED
    struct heap_entry ready;
};

#define TICK_NS 1000.0 // a timer that rings

static uint32_t index_of(const struct centre *centre, const struct centre_search *search)
{
    return (uint32_t)(search - centre->searches);
}

static struct job *job_of(struct heap_entry *ready)
{
    return (struct job *)((char *)ready - offsetof(struct job, ready));
}

static struct job *job_add(struct centre *centre, enum job_kind kind, int64_t ready_ns)
{
    struct job *job = g_new0(struct job, 1);
    job->kind = kind;
    job->ready.tie = centre->job_count++;
    heap_put(&centre->jobs, &job->ready, ready_ns);
    return job;
}

// The loop is busy for so much longer.
static void loop_work(struct centre *centre, double ns)
{
    centre->loop_ns += (int64_t)ns;
    centre->busy.loop += ns;
}

// ---- Trimming threads ----

static double trim_ns(const struct centre *centre, const struct centre_search *search)
{
    return centre->costs->trim_ns +
           search->request.sampling.samples * centre->costs->trim_sample_ns;
}

static void trim_start(struct centre *centre, struct centre_search *search, int64_t now_ns)
{
    const double duration_ns = trim_ns(centre, search);
    centre->trimming++;
    centre->busy.trim += duration_ns;
    heap_put(&centre->trims_due, &search->trim, now_ns + (int64_t)duration_ns);
}

static void trim_take(struct centre *centre, struct centre_search *search)
{
    centre->trims++;
    if (centre->trimming < centre->trimmers)
        trim_start(centre, search, centre->loop_ns);
    else
        g_queue_push_tail(&centre->trims_waiting, search);
}

static void trim_end(struct centre *centre, struct centre_search *search, int64_t now_ns)
{
    centre->trimming--;
    job_add(centre, JOB_TRIMMED, now_ns)->trimmed = search;
    struct centre_search *next = g_queue_pop_head(&centre->trims_waiting);
    if (next != NULL)
        trim_start(centre, next, now_ns);
}

// ---- What the dispatcher asks ----

static void send_batch(void *user, uint64_t worker, const struct batch_identity *batch)
{
    struct centre *centre = user;
    loop_work(centre, centre->costs->send_ns);
    const struct message message = {
        .kind = MESSAGE_BATCH,
        .batch = {.holder = worker,
                  .identity = *batch,
                  .detail = centre->searches[batch->search].request.detail},
    };
    centre->fleet->told++;
    network_send(centre->network, 0, GPOINTER_TO_UINT(g_hash_table_lookup(centre->places, &worker)),
                 &message, centre->loop_ns);
}

static void count_batch(void *user, const struct batch_identity *batch)
{
    ((struct centre *)user)->samples += batch->count;
}

static void step_sampled(void *user, uint32_t search, uint32_t step)
{
    (void)step;
    struct centre *centre = user;
    trim_take(centre, &centre->searches[search]);
}

static void note(void *user, const char *text)
{
    (void)user;
    (void)text;
}

// No worker asks for a text here, so there is no piece to send.
static const struct dispatcher_calls calls = {
    .send = send_batch,
    .count = count_batch,
    .finished = step_sampled,
    .note = note,
};

// ---- The loop ----

static void take(struct centre *centre, struct schedule_event *event)
{
    event->now_ns = centre->loop_ns;
    dispatcher_take(centre->dispatcher, event);
}

// Wants the search's next step sampled; a search that is done leaves.
static void go_on(struct centre *centre, struct centre_search *search)
{
    if (!search_request(search->search, &search->request)) {
        search_free(search->search);
        search->search = NULL;
        centre->done_count++;
        opening_close(&centre->opening, centre->scenario);
        return;
    }
    take(centre, &(struct schedule_event){.kind = SCHEDULE_EVENT_STEP,
                                          .step = {.search = index_of(centre, search),
                                                   .step = search->request.sampling.step,
                                                   .samples = search->request.sampling.samples,
                                                   .detail = search->request.detail}});
}

// What workers would have said.
static void complete(const struct centre *centre, struct centre_search *search)
{
    const struct search_request *request = &search->request;
    const uint32_t count = request->sampling.samples;
    const struct batch batch = {
        .sampling = request->sampling, .count = count, .detail = request->detail};
    struct verdict *verdicts = g_new(struct verdict, count);
    batch_evaluate(centre->scenario, centre->model, request->box, &batch, 1, verdicts);
    for (uint32_t i = 0; request->detail == VERDICT_DETAIL_SHARE && i < count; i++)
        verdicts[i] = (struct verdict){.violation = verdicts[i].violation != VERDICT_GOOD};
    search_complete(search->search, verdicts);
    g_free(verdicts);
}

static void do_trimmed(struct centre *centre, struct centre_search *search)
{
    centre->trims--;
    loop_work(centre, centre->costs->record_ns +
                          search->request.sampling.samples * centre->costs->record_sample_ns);
    complete(centre, search);
    go_on(centre, search);
}

static void do_opening(struct centre *centre)
{
    struct centre_search *search = &centre->searches[centre->search_next++];
    centre->opening_due = false;
    loop_work(centre, centre->costs->open_ns);
    opening_open(&centre->opening, centre->scenario);
    search->trim.tie = index_of(centre, search);
    search->search = search_create(centre->scenario, 1 + index_of(centre, search), 1);
    go_on(centre, search);
}

static void do_packet(struct centre *centre, struct packet *packet)
{
    const struct message *message = &packet->message;
    loop_work(centre, centre->costs->take_ns);
    struct schedule_event event;
    if (message->kind == MESSAGE_OUTCOME) {
        loop_work(centre, message->outcome.identity.count * centre->costs->verdict_ns);
        event = (struct schedule_event){.kind = SCHEDULE_EVENT_OUTCOME,
                                        .outcome = {.worker = message->sender,
                                                    .batch = message->outcome.identity,
                                                    .queue = message->outcome.queue,
                                                    .service_ns = message->outcome.service_ns}};
    } else {
        event = (struct schedule_event){.kind = SCHEDULE_EVENT_WORKER,
                                        .worker = {.id = message->sender,
                                                   .threads = message->worker.threads,
                                                   .queue = message->worker.queue,
                                                   .acceptable = true}};
    }
    take(centre, &event);
    network_drop(packet);
}

static void do_job(struct centre *centre, struct job *job)
{
    switch (job->kind) {
    case JOB_PACKET:
        do_packet(centre, job->packet);
        break;
    case JOB_TRIMMED:
        do_trimmed(centre, job->trimmed);
        break;
    case JOB_OPENING:
        do_opening(centre);
        break;
    }
    g_free(job);
}

static void open_when_hungry(struct centre *centre)
{
    struct schedule_counters counters;
    dispatcher_counters(centre->dispatcher, &counters);
    if (centre->opening_due || centre->search_next == centre->search_count ||
        !opening_wanted(&centre->opening, &counters, (double)centre->trims / centre->trimmers))
        return;
    centre->opening_due = true;
    job_add(centre, JOB_OPENING, centre->loop_ns);
}

// ---- Time ----

// A bit a sample, and three bytes for each that is bad: a third of them.
static double outcome_size(const struct message *message)
{
    const double count = message->outcome.identity.count;
    return 150 + count / 8 + (message->outcome.detail == VERDICT_DETAIL_FULL ? count : 0);
}

void centre_receive(struct centre *centre, struct packet *packet, int64_t now_ns)
{
    const struct message *message = &packet->message;
    const double size = message->kind == MESSAGE_OUTCOME ? outcome_size(message) : 300;
    const double work_ns = centre->costs->listen_ns + size * centre->costs->byte_ns;
    centre->busy.listen += work_ns;
    centre->listen_ns = MAX(centre->listen_ns, now_ns) + (int64_t)work_ns;
    job_add(centre, JOB_PACKET, centre->listen_ns)->packet = packet;
}

static int64_t loop_wake_ns(const struct centre *centre)
{
    const struct heap_entry *first = heap_first(&centre->jobs);
    int64_t wake_ns = dispatcher_wake_ns(centre->dispatcher);
    if (first != NULL)
        wake_ns = MIN(wake_ns, first->key);
    if (centre->search_next == 0)
        wake_ns = 0;
    return wake_ns == INT64_MAX ? INT64_MAX : MAX(wake_ns, centre->loop_ns);
}

int64_t centre_wake_ns(const struct centre *centre)
{
    const struct heap_entry *trim = heap_first(&centre->trims_due);
    const int64_t wake_ns = loop_wake_ns(centre);
    return trim != NULL ? MIN(wake_ns, trim->key) : wake_ns;
}

void centre_wake(struct centre *centre, int64_t now_ns)
{
    struct heap_entry *first;
    while ((first = heap_first(&centre->trims_due)) != NULL && first->key <= now_ns) {
        heap_remove(&centre->trims_due, first);
        trim_end(centre,
                 (struct centre_search *)((char *)first - offsetof(struct centre_search, trim)),
                 now_ns);
    }
    if (loop_wake_ns(centre) > now_ns)
        return;
    centre->loop_ns = now_ns;
    if (dispatcher_wake_ns(centre->dispatcher) <= now_ns) {
        loop_work(centre, TICK_NS);
        take(centre, &(struct schedule_event){.kind = SCHEDULE_EVENT_TICK});
    }
    first = heap_first(&centre->jobs);
    if (first != NULL && first->key <= now_ns) {
        heap_remove(&centre->jobs, first);
        do_job(centre, job_of(first));
    }
    open_when_hungry(centre);
}

// ---- Life ----

void centre_init(struct centre *centre, const struct costs *costs, const struct scenario *scenario,
                 const struct schedule_settings *settings, uint32_t search_count, uint32_t trimmers,
                 struct network *network, struct fleet *fleet)
{
    *centre = (struct centre){
        .costs = costs,
        .scenario = scenario,
        .model = model_create(scenario),
        .network = network,
        .fleet = fleet,
        .places = g_hash_table_new(g_int64_hash, g_int64_equal),
        .dispatcher = dispatcher_create(settings, 1, &calls, centre),
        .opening = opening_default(),
        .searches = g_new0(struct centre_search, search_count),
        .search_count = search_count,
        .trimmers = trimmers,
    };
    g_queue_init(&centre->trims_waiting);
    for (uint32_t i = 0; i < fleet->count; i++)
        g_hash_table_insert(centre->places, &fleet->workers[i].sender,
                            GUINT_TO_POINTER(fleet->workers[i].place));
}

void centre_fini(struct centre *centre)
{
    struct heap_entry *first;
    while ((first = heap_first(&centre->jobs)) != NULL) {
        struct job *job = job_of(first);
        heap_remove(&centre->jobs, first);
        if (job->kind == JOB_PACKET)
            network_drop(job->packet);
        g_free(job);
    }
    for (uint32_t i = 0; i < centre->search_count; i++)
        search_free(centre->searches[i].search);
    g_free(centre->searches);
    g_queue_clear(&centre->trims_waiting);
    heap_fini(&centre->jobs);
    heap_fini(&centre->trims_due);
    dispatcher_free(centre->dispatcher);
    g_hash_table_destroy(centre->places);
    model_free(centre->model);
}
