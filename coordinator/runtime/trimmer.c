#include "coordinator/runtime/trimmer.h"

#include "common/base/watch.h"

#include <assert.h>
#include <pthread.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

struct trimmer {
    int thread_count;
    uint32_t taken; // searches given away, of which the handler has not been told yet
    trimmer_handler *handler;
    void *user;
    guint watch;    // of the descriptor on the main loop
    int descriptor; // eventfd: trimmed searches wait
    pthread_t *threads;

    pthread_mutex_t lock; // guards what follows
    pthread_cond_t work;  // searches wait, or the threads shall end
    GQueue waiting;       // of struct run_search, to be trimmed
    GPtrArray *trimmed;   // to be told of
    bool ending;
};

// The next search to trim; NULL when the threads shall end.
static struct run_search *next(struct trimmer *trimmer)
{
    pthread_mutex_lock(&trimmer->lock);
    while (!trimmer->ending && g_queue_is_empty(&trimmer->waiting))
        pthread_cond_wait(&trimmer->work, &trimmer->lock);
    struct run_search *search = trimmer->ending ? NULL : g_queue_pop_head(&trimmer->waiting);
    pthread_mutex_unlock(&trimmer->lock);
    return search;
}

static void *work(void *user)
{
    struct trimmer *trimmer = user;
    struct run_search *search;
    while ((search = next(trimmer)) != NULL) {
        run_trim(search);
        pthread_mutex_lock(&trimmer->lock);
        const bool first = trimmer->trimmed->len == 0;
        g_ptr_array_add(trimmer->trimmed, search);
        pthread_mutex_unlock(&trimmer->lock);
        if (first)
            eventfd_write(trimmer->descriptor, 1);
    }
    return NULL;
}

static gboolean told(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)condition;
    struct trimmer *trimmer = user;
    eventfd_t count;
    (void)!eventfd_read(descriptor,
                        &count); // before the list is taken: what comes later rings again
    pthread_mutex_lock(&trimmer->lock);
    GPtrArray *searches = trimmer->trimmed;
    trimmer->trimmed = g_ptr_array_new();
    pthread_mutex_unlock(&trimmer->lock);
    trimmer->taken -= searches->len;
    if (searches->len > 0)
        trimmer->handler(trimmer->user, searches);
    g_ptr_array_unref(searches);
    return G_SOURCE_CONTINUE;
}

// Signals are for the main thread, so the others are born with all of them blocked. A machine that
// refuses a thread goes on with those that are there.
static void start_threads(struct trimmer *trimmer, int threads)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    trimmer->threads = g_new(pthread_t, threads);
    while (trimmer->thread_count < threads &&
           pthread_create(&trimmer->threads[trimmer->thread_count], NULL, work, trimmer) == 0)
        trimmer->thread_count++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

enum status trimmer_create(struct trimmer **result, int threads, trimmer_handler *handler,
                           void *user, struct error *error)
{
    assert(threads > 0);
    *result = NULL;
    const int descriptor = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (descriptor < 0)
        return error_set(error, STATUS_FAILED, "no descriptor is left for the trimming threads");
    struct trimmer *trimmer = g_new0(struct trimmer, 1);
    trimmer->handler = handler;
    trimmer->user = user;
    trimmer->descriptor = descriptor;
    trimmer->trimmed = g_ptr_array_new();
    g_queue_init(&trimmer->waiting);
    pthread_mutex_init(&trimmer->lock, NULL);
    pthread_cond_init(&trimmer->work, NULL);
    trimmer->watch = watch_add(descriptor, told, trimmer);
    start_threads(trimmer, threads);
    if (trimmer->thread_count == 0) {
        trimmer_free(trimmer);
        return error_set(error, STATUS_FAILED, "the system refuses another thread");
    }
    *result = trimmer;
    return STATUS_OK;
}

void trimmer_free(struct trimmer *trimmer)
{
    if (trimmer == NULL)
        return;
    pthread_mutex_lock(&trimmer->lock);
    trimmer->ending = true;
    pthread_cond_broadcast(&trimmer->work);
    pthread_mutex_unlock(&trimmer->lock);
    for (int i = 0; i < trimmer->thread_count; i++)
        pthread_join(trimmer->threads[i], NULL);
    g_source_remove(trimmer->watch);
    close(trimmer->descriptor);
    g_queue_clear(&trimmer->waiting);
    g_ptr_array_unref(trimmer->trimmed);
    pthread_cond_destroy(&trimmer->work);
    pthread_mutex_destroy(&trimmer->lock);
    g_free(trimmer->threads);
    g_free(trimmer);
}

void trimmer_take(struct trimmer *trimmer, struct run_search *search)
{
    trimmer->taken++;
    pthread_mutex_lock(&trimmer->lock);
    g_queue_push_tail(&trimmer->waiting, search);
    pthread_cond_signal(&trimmer->work);
    pthread_mutex_unlock(&trimmer->lock);
}

double trimmer_load(const struct trimmer *trimmer)
{
    return (double)trimmer->taken / trimmer->thread_count;
}
