#include "coordinator/runtime/pool.h"

#include "common/base/watch.h"

#include <assert.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/eventfd.h>
#include <unistd.h>

struct pool {
    uint32_t taken; // jobs given away, of which the loop has not been told yet
    pool_work *work;
    pool_done *done;
    void *user;
    int thread_count;
    pthread_t *threads;
    guint watch;    // of the descriptor on the main loop
    int descriptor; // eventfd: jobs are done

    pthread_mutex_t lock;  // guards what follows
    pthread_cond_t wanted; // jobs wait, or the threads shall end
    GQueue waiting;
    GPtrArray *finished;
    bool ending;
};

// The next job; NULL when the threads shall end.
static void *next(struct pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    while (!pool->ending && g_queue_is_empty(&pool->waiting))
        pthread_cond_wait(&pool->wanted, &pool->lock);
    void *job = pool->ending ? NULL : g_queue_pop_head(&pool->waiting);
    pthread_mutex_unlock(&pool->lock);
    return job;
}

static void *run(void *user)
{
    struct pool *pool = user;
    void *job;
    while ((job = next(pool)) != NULL) {
        pool->work(job);
        pthread_mutex_lock(&pool->lock);
        const bool first = pool->finished->len == 0;
        g_ptr_array_add(pool->finished, job);
        pthread_mutex_unlock(&pool->lock);
        if (first)
            eventfd_write(pool->descriptor, 1);
    }
    return NULL;
}

static gboolean told(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)condition;
    struct pool *pool = user;
    eventfd_t count;
    (void)!eventfd_read(descriptor, &count); // first: what comes later rings again
    pthread_mutex_lock(&pool->lock);
    GPtrArray *jobs = pool->finished;
    pool->finished = g_ptr_array_new();
    pthread_mutex_unlock(&pool->lock);
    pool->taken -= jobs->len;
    if (jobs->len > 0)
        pool->done(pool->user, jobs);
    g_ptr_array_unref(jobs);
    return G_SOURCE_CONTINUE;
}

// Signals are for the main thread, so the others are born with all of them blocked. A machine that
// refuses a thread goes on with those that are there.
static void start_threads(struct pool *pool, int threads)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pool->threads = g_new(pthread_t, threads);
    while (pool->thread_count < threads &&
           pthread_create(&pool->threads[pool->thread_count], NULL, run, pool) == 0)
        pool->thread_count++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

enum status pool_create(struct pool **result, int threads, pool_work *work, pool_done *done,
                        void *user, struct error *error)
{
    assert(threads > 0);
    *result = NULL;
    const int descriptor = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (descriptor < 0)
        return error_set(error, STATUS_FAILED, "no descriptor is left for more threads");
    struct pool *pool = g_new0(struct pool, 1);
    pool->work = work;
    pool->done = done;
    pool->user = user;
    pool->descriptor = descriptor;
    pool->finished = g_ptr_array_new();
    g_queue_init(&pool->waiting);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wanted, NULL);
    pool->watch = watch_add(descriptor, told, pool);
    start_threads(pool, threads);
    if (pool->thread_count == 0) {
        pool_free(pool);
        return error_set(error, STATUS_FAILED, "the system refuses another thread");
    }
    *result = pool;
    return STATUS_OK;
}

void pool_free(struct pool *pool)
{
    if (pool == NULL)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->ending = true;
    pthread_cond_broadcast(&pool->wanted);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->thread_count; i++)
        pthread_join(pool->threads[i], NULL);
    g_source_remove(pool->watch);
    close(pool->descriptor);
    g_queue_clear(&pool->waiting);
    g_ptr_array_unref(pool->finished);
    pthread_cond_destroy(&pool->wanted);
    pthread_mutex_destroy(&pool->lock);
    g_free(pool->threads);
    g_free(pool);
}

void pool_take(struct pool *pool, void *job)
{
    pool->taken++;
    pthread_mutex_lock(&pool->lock);
    g_queue_push_tail(&pool->waiting, job);
    pthread_cond_signal(&pool->wanted);
    pthread_mutex_unlock(&pool->lock);
}

double pool_load(const struct pool *pool)
{
    return (double)pool->taken / pool->thread_count;
}
