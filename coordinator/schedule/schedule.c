// The decisions. What is known stands in the roster (workers), the backlog (steps and batches) and
// the book (leases); here an event changes them, then what is due expires, then whoever has room is
// given what waits. Every event costs O(log n) in workers and leases, and O(1) in steps.
#include "coordinator/schedule/schedule.h"
#include "coordinator/schedule/backlog.h"
#include "coordinator/schedule/cut.h"
#include "coordinator/schedule/lease.h"
#include "coordinator/schedule/roster.h"

#include <assert.h>
#include <glib.h>
#include <stdarg.h>
#include <stdio.h>

// How long samples wait without any worker before a person is told: workers that are just starting
// announce themselves within this time. Told again at doubling intervals.
#define DROUGHT_FIRST_NS INT64_C(1000000000)

// Late batches looked at for one that an idle worker does not hold itself. That worker holds a few
// at most, so a few more always hold one if there is one.
enum { COPY_LOOK_MAX = 16 };

struct schedule {
    struct schedule_settings settings;
    struct roster roster;
    struct lease_book book;
    struct backlog backlog;
    struct schedule_counters counters; // the part that only grows
    struct schedule_effects *effects;  // of the step being taken

    // The schedule's own clock, which stands still while the coordinator does.
    int64_t now_ns;
    int64_t slept_ns; // the event's time minus now_ns
    int64_t wake_ns;  // asked for last
    bool excused;     // it slept through wake_ns and was given time for it

    int64_t drought_next_ns; // next note that no worker is there; INT64_MAX when there is one
    int64_t drought_interval_ns;
};

struct schedule_settings schedule_settings_default(void)
{
    return (struct schedule_settings){
        .batch_samples_max =
            {
                // 3.1 bytes a bad sample: what a frame of 1,400 bytes holds when nearly all are
                // bad.
                [VERDICT_DETAIL_FULL] = 400,
                [VERDICT_DETAIL_SHARE] = 8192, // 1 bit a sample: 1,024 bytes
                [VERDICT_DETAIL_MARGIN] = 176, // 7.1 bytes a bad sample
            },
        // A hundred round trips (24 us on one machine, some 100 us between two): the messages cost
        // 1 %. Ten times that would leave workers idle at the end of each step, and a lost one
        // would
        // cost ten times as much work.
        .batch_target_ns = 3 * INT64_C(1000000),
        // Three announcements missed.
        .silence_ns = 3 * INT64_C(1000000000),
        // Above what a busy machine's scheduler and a garbage-collecting switch take now and then
        // (tens of ms with two processes a core), and far below what a person notices. It halves
        // with each outcome in time.
        .lease_new_ns = 50 * INT64_C(1000000),
        // What a lost message costs where every measurement is short and nobody is idle; a quarter
        // of it where somebody is. A hiccup that is longer makes copies: an idle worker's time.
        .lease_min_ns = 2 * INT64_C(1000000),
        // An estimate that ran away is mended within this time; silence ends a dead worker's leases
        // earlier.
        .lease_max_ns = 30 * INT64_C(1000000000),
        // Measured 20 to 40 us (tests/bench), most of it the kernel's. It moves nothing with a few
        // workers, and with hundreds keeps batches long enough for one loop to feed all.
        .message_ns = 20000,
        // One worker with many cores and a cheap model has done a batch in 20 us, as long as a
        // message takes the coordinator: 64 cover a round trip of a millisecond.
        .window_max = 64,
    };
}

struct schedule *schedule_create(const struct schedule_settings *settings)
{
    for (int detail = 0; detail < VERDICT_DETAIL_COUNT; detail++)
        assert(settings->batch_samples_max[detail] > 0);
    assert(settings->batch_target_ns > 0);
    assert(settings->silence_ns > 0);
    assert(settings->lease_min_ns > 0);
    assert(settings->lease_new_ns > 0);
    assert(settings->lease_max_ns >= settings->lease_min_ns);
    assert(settings->message_ns >= 0);
    assert(settings->window_max > 0);
    struct schedule *schedule = g_new0(struct schedule, 1);
    schedule->settings = *settings;
    roster_init(&schedule->roster, &schedule->settings);
    lease_book_init(&schedule->book, &schedule->settings);
    backlog_init(&schedule->backlog);
    schedule->now_ns = INT64_MIN;
    schedule->wake_ns = INT64_MAX;
    schedule->drought_next_ns = INT64_MAX;
    return schedule;
}

void schedule_free(struct schedule *schedule)
{
    if (schedule == NULL)
        return;
    backlog_fini(&schedule->backlog);
    lease_book_fini(&schedule->book);
    roster_fini(&schedule->roster);
    g_free(schedule);
}

void schedule_effects_fini(struct schedule_effects *effects)
{
    g_free(effects->items);
    *effects = (struct schedule_effects){0};
}

// Effects.

static struct schedule_effect *effect_add(struct schedule *schedule, enum schedule_effect_kind kind)
{
    struct schedule_effects *effects = schedule->effects;
    if (effects->count == effects->capacity) {
        effects->capacity = effects->capacity == 0 ? 16 : 2 * effects->capacity;
        effects->items = g_renew(struct schedule_effect, effects->items, effects->capacity);
    }
    struct schedule_effect *effect = &effects->items[effects->count++];
    effect->kind = kind;
    return effect;
}

static void __attribute__((format(printf, 2, 3)))
note(struct schedule *schedule, const char *format, ...)
{
    struct schedule_effect *effect = effect_add(schedule, SCHEDULE_EFFECT_NOTE);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(effect->note, sizeof effect->note, format, arguments);
    va_end(arguments);
}

// What becomes of a departed worker's batches, as the end of a sentence.
static const char *released_text(uint32_t count, char text[64])
{
    if (count == 0)
        text[0] = '\0';
    else if (count == 1)
        snprintf(text, 64, ": its batch is handed out again");
    else
        snprintf(text, 64, ": its %u batches are handed out again", count);
    return text;
}

// Leases.

static void batch_lease(struct schedule *schedule, struct backlog_batch *batch,
                        struct roster_worker *worker)
{
    struct schedule_effect *effect = effect_add(schedule, SCHEDULE_EFFECT_SEND);
    effect->send.worker = worker->id;
    effect->send.batch = batch->identity;
    lease_start(&schedule->book, &schedule->roster, batch, worker, schedule->now_ns);
}

// A lease ends without an outcome. The batch waits again, unless another lease of it goes on; that
// one may be copied in turn when it is late.
static void lease_release(struct schedule *schedule, struct lease *lease)
{
    struct backlog_batch *batch = lease->batch;
    lease_end(&schedule->book, &schedule->roster, lease);
    schedule->counters.released++;
    if (lease_active(batch) == 0) {
        backlog_move(&schedule->backlog, batch, BACKLOG_WAITING);
        return;
    }
    for (uint32_t i = 0; i < LEASE_KEPT_MAX; i++) {
        if (batch->leases[i].worker != NULL && batch->leases[i].late)
            backlog_set_late(&schedule->backlog, batch, true);
    }
}

static void lease_lapse(struct schedule *schedule, struct lease *lease)
{
    struct roster_worker *worker = lease->worker;
    int64_t start_ns = lease->start_ns;
    roster_missed(&schedule->roster, worker, &lease->batch->identity, lease->attempt);
    lease_release(schedule, lease);
    roster_lapsed(&schedule->roster, worker, start_ns);
}

static uint32_t worker_release(struct schedule *schedule, struct roster_worker *worker)
{
    uint32_t count = worker->lease_count;
    while (worker->lease_count > 0)
        lease_release(schedule, worker->leases[worker->lease_count - 1]);
    return count;
}

static void batch_end_leases(struct schedule *schedule, struct backlog_batch *batch)
{
    for (uint32_t i = 0; i < LEASE_KEPT_MAX; i++) {
        if (batch->leases[i].worker != NULL)
            lease_end(&schedule->book, &schedule->roster, &batch->leases[i]);
    }
}

// Events.

static void step_cancel(struct schedule *schedule, uint32_t search)
{
    struct backlog_step *step = backlog_step(&schedule->backlog, search);
    if (step == NULL)
        return;
    for (guint i = 0; i < step->batches->len; i++)
        batch_end_leases(schedule, step->batches->pdata[i]);
    backlog_cancel(&schedule->backlog, step);
}

static void step_event(struct schedule *schedule, const struct schedule_event *event)
{
    // A search waits for one step only: the new one is what it wants now.
    step_cancel(schedule, event->step.search);
    backlog_add(&schedule->backlog, event->step.search, event->step.step, event->step.samples,
                event->step.detail, event->step.sample_ns);
}

static void worker_refuse(struct schedule *schedule, const char *name)
{
    note(schedule,
         "worker %s refused: its kernel or version differs from this coordinator's; install the "
         "same sobox on both",
         name);
}

static void worker_join(struct schedule *schedule, const struct schedule_event *event)
{
    enum roster_state state = event->worker.acceptable ? ROSTER_WORKING : ROSTER_REFUSED;
    struct roster_worker *worker =
        roster_add(&schedule->roster, event->worker.id, event->worker.name, event->worker.threads,
                   state, schedule->now_ns);
    if (worker == NULL)
        return;
    if (state == ROSTER_REFUSED) {
        worker_refuse(schedule, worker->name);
        return;
    }
    roster_queue(&schedule->roster, worker, event->worker.queue);
    note(schedule, "worker %s joined with %u thread%s", worker->name, worker->threads,
         worker->threads == 1 ? "" : "s");
}

// A sign of life of a worker on the roster; one that was silent is taken back.
static void worker_heard(struct schedule *schedule, struct roster_worker *worker)
{
    roster_hear(&schedule->roster, worker, schedule->now_ns);
    if (worker->state == ROSTER_SILENT) {
        roster_move(&schedule->roster, worker, ROSTER_WORKING);
        note(schedule, "worker %s is heard again", worker->name);
    }
}

static void worker_event(struct schedule *schedule, const struct schedule_event *event)
{
    struct roster_worker *worker = roster_find(&schedule->roster, event->worker.id);
    if (worker == NULL) {
        if (!event->worker.leaving)
            worker_join(schedule, event);
        return;
    }
    // Its last message may be overtaken by its last but one: who left stays away.
    if (worker->state == ROSTER_LEFT)
        return;
    if (worker->state == ROSTER_REFUSED) {
        roster_hear(&schedule->roster, worker, schedule->now_ns);
        return;
    }
    char text[64];
    if (!event->worker.acceptable) {
        worker_release(schedule, worker);
        roster_move(&schedule->roster, worker, ROSTER_REFUSED);
        worker_refuse(schedule, worker->name);
    } else if (event->worker.leaving) {
        uint32_t count = worker_release(schedule, worker);
        roster_move(&schedule->roster, worker, ROSTER_LEFT);
        note(schedule, "worker %s left%s", worker->name, released_text(count, text));
    } else {
        worker_heard(schedule, worker);
        roster_queue(&schedule->roster, worker, event->worker.queue);
    }
}

// Workers answer in the order in which they were asked: what was asked long before `order` got
// lost.
static void worker_passed(struct schedule *schedule, struct roster_worker *worker, uint64_t order)
{
    for (uint32_t i = worker->lease_count; i-- > 0;) {
        struct lease *lease = worker->leases[i];
        if (lease->order < order && ++lease->passed >= LEASE_PASSED_MAX &&
            lease_overdue(&schedule->book, &schedule->roster, lease, schedule->now_ns))
            lease_lapse(schedule, lease);
    }
}

static void outcome_measure(struct schedule *schedule, const struct schedule_event *event,
                            struct roster_worker *worker, struct backlog_batch *batch)
{
    struct lease *lease = lease_find(batch, worker->id, event->outcome.batch.attempt);
    if (lease == NULL)
        return;
    uint64_t order = lease->order;
    if (lease->worker != NULL && lease->late && lease_active(batch) > 1)
        roster_too_soon(&schedule->roster, worker);
    else if (lease->worker != NULL)
        roster_hurry(&schedule->roster, worker);
    lease_measure(&schedule->book, lease, &schedule->roster, worker, event->outcome.service_ns,
                  schedule->now_ns);
    if (lease->worker != NULL)
        lease_end(&schedule->book, &schedule->roster, lease);
    worker_passed(schedule, worker, order);
}

// Ends the leases that others still have of a batch that was answered. Who was late with it has let
// it lapse, only that nobody had to wait for it.
static void outcome_end_leases(struct schedule *schedule, struct backlog_batch *batch)
{
    for (uint32_t i = 0; i < LEASE_KEPT_MAX; i++) {
        struct lease *lease = &batch->leases[i];
        struct roster_worker *worker = lease->worker;
        if (worker == NULL)
            continue;
        lease_end(&schedule->book, &schedule->roster, lease);
        if (!lease->late)
            continue;
        roster_missed(&schedule->roster, worker, &batch->identity, lease->attempt);
        roster_lapsed(&schedule->roster, worker, lease->start_ns);
    }
}

static void outcome_count(struct schedule *schedule, const struct schedule_event *event,
                          struct backlog_batch *batch)
{
    outcome_end_leases(schedule, batch);
    backlog_move(&schedule->backlog, batch, BACKLOG_COUNTED);
    effect_add(schedule, SCHEDULE_EFFECT_COUNT)->count.batch = event->outcome.batch;
    schedule->counters.batches_counted++;
    schedule->counters.samples_counted += batch->identity.count;
    if (event->outcome.service_ns > 0)
        schedule->counters.service_ns += event->outcome.service_ns;

    struct backlog_step *step = batch->step;
    if (step->counted < step->samples)
        return;
    struct schedule_effect *effect = effect_add(schedule, SCHEDULE_EFFECT_STEP);
    effect->step.search = step->search->search;
    effect->step.step = step->step;
    backlog_finish(&schedule->backlog, step);
}

static void outcome_event(struct schedule *schedule, const struct schedule_event *event)
{
    struct roster_worker *worker = roster_find(&schedule->roster, event->outcome.worker);
    if (worker != NULL && worker->state == ROSTER_REFUSED) {
        // Another kernel gives other bits.
        schedule->counters.unknown++;
        return;
    }
    struct backlog_batch *batch;
    enum backlog_match match = backlog_match(&schedule->backlog, &event->outcome.batch, &batch);
    if (worker != NULL && worker->state != ROSTER_LEFT) {
        worker_heard(schedule, worker);
        if (match != BACKLOG_MATCH_UNKNOWN) {
            roster_answered(&schedule->roster, worker, schedule->now_ns);
            roster_came(&schedule->roster, worker, &event->outcome.batch);
        }
        if (batch != NULL)
            outcome_measure(schedule, event, worker, batch);
        roster_queue(&schedule->roster, worker, event->outcome.queue);
    }
    switch (match) {
    case BACKLOG_MATCH_OPEN:
        outcome_count(schedule, event, batch);
        break;
    case BACKLOG_MATCH_DUPLICATE:
        schedule->counters.duplicates++;
        break;
    case BACKLOG_MATCH_UNKNOWN:
        schedule->counters.unknown++;
        break;
    }
}

// What is due.

static void expire_leases(struct schedule *schedule)
{
    bool ended;
    struct lease *lease;
    while ((lease = lease_due(&schedule->book, &schedule->roster, schedule->now_ns, &ended)) !=
           NULL) {
        if (ended)
            lease_lapse(schedule, lease);
        else if (lease_active(lease->batch) < LEASE_ACTIVE_MAX)
            backlog_set_late(&schedule->backlog, lease->batch, true);
    }
}

static void expire_workers(struct schedule *schedule)
{
    struct roster_worker *worker;
    while ((worker = roster_silent(&schedule->roster, schedule->now_ns)) != NULL) {
        uint32_t count = worker_release(schedule, worker);
        roster_move(&schedule->roster, worker, ROSTER_SILENT);
        char text[64];
        note(schedule, "worker %s is silent since %.3g s%s", worker->name,
             (double)(schedule->now_ns - worker->heard_ns) * 1e-9, released_text(count, text));
    }
    roster_forget(&schedule->roster, schedule->now_ns);
}

static void expire_drought(struct schedule *schedule)
{
    if (schedule->backlog.samples == 0 || schedule->roster.heard.length > 0) {
        schedule->drought_next_ns = INT64_MAX;
        return;
    }
    if (schedule->drought_next_ns == INT64_MAX) {
        schedule->drought_interval_ns = DROUGHT_FIRST_NS;
        schedule->drought_next_ns = schedule->now_ns + DROUGHT_FIRST_NS;
    }
    if (schedule->now_ns < schedule->drought_next_ns)
        return;
    char refused[48] = "";
    if (schedule->roster.refused > 0)
        snprintf(refused, sizeof refused, " (%u refused)", schedule->roster.refused);
    note(schedule, "no worker is there%s: %llu samples wait", refused,
         (unsigned long long)schedule->backlog.samples);
    schedule->drought_interval_ns *= 2;
    schedule->drought_next_ns = schedule->now_ns + schedule->drought_interval_ns;
}

// Handing out.

static bool dispatch_again(struct schedule *schedule)
{
    if (schedule->backlog.again.head == NULL)
        return false;
    struct backlog_batch *batch = schedule->backlog.again.head->data;
    const struct roster_worker *holder = roster_find(&schedule->roster, batch->holder);
    struct roster_worker *worker = roster_pick(&schedule->roster, holder);
    if (worker == NULL)
        return false;
    backlog_move(&schedule->backlog, batch, BACKLOG_LEASED);
    batch_lease(schedule, batch, worker);
    return true;
}

static bool dispatch_cut(struct schedule *schedule)
{
    struct roster_worker *worker = roster_pick(&schedule->roster, NULL);
    if (worker == NULL || schedule->backlog.open.head == NULL)
        return false;
    struct backlog_step *step = schedule->backlog.open.head->data;
    uint32_t count =
        cut_count(&schedule->settings, &schedule->roster, worker, step,
                  schedule->backlog.open.length, g_hash_table_size(schedule->backlog.searches));
    batch_lease(schedule, backlog_cut(&schedule->backlog, step, count), worker);
    return true;
}

static bool dispatch_copy(struct schedule *schedule)
{
    struct backlog_batch *batch = NULL;
    struct roster_worker *worker = NULL;
    GList *link = schedule->backlog.late.head;
    for (uint32_t looked = 0; worker == NULL && link != NULL && looked < COPY_LOOK_MAX; looked++) {
        batch = link->data;
        worker = roster_idle(&schedule->roster, batch);
        link = link->next;
    }
    if (worker == NULL)
        return false;
    // Whose leases are all late may still be at work on them: good enough for the last batches of a
    // step, not for taking the place of other work.
    if (worker->lease_count > 0 && schedule->backlog.open.head != NULL)
        return false;
    backlog_set_late(&schedule->backlog, batch, false);
    batch_lease(schedule, batch, worker);
    schedule->counters.copies++;
    return true;
}

static void dispatch(struct schedule *schedule)
{
    while (dispatch_again(schedule) || dispatch_cut(schedule) || dispatch_copy(schedule))
        continue;
}

// Time.

// Brings the schedule's clock forward. When the coordinator itself was stopped or very busy and
// comes long after its wake, the outcomes and announcements of that time still wait to be read:
// nobody is judged by it. The clock then goes on from shortly before the wake, once for each.
static void schedule_advance(struct schedule *schedule, int64_t event_ns)
{
    int64_t now_ns = event_ns - schedule->slept_ns;
    int64_t grace_ns = schedule->settings.lease_min_ns;
    if (schedule->wake_ns != INT64_MAX && !schedule->excused &&
        now_ns - schedule->wake_ns > 2 * grace_ns) {
        int64_t excused_ns = schedule->wake_ns - grace_ns;
        if (excused_ns < schedule->now_ns)
            excused_ns = schedule->now_ns;
        schedule->slept_ns += now_ns - excused_ns;
        schedule->book.slept_ns = schedule->slept_ns;
        now_ns = excused_ns;
        schedule->excused = true;
    } else if (now_ns >= schedule->wake_ns) {
        schedule->excused = false;
    }
    assert(now_ns >= schedule->now_ns);
    schedule->now_ns = now_ns;
}

static int64_t schedule_wake_ns(const struct schedule *schedule)
{
    int64_t wake_ns = lease_wake_ns(&schedule->book);
    int64_t silence_ns = roster_wake_ns(&schedule->roster);
    if (silence_ns < wake_ns)
        wake_ns = silence_ns;
    if (schedule->drought_next_ns < wake_ns)
        wake_ns = schedule->drought_next_ns;
    return wake_ns;
}

void schedule_step(struct schedule *schedule, const struct schedule_event *event,
                   struct schedule_effects *effects)
{
    effects->count = 0;
    schedule->effects = effects;
    schedule_advance(schedule, event->now_ns);
    switch (event->kind) {
    case SCHEDULE_EVENT_TICK:
        break;
    case SCHEDULE_EVENT_STEP:
        step_event(schedule, event);
        break;
    case SCHEDULE_EVENT_CANCEL:
        step_cancel(schedule, event->cancel.search);
        break;
    case SCHEDULE_EVENT_WORKER:
        worker_event(schedule, event);
        break;
    case SCHEDULE_EVENT_OUTCOME:
        outcome_event(schedule, event);
        break;
    }
    expire_leases(schedule);
    expire_workers(schedule);
    dispatch(schedule);
    expire_drought(schedule);
    schedule->wake_ns = schedule_wake_ns(schedule);
    effects->wake_ns =
        schedule->wake_ns == INT64_MAX ? INT64_MAX : schedule->wake_ns + schedule->slept_ns;
    schedule->effects = NULL;
}

void schedule_counters(const struct schedule *schedule, struct schedule_counters *counters)
{
    const struct backlog *backlog = &schedule->backlog;
    *counters = schedule->counters;
    counters->workers = schedule->roster.heard.length;
    counters->workers_refused = schedule->roster.refused;
    counters->batches_leased = backlog->leased;
    uint64_t waiting = backlog->again.length;
    for (int detail = 0; detail < VERDICT_DETAIL_COUNT; detail++) {
        const uint64_t most = schedule->settings.batch_samples_max[detail];
        waiting += (backlog->uncut[detail] + most - 1) / most;
    }
    counters->batches_waiting = (uint32_t)waiting;
}
