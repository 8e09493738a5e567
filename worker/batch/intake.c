#include "worker/batch/intake.h"

#include "worker/batch/store.h"
#include "worker/batch/turns.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stddef.h>

// A batch between its arrival and intake_done().
struct queued {
    struct intake_batch batch; // text NULL
    struct turn turn;          // arrivals are 0, 1, 2, ...; among the ready ones
    struct item *scenario;
    struct item *box; // NULL where the batch brings its designs
    double *designs;  // its own copy of them; NULL where there is a box
    GList link;       // among the waiting ones
    bool taken;
};

struct intake {
    struct store store;
    GHashTable *batches; // every struct queued, by its identity
    GQueue waiting;      // for a text, in the order of arrival
    struct turns ready;  // to be evaluated
    uint64_t arrivals;
    size_t design_size; // of all batches [bytes]
};

struct batch intake_samples(const struct intake_batch *batch)
{
    return (struct batch){.sampling = batch->sampling,
                          .first = batch->identity.first,
                          .count = batch->identity.count,
                          .detail = batch->detail};
}

// FNV-1a over the words that name a batch.
static guint identity_hash(gconstpointer key)
{
    const struct intake_batch *batch = &((const struct queued *)key)->batch;
    const struct batch_identity *identity = &batch->identity;
    const uint64_t words[] = {batch->coordinator, batch->run,      identity->search,
                              identity->step,     identity->batch, identity->first};
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < G_N_ELEMENTS(words); i++)
        hash = (hash ^ words[i]) * UINT64_C(1099511628211);
    return (guint)(hash >> 32);
}

// An attempt more is the same batch.
static gboolean identity_same(gconstpointer left, gconstpointer right)
{
    const struct intake_batch *a = &((const struct queued *)left)->batch;
    const struct intake_batch *b = &((const struct queued *)right)->batch;
    return a->coordinator == b->coordinator && a->run == b->run &&
           a->identity.search == b->identity.search && a->identity.step == b->identity.step &&
           a->identity.batch == b->identity.batch && a->identity.first == b->identity.first &&
           a->identity.count == b->identity.count && (a->designs == NULL) == (b->designs == NULL) &&
           digest_equal(&a->scenario, &b->scenario) && digest_equal(&a->box, &b->box);
}

static void queued_free(gpointer data)
{
    struct queued *queued = data;
    g_free(queued->designs);
    g_free(queued);
}

struct intake *intake_create(void)
{
    _Static_assert((int)INTAKE_BOX_MAX >= (int)INTAKE_QUEUE_MAX,
                   "each queued batch may hold a box of its own: keep at least as many");
    struct intake *intake = g_new0(struct intake, 1);
    store_init(&intake->store, INTAKE_SCENARIO_MAX, INTAKE_SCENARIO_SIZE_MAX, INTAKE_BOX_MAX);
    intake->batches = g_hash_table_new_full(identity_hash, identity_same, queued_free, NULL);
    g_queue_init(&intake->waiting);
    turns_init(&intake->ready);
    return intake;
}

void intake_free(struct intake *intake)
{
    if (intake == NULL)
        return;
    turns_fini(&intake->ready);
    g_hash_table_unref(intake->batches);
    store_fini(&intake->store);
    g_free(intake);
}

// Forgets a batch that is in none of the lists.
static void queued_forget(struct intake *intake, struct queued *queued)
{
    store_release(&intake->store, queued->scenario);
    if (queued->box != NULL)
        store_release(&intake->store, queued->box);
    intake->design_size -= queued->batch.design_value_count * sizeof(double);
    g_hash_table_remove(intake->batches, queued);
}

// Attacks are there for all samples of the step, and want to know margins of constraints that the
// scenario has.
static enum status moves_check(const struct queued *queued, struct error *error)
{
    const struct sampling *sampling = &queued->batch.sampling;
    const struct scenario *scenario = &queued->scenario->scenario;
    const struct moves *moves = &queued->box->moves;
    if (sampling->method != SAMPLING_METHOD_MOVES)
        return STATUS_OK;
    const uint64_t samples =
        (uint64_t)moves->attacks * moves_count(&scenario->curves, &queued->box->box);
    if (samples != sampling->samples)
        return error_set(error, STATUS_INVALID, "attacks of %llu samples in a step of %u",
                         (unsigned long long)samples, sampling->samples);
    for (uint32_t attack = 0; attack < moves->attacks; attack++) {
        const uint8_t target = moves->rows[(size_t)attack * (1 + moves->variables)];
        if (target >= scenario->constraint_count)
            return error_set(error, STATUS_INVALID, "an attack on constraint %u of %u", target,
                             scenario->constraint_count);
    }
    return STATUS_OK;
}

static enum status queued_check(const struct queued *queued, struct error *error)
{
    uint32_t wanted = queued->scenario->scenario.design_space.count;
    if (queued->box == NULL) {
        const uint32_t each = queued->batch.design_value_count / queued->batch.identity.count;
        if (each != wanted)
            return error_set(error, STATUS_INVALID, "designs of %u variables, the scenario has %u",
                             each, wanted);
        return STATUS_OK;
    }
    uint32_t found = queued->box->box.count;
    if (found != wanted)
        return error_set(error, STATUS_INVALID, "a box of %u variables, the scenario has %u", found,
                         wanted);
    return moves_check(queued, error);
}

static bool queued_complete(const struct queued *queued)
{
    return queued->scenario->ready && (queued->box == NULL || queued->box->ready);
}

// Moves a batch that is in no list to where it belongs now, or forgets it.
static enum status queued_place(struct intake *intake, struct queued *queued, struct error *error)
{
    if (!queued_complete(queued)) {
        g_queue_push_tail_link(&intake->waiting, &queued->link);
        return STATUS_OK;
    }
    enum status status = queued_check(queued, error);
    if (status == STATUS_OK)
        turns_add(&intake->ready, &queued->turn);
    else
        queued_forget(intake, queued);
    return status;
}

// An item has become ready: places the batches that waited for it anew.
static enum status waiting_place(struct intake *intake, const struct item *item,
                                 struct error *error)
{
    enum status status = STATUS_OK;
    GList *next;
    for (GList *link = intake->waiting.head; link != NULL; link = next) {
        struct queued *queued = link->data;
        next = link->next;
        if ((queued->scenario != item && queued->box != item) || !queued_complete(queued))
            continue;
        g_queue_unlink(&intake->waiting, link);
        if (queued_place(intake, queued, error) != STATUS_OK)
            status = STATUS_INVALID;
    }
    return status;
}

// An item will never become ready: forgets the batches that waited for it, and with the last of
// them the item.
static void waiting_drop(struct intake *intake, const struct item *item)
{
    GList *next;
    for (GList *link = intake->waiting.head; link != NULL; link = next) {
        struct queued *queued = link->data;
        next = link->next;
        if (queued->scenario != item && queued->box != item)
            continue;
        g_queue_unlink(&intake->waiting, link);
        queued_forget(intake, queued);
    }
}

static struct queued *queued_create(struct intake *intake, const struct intake_batch *batch,
                                    int64_t now_ns)
{
    struct item *scenario =
        store_acquire(&intake->store, ITEM_SCENARIO, &batch->scenario, batch->run, now_ns);
    if (scenario == NULL)
        return NULL;
    struct item *box = NULL;
    if (batch->designs == NULL) {
        box = store_acquire(&intake->store, ITEM_BOX, &batch->box, batch->run, now_ns);
        if (box != NULL && box->variables == 0)
            box->variables = batch->variables;
        if (box == NULL) {
            store_release(&intake->store, scenario);
            return NULL;
        }
    }
    struct queued *queued = g_new0(struct queued, 1);
    queued->batch = *batch;
    queued->batch.text = NULL;
    queued->batch.text_size = 0;
    const size_t design_size = batch->design_value_count * sizeof(double);
    queued->designs = batch->designs != NULL ? g_memdup2(batch->designs, design_size) : NULL;
    queued->batch.designs = queued->designs;
    intake->design_size += design_size;
    queued->turn = (struct turn){.coordinator = batch->coordinator, .arrival = intake->arrivals++};
    queued->scenario = scenario;
    queued->box = box;
    queued->link.data = queued;
    g_hash_table_add(intake->batches, queued);
    return queued;
}

static enum status designs_check(const struct intake *intake, const struct intake_batch *batch,
                                 struct error *error)
{
    const uint32_t count = batch->design_value_count;
    if (count == 0 || count % batch->identity.count != 0)
        return error_set(error, STATUS_INVALID, "%u values are not those of %u designs", count,
                         batch->identity.count);
    for (uint32_t i = 0; i < count; i++)
        if (!isfinite(batch->designs[i]))
            return error_set(error, STATUS_INVALID, "a design has a value that is not finite");
    if (intake->design_size + count * sizeof(double) > INTAKE_DESIGN_SIZE_MAX)
        return error_set(error, STATUS_REFUSED, "%zu MiB of designs wait already",
                         intake->design_size >> 20);
    return STATUS_OK;
}

enum status intake_batch(struct intake *intake, const struct intake_batch *batch, int64_t now_ns,
                         struct error *error)
{
    const struct queued identity = {.batch = *batch};
    struct queued *queued = g_hash_table_lookup(intake->batches, &identity);
    if (queued != NULL) {
        queued->batch.identity.attempt =
            MAX(queued->batch.identity.attempt, batch->identity.attempt);
        return STATUS_OK;
    }
    if (g_hash_table_size(intake->batches) >= INTAKE_QUEUE_MAX)
        return error_set(error, STATUS_REFUSED, "%d batches wait already", INTAKE_QUEUE_MAX);
    if (batch->designs != NULL) {
        const enum status checked = designs_check(intake, batch, error);
        if (checked != STATUS_OK)
            return checked;
    }
    queued = queued_create(intake, batch, now_ns);
    if (queued == NULL)
        return error_set(error, STATUS_REFUSED, "as many scenarios as may be kept are in use");
    struct item *box = queued->box;
    if (box == NULL || batch->text_size == 0 || box->ready)
        return queued_place(intake, queued, error);
    enum status status =
        store_finish_box(&intake->store, box, batch->text, batch->text_size, error);
    if (status != STATUS_OK) {
        queued_forget(intake, queued);
        return status;
    }
    status = waiting_place(intake, box, error);
    enum status own = queued_place(intake, queued, error);
    return status == STATUS_OK ? own : status;
}

static enum status intake_piece(struct intake *intake, struct item *item, uint32_t total_size,
                                uint32_t offset, const uint8_t *piece, uint32_t size,
                                int64_t now_ns, struct error *error)
{
    switch (store_piece(&intake->store, item, total_size, offset, piece, size)) {
    case TEXT_NOTHING:
        return STATUS_OK;
    case TEXT_MORE:
    case TEXT_GAP:
        break;
    case TEXT_WHOLE:
        if (store_finish(&intake->store, item, error) == STATUS_OK)
            return waiting_place(intake, item, error);
        waiting_drop(intake, item);
        return STATUS_INVALID;
    }
    bool gap = offset + size == total_size;
    item->interval_ns = INTAKE_INTERVAL_MIN_NS;
    item->ask_ns = gap ? now_ns : now_ns + item->interval_ns;
    item->asked_count = 0;
    return STATUS_OK;
}

enum status intake_text(struct intake *intake, const struct digest *digest, uint32_t total_size,
                        uint32_t offset, const uint8_t *piece, uint32_t size, int64_t now_ns,
                        struct error *error)
{
    static const char *const kind_name[ITEM_KIND_COUNT] = {"scenario", "box"};
    enum status status = STATUS_OK;
    // A digest may have been asked for under both kinds; only nonsense makes it so, but it must do
    // no harm.
    for (int kind = 0; kind < ITEM_KIND_COUNT; kind++) {
        struct item *item = store_missing(&intake->store, kind, digest);
        if (item == NULL ||
            intake_piece(intake, item, total_size, offset, piece, size, now_ns, error) == STATUS_OK)
            continue;
        char hex[DIGEST_HEX_SIZE];
        status = STATUS_INVALID;
        if (error != NULL)
            error_wrap(error, "%s %s", kind_name[kind], digest_hex(digest, hex));
    }
    return status;
}

// The first item that is due to be asked for, or NULL.
static struct item *item_due(const struct intake *intake, int64_t now_ns)
{
    for (GList *link = intake->store.missing.head; link != NULL; link = link->next) {
        struct item *item = link->data;
        if (item->ask_ns <= now_ns)
            return item;
    }
    return NULL;
}

bool intake_request(struct intake *intake, int64_t now_ns, struct intake_request *request)
{
    struct item *item = item_due(intake, now_ns);
    while (item != NULL && item->asked_count == INTAKE_ASK_MAX) {
        waiting_drop(intake, item);
        item = item_due(intake, now_ns);
    }
    if (item == NULL)
        return false;
    item->interval_ns =
        CLAMP(2 * item->interval_ns, INTAKE_INTERVAL_MIN_NS, INTAKE_INTERVAL_MAX_NS);
    item->ask_ns = now_ns + item->interval_ns;
    item->asked_count++;
    *request = (struct intake_request){
        .run = item->run,
        .digest = item->digest,
        .offset = text_missing(&item->text),
    };
    return true;
}

int64_t intake_wake_ns(const struct intake *intake)
{
    int64_t wake_ns = INT64_MAX;
    for (const GList *link = intake->store.missing.head; link != NULL; link = link->next)
        wake_ns = MIN(wake_ns, ((const struct item *)link->data)->ask_ns);
    return wake_ns;
}

bool intake_take(struct intake *intake, struct intake_work *work)
{
    struct turn *turn = turns_take(&intake->ready);
    if (turn == NULL)
        return false;
    struct queued *queued = (struct queued *)((char *)turn - offsetof(struct queued, turn));
    queued->taken = true;
    *work = (struct intake_work){
        .batch = queued->batch,
        .scenario = &queued->scenario->scenario,
        .model = queued->scenario->model,
        .box = queued->box != NULL ? &queued->box->box : NULL,
    };
    if (queued->box != NULL)
        work->batch.sampling.moves = &queued->box->moves;
    return true;
}

void intake_done(struct intake *intake, const struct intake_work *work)
{
    const struct queued identity = {.batch = work->batch};
    struct queued *queued = g_hash_table_lookup(intake->batches, &identity);
    assert(queued != NULL);
    assert(queued->taken);
    queued_forget(intake, queued);
}

uint32_t intake_queue(const struct intake *intake)
{
    return g_hash_table_size(intake->batches);
}
