#include "coordinator/runtime/trimmer.h"

struct trimmer {
    int threads;
    uint32_t taken; // searches given away, of which the handler has not been told yet
    GThreadPool *pool;
    GAsyncQueue *trimmed;
    GSource *source; // made ready by the threads
    trimmer_handler *handler;
    void *user;
};

static void work(gpointer data, gpointer user)
{
    struct trimmer *trimmer = user;
    run_trim(data);
    g_async_queue_push(trimmer->trimmed, data);
    g_source_set_ready_time(trimmer->source, 0);
}

static gboolean dispatch(GSource *source, GSourceFunc callback, gpointer user)
{
    // Before the queue is emptied: what comes later makes the source ready again.
    g_source_set_ready_time(source, -1);
    return callback(user);
}

static gboolean told(gpointer user)
{
    struct trimmer *trimmer = user;
    GPtrArray *searches = g_ptr_array_new();
    gpointer search;
    while ((search = g_async_queue_try_pop(trimmer->trimmed)) != NULL)
        g_ptr_array_add(searches, search);
    trimmer->taken -= searches->len;
    if (searches->len > 0)
        trimmer->handler(trimmer->user, searches);
    g_ptr_array_unref(searches);
    return G_SOURCE_CONTINUE;
}

struct trimmer *trimmer_create(int threads, trimmer_handler *handler, void *user)
{
    static GSourceFuncs functions = {.dispatch = dispatch};
    struct trimmer *trimmer = g_new0(struct trimmer, 1);
    trimmer->threads = threads;
    trimmer->handler = handler;
    trimmer->user = user;
    trimmer->trimmed = g_async_queue_new();
    trimmer->source = g_source_new(&functions, sizeof(GSource));
    g_source_set_callback(trimmer->source, told, trimmer, NULL);
    g_source_attach(trimmer->source, NULL);
    // Threads that are shared with others would have to be waited for when they are needed.
    trimmer->pool = g_thread_pool_new(work, trimmer, threads, TRUE, NULL);
    return trimmer;
}

void trimmer_free(struct trimmer *trimmer)
{
    if (trimmer == NULL)
        return;
    g_thread_pool_free(trimmer->pool, TRUE, TRUE);
    g_source_destroy(trimmer->source);
    g_source_unref(trimmer->source);
    g_async_queue_unref(trimmer->trimmed);
    g_free(trimmer);
}

void trimmer_take(struct trimmer *trimmer, struct run_search *search)
{
    trimmer->taken++;
    g_thread_pool_push(trimmer->pool, search, NULL);
}

double trimmer_load(const struct trimmer *trimmer)
{
    return (double)trimmer->taken / trimmer->threads;
}
