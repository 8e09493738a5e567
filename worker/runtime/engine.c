#include "worker/runtime/engine.h"

#include "common/base/clock.h"

#include <assert.h>
#include <errno.h>
#include <glib.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

// POSIX locks and not GLib's, because the thread sanitizer knows only the former.
struct engine {
    pthread_t thread;
    bool running;
    int threads;
    int priority;
    int descriptor; // eventfd: results wait

    pthread_mutex_t lock; // guards what follows
    pthread_cond_t work;  // jobs wait, or the thread shall end
    GQueue jobs;
    GQueue results;
    bool ending;
};

void engine_job_free(struct engine_job *job)
{
    if (job == NULL)
        return;
    g_free(job->packed);
    g_free(job->outcomes);
    g_free(job);
}

// ---- The computing thread ----

// The OpenMP threads are started by this one and inherit its priority. A worker that may not lower
// it works all the same.
static void lower_priority(int priority)
{
    id_t self = (id_t)gettid();
    int now = getpriority(PRIO_PROCESS, self);
    setpriority(PRIO_PROCESS, self, now + priority);
}

static struct engine_job *wait_for_job(struct engine *engine)
{
    struct engine_job *job = NULL;
    pthread_mutex_lock(&engine->lock);
    while (!engine->ending && g_queue_is_empty(&engine->jobs))
        pthread_cond_wait(&engine->work, &engine->lock);
    if (!engine->ending)
        job = g_queue_pop_head(&engine->jobs);
    pthread_mutex_unlock(&engine->lock);
    return job;
}

// Only the first of several results that wait has to wake the main loop.
static void give_result(struct engine *engine, struct engine_job *job)
{
    pthread_mutex_lock(&engine->lock);
    bool wake = g_queue_is_empty(&engine->results);
    g_queue_push_tail(&engine->results, job);
    pthread_mutex_unlock(&engine->lock);
    if (wake)
        eventfd_write(engine->descriptor, 1);
}

static void evaluate_samples(struct engine_job *job, int threads, struct verdict *verdicts)
{
    const struct intake_work *work = &job->work;
    const struct batch *batch = &work->identity.batch;
    job->non_finite =
        batch_evaluate(work->scenario, work->model, work->box, batch, threads, verdicts);
    job->packed = g_malloc(verdict_packed_size_max(batch->count, work->identity.detail));
    job->packed_size = verdict_pack(verdicts, batch->count, work->identity.detail, job->packed);
}

static void evaluate_designs(struct engine_job *job, int threads)
{
    const struct intake_work *work = &job->work;
    const uint32_t count = work->identity.batch.count;
    job->outcome_count = (size_t)count * model_outcome_count(work->model);
    job->outcomes = g_new(double, job->outcome_count);
    batch_evaluate_designs(work->model, work->identity.designs, count, threads, job->outcomes);
}

static void evaluate(struct engine_job *job, int threads, struct verdict *verdicts)
{
    const int64_t start_ns = clock_monotonic_ns();
    if (job->work.identity.designs != NULL)
        evaluate_designs(job, threads);
    else
        evaluate_samples(job, threads, verdicts);
    job->service_ns = clock_monotonic_ns() - start_ns;
}

static void *compute(void *user)
{
    struct engine *engine = user;
    struct verdict *verdicts = NULL;
    uint32_t room = 0;
    struct engine_job *job;
    lower_priority(engine->priority);
    while ((job = wait_for_job(engine)) != NULL) {
        uint32_t count = job->work.identity.batch.count;
        if (count > room) {
            room = count;
            verdicts = g_renew(struct verdict, verdicts, room);
        }
        evaluate(job, engine->threads, verdicts);
        give_result(engine, job);
    }
    g_free(verdicts);
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
    pthread_cond_signal(&engine->work);
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
    pthread_mutex_lock(&engine->lock);
    g_queue_push_tail(&engine->jobs, job);
    pthread_cond_signal(&engine->work);
    pthread_mutex_unlock(&engine->lock);
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
