#include "worker/runtime/engine.h"

#include "common/base/clock.h"

#include <assert.h>
#include <errno.h>
#include <glib.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

enum {
    // Samples are claimed in whole vectors: the model takes as long for one as for eight.
    CLAIM_LANES = 8,
    // What a claim should be worth [ns], if so much waits: the lock that all threads share is then
    // taken by 64 of them every microsecond, and is held for a twentieth of that.
    CLAIM_WORTH_NS = 64000,
    // What it must be worth: to wake another thread takes some 5 us.
    CLAIM_LEAST_NS = 5000,
    // Work for each thread that makes jobs wait elsewhere [ns]: how long the message thread may be
    // kept waiting on its own machine, short beside a person's patience and a lease.
    HUNGER_NS = 1000000,
    // Jobs that wait for the threads whatever they are worth: one is begun while the next comes.
    HUNGER_JOBS = 2,
};

// POSIX locks and not GLib's, because the thread sanitizer knows only the former.
struct engine {
    pthread_t thread; // the team's first
    bool running;
    int threads;
    int priority;
    int descriptor; // eventfd: results wait

    pthread_mutex_t lock; // guards what follows, and what jobs say of their progress
    pthread_cond_t work;  // samples wait, or the threads shall end
    GQueue jobs;          // with samples that nobody has claimed
    GQueue results;
    uint64_t waiting;  // samples of `jobs` that nobody has claimed
    double sample_ns;  // what a sample took a thread lately; 0: not known yet
    uint32_t sleeping; // threads that wait for work
    bool ending;
};

// A part of a job, in the hands of one thread.
struct claim {
    struct engine_job *job; // NULL: nothing is
    uint32_t begin;
    uint32_t count;
    uint32_t non_finite;
    int64_t busy_ns;
};

void engine_job_free(struct engine_job *job)
{
    if (job == NULL)
        return;
    g_free(job->verdicts);
    g_free(job->packed);
    g_free(job->outcomes);
    g_free(job);
}

// ---- The computing threads ----

// A thread that may not lower its priority works all the same.
static void lower_priority(int priority)
{
    const id_t self = (id_t)gettid();
    setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + priority);
}

// How many samples of `left` a thread takes: its part of all that waits, that all may have one, but
// neither more nor less than is worth a claim.
static uint32_t claim_count(const struct engine *engine, uint32_t left)
{
    double count = ceil((double)engine->waiting / engine->threads);
    if (engine->sample_ns > 0)
        // A block that is not whole costs its random numbers all the same.
        count = fmin(fmax(count, CLAIM_LEAST_NS / engine->sample_ns),
                     fmax(CLAIM_WORTH_NS / engine->sample_ns, MODEL_BLOCK));
    else
        count = fmin(count, MODEL_BLOCK);
    if (count * 1.25 >= left)
        return left;
    // Whole blocks of the model where there are several, else whole vectors.
    const uint32_t step = count >= MODEL_BLOCK ? MODEL_BLOCK : CLAIM_LANES;
    return MIN(left, MAX((uint32_t)count / step * step, CLAIM_LANES));
}

// Takes the next samples of the job that waits for longest. The caller holds the lock.
static void claim_take(struct engine *engine, struct claim *claim)
{
    struct engine_job *job = g_queue_peek_head(&engine->jobs);
    const uint32_t left = job->work.batch.identity.count - job->claimed;
    *claim = (struct claim){.job = job, .begin = job->claimed, .count = claim_count(engine, left)};
    job->claimed += claim->count;
    engine->waiting -= claim->count;
    if (claim->count == left)
        g_queue_pop_head(&engine->jobs);
}

// Adds what was done to its job. The caller holds the lock. True when the job is done.
static bool claim_settle(struct engine *engine, const struct claim *claim)
{
    struct engine_job *job = claim->job;
    job->done += claim->count;
    job->non_finite += claim->non_finite;
    job->busy_ns += claim->busy_ns;
    const double sample_ns = (double)MAX(claim->busy_ns, 1) / claim->count;
    engine->sample_ns += (sample_ns - engine->sample_ns) / (engine->sample_ns > 0 ? 8 : 1);
    return job->done == job->work.batch.identity.count;
}

// Puts the result into the form in which it travels.
static void finish(const struct engine *engine, struct engine_job *job)
{
    if (job->verdicts != NULL) {
        const uint32_t count = job->work.batch.identity.count;
        const enum verdict_detail detail = job->work.batch.detail;
        const int64_t start_ns = clock_monotonic_ns();
        job->packed = g_malloc(verdict_packed_size_max(count, detail));
        job->packed_size = verdict_pack(job->verdicts, count, detail, job->packed);
        job->busy_ns += clock_monotonic_ns() - start_ns;
    }
    job->service_ns = job->busy_ns / engine->threads;
}

// Only the first of several results that wait has to wake the main loop.
static void give_result(struct engine *engine, struct engine_job *job)
{
    finish(engine, job);
    pthread_mutex_lock(&engine->lock);
    bool wake = g_queue_is_empty(&engine->results);
    g_queue_push_tail(&engine->results, job);
    pthread_mutex_unlock(&engine->lock);
    if (wake)
        eventfd_write(engine->descriptor, 1);
}

// What is left to do once the engine is to end: jobs that were begun.
static bool work_waits(const struct engine *engine)
{
    const struct engine_job *job = engine->jobs.head != NULL ? engine->jobs.head->data : NULL;
    return job != NULL && (!engine->ending || job->claimed > 0);
}

// Hands in what the thread has done, if anything, then waits for work and takes a part of it; false
// when there will be none. One thread wakes the next: to wake all at once for every small batch
// would cost more than the batch.
static bool claim_next(struct engine *engine, struct claim *claim)
{
    pthread_mutex_lock(&engine->lock);
    if (claim->job != NULL && claim_settle(engine, claim)) {
        pthread_mutex_unlock(&engine->lock);
        give_result(engine, claim->job);
        pthread_mutex_lock(&engine->lock);
    }
    while (!work_waits(engine) && !engine->ending) {
        engine->sleeping++;
        pthread_cond_wait(&engine->work, &engine->lock);
        engine->sleeping--;
    }
    const bool found = work_waits(engine);
    if (found)
        claim_take(engine, claim);
    const bool wake = engine->sleeping > 0 && work_waits(engine);
    pthread_mutex_unlock(&engine->lock);
    if (wake)
        pthread_cond_signal(&engine->work);
    return found;
}

static void evaluate_samples(struct claim *claim, struct batch_scratch *scratch)
{
    const struct intake_work *work = &claim->job->work;
    const struct batch samples = intake_samples(&work->batch);
    claim->non_finite =
        batch_evaluate_part(work->scenario, work->model, work->box, &samples, claim->begin,
                            claim->count, scratch, claim->job->verdicts);
}

static void evaluate_designs(const struct claim *claim, struct batch_scratch *scratch)
{
    const struct intake_work *work = &claim->job->work;
    const size_t variables = model_variable_count(work->model);
    const size_t outcomes = model_outcome_count(work->model);
    batch_evaluate_designs(work->model, work->batch.designs + claim->begin * variables,
                           claim->count, scratch, claim->job->outcomes + claim->begin * outcomes);
}

static void claim_evaluate(struct claim *claim, struct batch_scratch *scratch)
{
    const int64_t start_ns = clock_monotonic_ns();
    if (claim->job->work.batch.designs != NULL)
        evaluate_designs(claim, scratch);
    else
        evaluate_samples(claim, scratch);
    claim->busy_ns = clock_monotonic_ns() - start_ns;
}

static void thread_work(struct engine *engine)
{
    struct batch_scratch scratch = {0};
    struct claim claim = {0};
    while (claim_next(engine, &claim))
        claim_evaluate(&claim, &scratch);
    batch_scratch_fini(&scratch);
}

// The team stays together from the first job to the last. Its threads are started by this one and
// inherit its priority.
static void *compute(void *user)
{
    struct engine *engine = user;
    lower_priority(engine->priority);
#pragma omp parallel num_threads(engine->threads) if (engine->threads > 1)
    thread_work(engine);
    return NULL;
}

// ---- The message thread's side ----

// Signals are the message thread's: the new thread inherits a mask that blocks them all.
static int thread_start(struct engine *engine)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int failed = pthread_create(&engine->thread, NULL, compute, engine);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return failed;
}

enum status engine_create(struct engine **created, int threads, int priority, struct error *error)
{
    assert(threads > 0);
    *created = NULL;
    int descriptor = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (descriptor < 0)
        return error_set(error, STATUS_FAILED, "no event descriptor: %s", strerror(errno));
    struct engine *engine = g_new0(struct engine, 1);
    engine->threads = threads;
    engine->priority = priority;
    engine->descriptor = descriptor;
    g_queue_init(&engine->jobs);
    g_queue_init(&engine->results);
    pthread_mutex_init(&engine->lock, NULL);
    pthread_cond_init(&engine->work, NULL);
    int failed = thread_start(engine);
    if (failed != 0) {
        engine_free(engine);
        return error_set(error, STATUS_FAILED, "no computing thread: %s", strerror(failed));
    }
    engine->running = true;
    *created = engine;
    return STATUS_OK;
}

void engine_stop(struct engine *engine)
{
    if (!engine->running)
        return;
    pthread_mutex_lock(&engine->lock);
    engine->ending = true;
    pthread_cond_broadcast(&engine->work);
    pthread_mutex_unlock(&engine->lock);
    pthread_join(engine->thread, NULL);
    engine->running = false;
}

static void drop_jobs(GQueue *jobs)
{
    struct engine_job *job;
    while ((job = g_queue_pop_head(jobs)) != NULL)
        engine_job_free(job);
}

void engine_free(struct engine *engine)
{
    if (engine == NULL)
        return;
    engine_stop(engine);
    drop_jobs(&engine->jobs);
    drop_jobs(&engine->results);
    pthread_cond_destroy(&engine->work);
    pthread_mutex_destroy(&engine->lock);
    close(engine->descriptor);
    g_free(engine);
}

void engine_submit(struct engine *engine, struct engine_job *job)
{
    const uint32_t count = job->work.batch.identity.count;
    if (job->work.batch.designs != NULL) {
        job->outcome_count = (size_t)count * model_outcome_count(job->work.model);
        job->outcomes = g_new(double, job->outcome_count);
    } else {
        job->verdicts = g_new(struct verdict, count);
    }
    pthread_mutex_lock(&engine->lock);
    g_queue_push_tail(&engine->jobs, job);
    engine->waiting += count;
    const bool wake = engine->sleeping > 0;
    pthread_mutex_unlock(&engine->lock);
    if (wake)
        pthread_cond_signal(&engine->work);
}

bool engine_hungry(struct engine *engine)
{
    pthread_mutex_lock(&engine->lock);
    const double waiting_ns = (double)engine->waiting * engine->sample_ns;
    const bool hungry = g_queue_get_length(&engine->jobs) < HUNGER_JOBS ||
                        waiting_ns < (double)HUNGER_NS * engine->threads;
    pthread_mutex_unlock(&engine->lock);
    return hungry;
}

struct engine_job *engine_collect(struct engine *engine)
{
    pthread_mutex_lock(&engine->lock);
    struct engine_job *job = g_queue_pop_head(&engine->results);
    pthread_mutex_unlock(&engine->lock);
    return job;
}

int engine_descriptor(const struct engine *engine)
{
    return engine->descriptor;
}

void engine_acknowledge(struct engine *engine)
{
    eventfd_t ignored;
    eventfd_read(engine->descriptor, &ignored);
}
