#include "coordinator/schedule/backlog.h"

#include <assert.h>

// What a sample is assumed to take one core when the search does not say: measured times correct it
// from the first outcome on, because workers' rates are kept relative to it.
#define BACKLOG_SAMPLE_NS 1000.0

static const bool backlog_moves[BACKLOG_STATE_COUNT][BACKLOG_STATE_COUNT] = {
    [BACKLOG_LEASED] = {[BACKLOG_WAITING] = true, [BACKLOG_COUNTED] = true},
    [BACKLOG_WAITING] = {[BACKLOG_LEASED] = true, [BACKLOG_COUNTED] = true},
};

static void search_free(gpointer data)
{
    struct backlog_search *search = data;
    if (search->step != NULL) {
        g_ptr_array_free(search->step->batches, TRUE);
        g_free(search->step);
    }
    g_free(search);
}

void backlog_init(struct backlog *backlog)
{
    *backlog = (struct backlog){0};
    backlog->searches = g_hash_table_new_full(g_direct_hash, g_direct_equal, NULL, search_free);
    backlog->spare = g_ptr_array_new_with_free_func(g_free);
    g_queue_init(&backlog->open);
    g_queue_init(&backlog->again);
    g_queue_init(&backlog->late);
}

void backlog_fini(struct backlog *backlog)
{
    GHashTableIter iter;
    gpointer data;
    g_hash_table_iter_init(&iter, backlog->searches);
    while (g_hash_table_iter_next(&iter, NULL, &data)) {
        struct backlog_search *search = data;
        if (search->step != NULL)
            g_ptr_array_set_free_func(search->step->batches, g_free);
    }
    g_hash_table_destroy(backlog->searches);
    g_ptr_array_free(backlog->spare, TRUE);
    *backlog = (struct backlog){0};
}

static struct backlog_search *backlog_search(const struct backlog *backlog, uint32_t search)
{
    return g_hash_table_lookup(backlog->searches, GUINT_TO_POINTER(search));
}

void backlog_add(struct backlog *backlog, uint32_t search, uint32_t step, uint32_t samples,
                 enum verdict_detail detail, double sample_ns)
{
    assert(samples > 0);
    struct backlog_search *owner = backlog_search(backlog, search);
    if (owner == NULL) {
        owner = g_new0(struct backlog_search, 1);
        owner->search = search;
        g_hash_table_insert(backlog->searches, GUINT_TO_POINTER(search), owner);
    }
    assert(owner->step == NULL);
    bool known = sample_ns > 0;
    struct backlog_step *added = g_new0(struct backlog_step, 1);
    *added = (struct backlog_step){
        .search = owner,
        .step = step,
        .samples = samples,
        .detail = detail,
        .sample_ns = known ? sample_ns : BACKLOG_SAMPLE_NS,
        .sample_known = known,
        .batches = g_ptr_array_new(),
        .link.data = added,
    };
    owner->step = added;
    g_queue_push_tail_link(&backlog->open, &added->link);
    backlog->samples += samples;
    backlog->uncut[detail] += samples;
}

struct backlog_step *backlog_step(const struct backlog *backlog, uint32_t search)
{
    const struct backlog_search *owner = backlog_search(backlog, search);
    return owner != NULL ? owner->step : NULL;
}

// Takes the batch out of the queue it is in.
static void batch_unqueue(struct backlog_batch *batch)
{
    if (batch->queue != NULL)
        g_queue_unlink(batch->queue, &batch->link);
    batch->queue = NULL;
}

static void batch_enqueue(struct backlog_batch *batch, GQueue *queue)
{
    assert(batch->queue == NULL);
    g_queue_push_tail_link(queue, &batch->link);
    batch->queue = queue;
}

// Releases the step and what is left of its batches.
static void step_remove(struct backlog *backlog, struct backlog_step *step)
{
    for (guint i = 0; i < step->batches->len; i++) {
        struct backlog_batch *batch = step->batches->pdata[i];
        assert(lease_active(batch) == 0);
        batch_unqueue(batch);
        backlog->leased -= batch->state == BACKLOG_LEASED;
        g_ptr_array_add(backlog->spare, batch);
    }
    if (step->cut < step->samples)
        g_queue_unlink(&backlog->open, &step->link);
    backlog->samples -= step->samples - step->counted;
    backlog->uncut[step->detail] -= step->samples - step->cut;
    step->search->step = NULL;
    g_ptr_array_free(step->batches, TRUE);
    g_free(step);
}

void backlog_finish(struct backlog *backlog, struct backlog_step *step)
{
    assert(step->counted == step->samples);
    step->search->any_done = true;
    step->search->step_done = step->step;
    step_remove(backlog, step);
}

void backlog_cancel(struct backlog *backlog, struct backlog_step *step)
{
    uint32_t search = step->search->search;
    step_remove(backlog, step);
    g_hash_table_remove(backlog->searches, GUINT_TO_POINTER(search));
}

// A zeroed batch: one of a finished step, so that a run in its stride allocates nothing here.
static struct backlog_batch *batch_new(struct backlog *backlog)
{
    if (backlog->spare->len == 0)
        return g_new0(struct backlog_batch, 1);
    struct backlog_batch *batch = backlog->spare->pdata[backlog->spare->len - 1];
    g_ptr_array_steal_index_fast(backlog->spare, backlog->spare->len - 1);
    *batch = (struct backlog_batch){0};
    return batch;
}

struct backlog_batch *backlog_cut(struct backlog *backlog, struct backlog_step *step,
                                  uint32_t count)
{
    assert(count > 0);
    assert(count <= step->samples - step->cut);
    struct backlog_batch *batch = batch_new(backlog);
    batch->identity = (struct batch_identity){
        .search = step->search->search,
        .step = step->step,
        .batch = step->batches->len,
        .first = step->cut,
        .count = count,
    };
    batch->step = step;
    batch->link.data = batch;
    batch->state = BACKLOG_LEASED;
    backlog->leased++;
    g_ptr_array_add(step->batches, batch);
    step->cut += count;
    backlog->uncut[step->detail] -= count;
    g_queue_unlink(&backlog->open, &step->link);
    if (step->cut < step->samples)
        g_queue_push_tail_link(&backlog->open, &step->link);
    return batch;
}

void backlog_move(struct backlog *backlog, struct backlog_batch *batch, enum backlog_state state)
{
    assert(backlog_moves[batch->state][state]);
    batch_unqueue(batch);
    backlog->leased -= batch->state == BACKLOG_LEASED;
    backlog->leased += state == BACKLOG_LEASED;
    batch->state = state;
    if (state == BACKLOG_WAITING)
        batch_enqueue(batch, &backlog->again);
    if (state == BACKLOG_COUNTED) {
        batch->step->counted += batch->identity.count;
        backlog->samples -= batch->identity.count;
    }
}

void backlog_set_late(struct backlog *backlog, struct backlog_batch *batch, bool late)
{
    assert(batch->state == BACKLOG_LEASED);
    batch_unqueue(batch);
    if (late)
        batch_enqueue(batch, &backlog->late);
}

enum backlog_match backlog_match(const struct backlog *backlog,
                                 const struct batch_identity *identity,
                                 struct backlog_batch **found)
{
    *found = NULL;
    const struct backlog_search *search = backlog_search(backlog, identity->search);
    if (search == NULL)
        return BACKLOG_MATCH_UNKNOWN;
    const struct backlog_step *step = search->step;
    if (step == NULL || step->step != identity->step) {
        bool done = search->any_done && identity->step <= search->step_done;
        return done ? BACKLOG_MATCH_DUPLICATE : BACKLOG_MATCH_UNKNOWN;
    }
    if (identity->batch >= step->batches->len)
        return BACKLOG_MATCH_UNKNOWN;
    struct backlog_batch *batch = step->batches->pdata[identity->batch];
    if (batch->identity.first != identity->first || batch->identity.count != identity->count ||
        identity->attempt >= batch->identity.attempt)
        return BACKLOG_MATCH_UNKNOWN;
    *found = batch;
    return batch->state == BACKLOG_COUNTED ? BACKLOG_MATCH_DUPLICATE : BACKLOG_MATCH_OPEN;
}
