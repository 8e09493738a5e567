// The schedule's promises, one claim a test, on a virtual clock: events go in with a time of our
// choosing, effects come out, and nothing ever waits.
#include "coordinator/schedule/schedule.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define MS INT64_C(1000000)
#define SECOND (1000 * MS)

enum { SENT_MAX = 65536 };

struct sent {
    uint64_t worker;
    struct batch_identity batch;
    int64_t at_ns;
};

// A schedule, its clock, and all it has done so far.
struct desk {
    struct schedule_settings settings;
    struct schedule *schedule;
    struct schedule_effects effects; // of the last event
    int64_t now_ns;
    struct sent sent[SENT_MAX];
    size_t sent_count;
    uint32_t counted; // samples
    uint32_t steps_done;
    char notes[1 << 18]; // one a line
};

static struct desk desk;
static size_t answered; // how many of desk.sent answer_all() has answered

static int desk_open(void **state)
{
    (void)state;
    memset(&desk, 0, sizeof desk);
    answered = 0;
    desk.settings = schedule_settings_default();
    desk.schedule = schedule_create(&desk.settings);
    desk.now_ns = 1000 * SECOND;
    return 0;
}

static int desk_close(void **state)
{
    (void)state;
    schedule_effects_fini(&desk.effects);
    schedule_free(desk.schedule);
    return 0;
}

// The same desk with other settings.
static void desk_reopen(const struct schedule_settings *settings)
{
    schedule_free(desk.schedule);
    desk.settings = *settings;
    desk.schedule = schedule_create(settings);
}

static void take_effect(const struct schedule_effect *effect)
{
    switch (effect->kind) {
    case SCHEDULE_EFFECT_SEND:
        assert_true(desk.sent_count < SENT_MAX);
        desk.sent[desk.sent_count++] = (struct sent){
            .worker = effect->send.worker, .batch = effect->send.batch, .at_ns = desk.now_ns};
        break;
    case SCHEDULE_EFFECT_COUNT:
        desk.counted += effect->count.batch.count;
        break;
    case SCHEDULE_EFFECT_STEP:
        desk.steps_done++;
        break;
    case SCHEDULE_EFFECT_NOTE:
        assert_true(strlen(desk.notes) + strlen(effect->note) + 2 < sizeof desk.notes);
        strcat(desk.notes, effect->note);
        strcat(desk.notes, "\n");
        break;
    }
}

static void happen(struct schedule_event event)
{
    event.now_ns = desk.now_ns;
    schedule_step(desk.schedule, &event, &desk.effects);
    for (size_t i = 0; i < desk.effects.count; i++)
        take_effect(&desk.effects.items[i]);
}

static void tick(void)
{
    happen((struct schedule_event){.kind = SCHEDULE_EVENT_TICK});
}

// Lets time pass, waking whenever the schedule asks for it.
static void pass(int64_t duration_ns)
{
    int64_t end_ns = desk.now_ns + duration_ns;
    while (desk.effects.wake_ns <= end_ns && desk.effects.wake_ns != 0) {
        if (desk.effects.wake_ns > desk.now_ns)
            desk.now_ns = desk.effects.wake_ns;
        tick();
    }
    desk.now_ns = end_ns;
}

static struct schedule_event announcement(uint64_t worker, uint32_t threads)
{
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_WORKER,
        .worker = {.id = worker, .threads = threads, .acceptable = true},
    };
    snprintf(event.worker.name, sizeof event.worker.name, "host%d/1", (int)worker);
    return event;
}

static void announce(uint64_t worker)
{
    happen(announcement(worker, 1));
}

static void leave(uint64_t worker)
{
    struct schedule_event event = announcement(worker, 1);
    event.worker.leaving = true;
    happen(event);
}

static void want(uint32_t search, uint32_t step, uint32_t samples, double sample_ns)
{
    happen((struct schedule_event){
        .kind = SCHEDULE_EVENT_STEP,
        .step = {.search = search, .step = step, .samples = samples, .sample_ns = sample_ns},
    });
}

static void answer_from(uint64_t worker, struct batch_identity batch, int64_t service_ns)
{
    happen((struct schedule_event){
        .kind = SCHEDULE_EVENT_OUTCOME,
        .outcome = {.worker = worker, .batch = batch, .service_ns = service_ns},
    });
}

static void answer(struct sent sent, int64_t service_ns)
{
    answer_from(sent.worker, sent.batch, service_ns);
}

static struct schedule_counters counters(void)
{
    struct schedule_counters counters;
    schedule_counters(desk.schedule, &counters);
    return counters;
}

// What was sent `back` sends ago; 0 is the last one.
static struct sent last_sent(size_t back)
{
    assert_true(back < desk.sent_count);
    return desk.sent[desk.sent_count - 1 - back];
}

static uint32_t sent_to(uint64_t worker)
{
    uint32_t count = 0;
    for (size_t i = 0; i < desk.sent_count; i++)
        count += desk.sent[i].worker == worker;
    return count;
}

static void assert_noted(const char *line)
{
    if (strstr(desk.notes, line) == NULL)
        fail_msg("\"%s\" is not among the notes:\n%s", line, desk.notes);
}

static void assert_same_batch(struct batch_identity a, struct batch_identity b)
{
    assert_int_equal(a.search, b.search);
    assert_int_equal(a.step, b.step);
    assert_int_equal(a.batch, b.batch);
    assert_int_equal(a.first, b.first);
    assert_int_equal(a.count, b.count);
}

// Answers everything outstanding, in the order sent, `step_ns` apart, until nothing more is sent.
static void answer_all(int64_t step_ns, int64_t service_ns)
{
    while (answered < desk.sent_count) {
        desk.now_ns += step_ns;
        answer(desk.sent[answered++], service_ns);
    }
}

// Two workers are made known to the schedule with `sample_ns` a sample, by a step of search 1000.
static void warm_up(uint32_t workers, int64_t sample_ns)
{
    for (uint32_t i = 1; i <= workers; i++)
        announce(i);
    for (uint32_t step = 0; step < 40; step++) {
        want(1000, step, 64 * workers, 1000);
        while (answered < desk.sent_count) {
            struct sent sent = desk.sent[answered++];
            int64_t service_ns = sample_ns * sent.batch.count;
            if (desk.now_ns < sent.at_ns + service_ns)
                desk.now_ns = sent.at_ns + service_ns;
            answer(sent, service_ns);
        }
    }
    assert_int_equal(desk.steps_done, 40);
    assert_int_equal(counters().batches_leased, 0);
    desk.sent_count = 0;
    answered = 0;
    desk.counted = 0;
    desk.steps_done = 0;
}

// A step goes out, comes back, and is reported done once, when its last sample is counted.
static void step_is_done_when_all_samples_are_counted(void **state)
{
    (void)state;
    announce(1);
    want(7, 3, 1000, 1000);
    while (answered < desk.sent_count) {
        assert_int_equal(desk.steps_done, 0);
        desk.now_ns += MS;
        answer(desk.sent[answered++], MS);
    }
    assert_int_equal(desk.counted, 1000);
    assert_int_equal(desk.steps_done, 1);
    assert_int_equal(counters().samples_counted, 1000);
    assert_int_equal(counters().batches_waiting, 0);
    assert_int_equal(counters().batches_leased, 0);
}

// Batches of a step cover it without gap or overlap, whoever takes them, and keep to the message
// size: an overlap would count a sample twice.
static void batches_cover_the_step_once(void **state)
{
    (void)state;
    static uint8_t covered[20011];
    memset(covered, 0, sizeof covered);
    for (uint64_t worker = 1; worker <= 3; worker++)
        happen(announcement(worker, (uint32_t)worker));
    want(0, 0, sizeof covered, 1000);
    answer_all(MS / 10, MS / 20);
    for (size_t i = 0; i < desk.sent_count; i++) {
        struct batch_identity batch = desk.sent[i].batch;
        assert_in_range(batch.count, 1, desk.settings.batch_samples_max[VERDICT_DETAIL_FULL]);
        for (uint32_t s = 0; s < batch.count; s++)
            covered[batch.first + s]++;
    }
    for (size_t i = 0; i < sizeof covered; i++)
        assert_int_equal(covered[i], 1);
    assert_int_equal(desk.steps_done, 1);
}

// Two equal workers get near-equal halves of a step of 200, though either could take it all.
static void small_step_is_split_between_two_workers(void **state)
{
    (void)state;
    warm_up(2, 1000);
    want(0, 0, 200, 1000);
    assert_int_equal(desk.sent_count, 2);
    assert_int_not_equal(desk.sent[0].worker, desk.sent[1].worker);
    assert_in_range(desk.sent[0].batch.count, 92, 108);
}

// A worker alone gets the step in one batch: splitting it would only cost messages.
static void small_step_stays_whole_for_one_worker(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 200, 1000);
    assert_int_equal(desk.sent_count, 1);
    assert_int_equal(desk.sent[0].batch.count, 200);
}

// A worker four times as fast gets about four times the share, so that both end together.
static void shares_follow_measured_rates(void **state)
{
    (void)state;
    announce(1);
    announce(2);
    for (uint32_t step = 0; step < 60; step++) {
        want(0, step, 400, 1000);
        while (answered < desk.sent_count) {
            struct sent sent = desk.sent[answered++];
            int64_t service_ns = (sent.worker == 1 ? 500 : 2000) * (int64_t)sent.batch.count;
            if (desk.now_ns < sent.at_ns + service_ns)
                desk.now_ns = sent.at_ns + service_ns;
            answer(sent, service_ns);
        }
    }
    desk.sent_count = 0;
    want(0, 60, 400, 1000);
    uint32_t fast = 0;
    for (size_t i = 0; i < desk.sent_count; i++)
        fast += desk.sent[i].worker == 1 ? desk.sent[i].batch.count : 0;
    assert_in_range(fast, 300, 340);
}

// A batch is sized to take the target time by what was measured, not by what the search guessed.
static void batch_size_follows_measured_time(void **state)
{
    (void)state;
    warm_up(1, 100000); // 100 us a sample: 30 samples fill 3 ms
    want(0, 0, 10000, 1000);
    assert_in_range(desk.sent[0].batch.count, 16, 32);
    assert_in_range(desk.sent_count, 2, 3);
}

// Verdicts that are only shares pack smaller, so their batches may be larger.
static void share_only_batches_are_larger(void **state)
{
    (void)state;
    warm_up(1, 100);
    happen((struct schedule_event){
        .kind = SCHEDULE_EVENT_STEP,
        .step = {.search = 0,
                 .step = 0,
                 .samples = 100000,
                 .detail = VERDICT_DETAIL_SHARE,
                 .sample_ns = 1000},
    });
    assert_in_range(desk.sent[0].batch.count,
                    desk.settings.batch_samples_max[VERDICT_DETAIL_FULL] + 1,
                    desk.settings.batch_samples_max[VERDICT_DETAIL_SHARE]);
}

// As long as nobody knows what a sample takes, batches stay small: the model may be slow.
static void first_batches_are_small_when_nothing_is_known(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 10000, 0);
    assert_in_range(desk.sent[0].batch.count, 1, 64);
}

// A slow model on a worker with many threads: a batch has a vector of samples for each thread,
// however long one takes, else some threads would idle.
static void batch_has_a_vector_for_each_thread(void **state)
{
    (void)state;
    happen(announcement(1, 16));
    want(0, 0, 1000, 1e9);
    assert_int_equal(desk.sent[0].batch.count, 16 * 8);
}

// Two batches are in flight however long they take: one is in work while the other waits.
static void window_holds_two_long_batches(void **state)
{
    (void)state;
    warm_up(1, 1000000);
    want(0, 0, 10000, 1000);
    assert_int_equal(desk.sent_count, 2);
}

// Of a worker that has answered nothing yet no one knows whether its batches are short: it gets
// two.
static void window_holds_two_batches_before_the_first_answer(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 100000, 100);
    assert_int_equal(desk.sent_count, 2);
}

// A model that turns out slow does not end the leases given before that was known: they are worked
// out anew when their time is over.
static void leases_grow_with_what_is_learned(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 64, 0);
    want(1, 0, 64, 0);
    pass(190 * MS);
    answer(desk.sent[0], 190 * MS);
    pass(180 * MS);
    answer(desk.sent[1], 180 * MS);
    assert_int_equal(desk.steps_done, 2);
    assert_int_equal(counters().released, 0);
}

// Short batches need more of them in flight to cover the round trip, up to window_max.
static void window_holds_many_short_batches(void **state)
{
    (void)state;
    warm_up(1, 100);
    want(0, 0, 100000, 1000);
    assert_int_equal(desk.sent_count, desk.settings.window_max);
}

// The same worker's lost batch comes back when its lease is over, with the next attempt.
static void lapsed_lease_returns_to_queue(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 200, 1000);
    assert_int_equal(desk.sent_count, 1);
    pass(desk.settings.lease_min_ns - 1);
    assert_int_equal(desk.sent_count, 1);
    pass(desk.settings.lease_min_ns);
    assert_int_equal(desk.sent_count, 2);
    assert_same_batch(last_sent(0).batch, last_sent(1).batch);
    assert_int_equal(last_sent(0).batch.attempt, 1);
    assert_int_equal(counters().released, 1);
}

// Attempts back off, but not for ever: under heavy loss a batch must not wait for minutes.
static void lease_backs_off_within_bounds(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 200, 1000);
    for (int i = 0; i < 6; i++)
        pass(8 * desk.settings.lease_min_ns + MS);
    announce(1);
    assert_true(desk.sent_count >= 6);
    for (size_t i = 2; i < desk.sent_count; i++) {
        int64_t before_ns = desk.sent[i - 1].at_ns - desk.sent[i - 2].at_ns;
        int64_t ns = desk.sent[i].at_ns - desk.sent[i - 1].at_ns;
        assert_true(ns >= before_ns);
        assert_true(ns <= 8 * desk.settings.lease_min_ns);
    }
}

// A batch that lapsed goes to another worker when there is one: the first may be stuck.
static void lapsed_batch_goes_to_another_worker(void **state)
{
    (void)state;
    warm_up(2, 1000);
    want(0, 0, 32, 1000);
    struct sent first = last_sent(0);
    const size_t count = desk.sent_count;
    for (size_t i = 0; i + 1 < count; i++)
        answer(desk.sent[i], MS / 10);
    pass(3 * desk.settings.lease_min_ns);
    assert_true(desk.sent_count > count);
    assert_same_batch(desk.sent[count].batch, first.batch);
    assert_int_not_equal(desk.sent[count].worker, first.worker);
}

// Leases follow the measured service time: a worker that needs 100 ms a sample is not hurried after
// the least lease.
static void lease_follows_measured_service_time(void **state)
{
    (void)state;
    warm_up(1, 100 * MS);
    want(0, 0, 1, 1000);
    pass(100 * MS);
    assert_int_equal(desk.sent_count, 1);
    answer(desk.sent[0], 100 * MS);
    assert_int_equal(desk.steps_done, 1);
    assert_int_equal(counters().released, 0);
}

// Leases allow for the work that waits at the worker before the batch.
static void lease_allows_for_work_ahead(void **state)
{
    (void)state;
    warm_up(1, 40 * MS);
    want(0, 0, 2, 1000);
    want(1, 0, 2, 1000);
    assert_int_equal(desk.sent_count, 2);
    desk.now_ns += 40 * MS;
    answer(desk.sent[0], 40 * MS);
    pass(40 * MS);
    assert_int_equal(counters().released, 0);
}

// The late outcome of a lapsed lease counts, and the lease that followed ends with it.
static void late_outcome_counts(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 200, 1000);
    struct sent first = last_sent(0);
    pass(3 * desk.settings.lease_min_ns);
    assert_true(desk.sent_count > 1);
    answer(first, MS);
    assert_int_equal(desk.counted, 200);
    assert_int_equal(desk.steps_done, 1);
    assert_int_equal(counters().batches_leased, 0);
    assert_int_equal(desk.effects.wake_ns, desk.now_ns + desk.settings.silence_ns);
}

// A late outcome teaches how long that worker takes: the next lease is longer. Without it a worker
// slower than the least lease would never be waited for.
static void late_outcome_lengthens_the_next_lease(void **state)
{
    (void)state;
    warm_up(1, 1000);
    for (uint32_t step = 0; step < 10; step++) {
        want(0, step, 1, 1000);
        struct sent sent = last_sent(0);
        pass(200 * MS);
        announce(1);
        answer(sent, 200 * MS);
    }
    uint64_t released = counters().released;
    want(0, 10, 1, 1000);
    pass(200 * MS);
    answer(last_sent(0), 200 * MS);
    assert_int_equal(counters().released, released);
    assert_int_equal(desk.steps_done, 11);
}

// An outcome that comes twice counts once, within its step and after it.
static void duplicate_counts_once(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 400, 0);
    struct sent first = desk.sent[0];
    answer(first, MS);
    uint32_t counted = desk.counted;
    answer(first, MS);
    assert_int_equal(desk.counted, counted);
    assert_int_equal(counters().duplicates, 1);
    answered = 1;
    answer_all(MS, MS);
    assert_int_equal(desk.counted, 400);
    answer(first, MS);
    assert_int_equal(desk.counted, 400);
    assert_int_equal(desk.steps_done, 1);
    assert_int_equal(counters().duplicates, 2);
}

// An outcome counts from a worker the roster does not know: its announcements were lost, its work
// is as good.
static void outcome_from_unknown_worker_counts(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 64, 0);
    answer_from(99, desk.sent[0].batch, MS);
    assert_int_equal(desk.counted, 64);
    assert_int_equal(desk.steps_done, 1);
    assert_int_equal(counters().workers, 1);
}

// Outcomes that name no batch of ours, or a batch with other samples, change nothing: a message
// may be forged or from another life of the run.
static void foreign_outcomes_are_ignored(void **state)
{
    (void)state;
    announce(1);
    want(5, 2, 64, 0);
    struct batch_identity good = desk.sent[0].batch;
    struct batch_identity bad[] = {good, good, good, good, good, good};
    bad[0].search++;
    bad[1].step++;
    bad[2].batch++;
    bad[3].first++;
    bad[4].count--;
    bad[5].attempt++;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        answer_from(1, bad[i], MS);
    assert_int_equal(desk.counted, 0);
    assert_int_equal(counters().unknown, sizeof bad / sizeof bad[0]);
    answer_from(1, good, MS);
    assert_int_equal(desk.steps_done, 1);
}

// A service time that no evaluation can have, from a faulty or hostile worker, does not stretch its
// leases beyond what it was seen to take.
static void absurd_service_time_is_bounded_by_what_was_seen(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 64, 1000);
    desk.now_ns += MS;
    answer(desk.sent[0], INT64_MAX);
    want(0, 1, 64, 1000);
    pass(desk.settings.lease_new_ns - MS);
    assert_int_equal(counters().released, 1);
}

// Workers that claim absurd numbers of threads and times get their batches, and so does one that is
// honest: nothing overflows.
static void absurd_claims_starve_nobody(void **state)
{
    (void)state;
    announce(1);
    for (uint64_t worker = 2; worker < 40; worker++)
        happen(announcement(worker, UINT32_MAX));
    for (uint32_t step = 0; step < 20; step++) {
        want(0, step, 100000, 1e12);
        size_t end = desk.sent_count;
        while (answered < end) {
            desk.now_ns += MS;
            answer(desk.sent[answered], desk.sent[answered].worker == 1 ? MS : 0);
            answered++;
        }
    }
    assert_true(sent_to(1) > 0);
    assert_true(sent_to(2) > 0);
}

// Silence ends a worker's leases; its batches go to the others, and a person is told.
static void silent_worker_loses_its_leases(void **state)
{
    (void)state;
    struct schedule_settings settings = schedule_settings_default();
    settings.lease_min_ns = 20 * SECOND; // longer than silence, so that only silence can end them
    desk_reopen(&settings);
    announce(1);
    want(0, 0, 100000, 1000);
    uint32_t held = sent_to(1);
    desk.now_ns += SECOND;
    announce(2);
    uint32_t other = sent_to(2);
    pass(settings.silence_ns - SECOND);
    char line[128];
    snprintf(line, sizeof line,
             "worker host1/1 is silent since 3 s: its %u batches are handed out again", held);
    assert_noted(line);
    assert_int_equal(counters().workers, 1);
    assert_int_equal(counters().released, held);
    answered = held;
    for (uint32_t i = 0; i < other; i++)
        answer(desk.sent[answered++], MS);
    uint32_t again = 0;
    for (size_t i = 0; i < desk.sent_count; i++)
        again += desk.sent[i].worker == 2 && desk.sent[i].batch.attempt == 1;
    assert_int_equal(again, held);
}

// A worker that is heard after its silence is taken back, whatever it says.
static void worker_heard_after_silence_is_taken_back(void **state)
{
    (void)state;
    announce(1);
    pass(desk.settings.silence_ns);
    assert_int_equal(counters().workers, 0);
    announce(1);
    assert_int_equal(counters().workers, 1);
    assert_noted("worker host1/1 is heard again");
    want(0, 0, 64, 0);
    assert_int_equal(sent_to(1), 1);
    pass(desk.settings.silence_ns);
    assert_int_equal(counters().workers, 0);
    answer(desk.sent[0], MS);
    assert_int_equal(counters().workers, 1);
}

// Outcomes are signs of life: a busy worker whose announcements get lost is not silent.
static void outcomes_are_signs_of_life(void **state)
{
    (void)state;
    announce(1);
    for (uint32_t step = 0; step < 10; step++) {
        want(0, step, 64, 0);
        pass(SECOND / 4);
        answer(last_sent(0), MS);
        pass(SECOND / 4);
    }
    assert_int_equal(counters().workers, 1);
    assert_int_equal(desk.steps_done, 10);
}

// A worker that says it leaves hands its batches back at once, and stays away even when an older
// announcement of it arrives after.
static void leaving_worker_hands_back_its_batches(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 64, 0);
    announce(2);
    leave(1);
    assert_noted("worker host1/1 left: its batch is handed out again");
    assert_int_equal(last_sent(0).worker, 2);
    announce(1);
    assert_int_equal(counters().workers, 1);
    want(1, 0, 64, 0);
    assert_int_equal(sent_to(1), 1);
    answer(desk.sent[0], MS);
    assert_int_equal(desk.counted, 64);
}

// A worker that was started anew has another number and another lease; the old one's end with its
// silence.
static void restarted_worker_is_another_one(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 64, 0);
    desk.now_ns += 100 * MS;
    struct schedule_event event = announcement(2, 1);
    strcpy(event.worker.name, "host1/1");
    happen(event);
    assert_int_equal(counters().workers, 2);
    pass(SECOND);
    assert_true(sent_to(2) > 0);
}

// A worker with another kernel is refused, once in words, gets nothing, and its outcomes do not
// count: they might have other bits.
static void other_kernel_is_refused(void **state)
{
    (void)state;
    struct schedule_event event = announcement(1, 4);
    event.worker.acceptable = false;
    happen(event);
    assert_noted("worker host1/1 refused: its kernel or version differs from this coordinator's; "
                 "install the same sobox on both");
    desk.notes[0] = '\0';
    happen(event);
    assert_string_equal(desk.notes, "");
    want(0, 0, 64, 0);
    assert_int_equal(desk.sent_count, 0);
    assert_int_equal(counters().workers, 0);
    assert_int_equal(counters().workers_refused, 1);
    announce(2);
    answer_from(1, desk.sent[0].batch, MS);
    assert_int_equal(desk.counted, 0);
}

// Who joins is announced in words, and what a name brings along cannot command a terminal.
static void joining_is_noted(void **state)
{
    (void)state;
    struct schedule_event event = announcement(7, 16);
    happen(event);
    assert_noted("worker host7/1 joined with 16 threads\n");
    happen(announcement(8, 1));
    assert_noted("worker host8/1 joined with 1 thread\n");
    event = announcement(9, 1);
    strcpy(event.worker.name, "\033[2Jhost\n");
    happen(event);
    assert_noted("worker ?[2Jhost? joined");
}

// When nobody is there a person is told what waits: after a second, because workers that are just
// starting are not there either, and then ever more seldom.
static void waiting_without_workers_is_noted(void **state)
{
    (void)state;
    want(0, 0, 200, 0);
    pass(SECOND - 1);
    assert_string_equal(desk.notes, "");
    pass(1);
    assert_string_equal(desk.notes, "no worker is there: 200 samples wait\n");
    pass(100 * SECOND);
    size_t lines = 0;
    for (const char *at = desk.notes; *at != '\0'; at++)
        lines += *at == '\n';
    assert_in_range(lines, 5, 7);
    desk.notes[0] = '\0';
    announce(1);
    assert_int_equal(desk.sent_count > 0, true);
    assert_string_equal(desk.notes, "worker host1/1 joined with 1 thread\n");
}

// A refused worker is named as the reason when nobody else is there.
static void waiting_with_refused_workers_says_so(void **state)
{
    (void)state;
    struct schedule_event event = announcement(1, 4);
    event.worker.acceptable = false;
    happen(event);
    want(0, 0, 200, 0);
    pass(2 * SECOND);
    assert_noted("no worker is there (1 refused): 200 samples wait");
}

// A late batch is given to an idle worker as well, once; the first of the two to answer counts and
// frees both.
static void idle_worker_copies_late_batch(void **state)
{
    (void)state;
    warm_up(2, 1000);
    want(0, 0, 200, 1000);
    assert_int_equal(desk.sent_count, 2);
    desk.now_ns += MS;
    answer(desk.sent[1], MS / 10);
    pass(desk.settings.lease_min_ns - 2 * MS);
    assert_int_equal(desk.sent_count, 3);
    assert_int_equal(counters().copies, 1);
    assert_int_equal(counters().released, 0);
    assert_same_batch(desk.sent[2].batch, desk.sent[0].batch);
    assert_int_equal(desk.sent[2].worker, desk.sent[1].worker);
    answer(desk.sent[2], MS / 10);
    assert_int_equal(desk.steps_done, 1);
    assert_int_equal(counters().batches_leased, 0);
    answer(desk.sent[0], MS / 10);
    assert_int_equal(counters().duplicates, 1);
    assert_int_equal(desk.counted, 200);
}

// A busy cluster makes no copies: they would take the place of other work.
static void busy_workers_make_no_copies(void **state)
{
    (void)state;
    warm_up(2, 1000);
    for (uint32_t search = 0; search < 100; search++)
        want(search, 0, 400, 1000);
    pass(desk.settings.lease_min_ns - MS);
    assert_int_equal(counters().copies, 0);
}

// A hiccup of some milliseconds makes no copies while little is known of a worker, and later one
// below a quarter of the least lease.
static void short_hiccup_makes_no_copies(void **state)
{
    (void)state;
    announce(1);
    announce(2);
    want(0, 0, 200, 1000);
    desk.now_ns += MS / 10;
    answer(desk.sent[0], MS / 10);
    answer(desk.sent[1], MS / 10);
    answer_all(0, MS / 10);
    want(0, 1, 200, 1000);
    answer(last_sent(0), MS / 10);
    const size_t count = desk.sent_count;
    pass(3 * MS);
    assert_int_equal(desk.sent_count, count);
    desk_close(NULL);
    desk_open(NULL);
    warm_up(2, 1000);
    want(0, 0, 200, 1000);
    answer(desk.sent[1], MS / 10);
    pass(desk.settings.lease_min_ns / 4 - 1);
    assert_int_equal(desk.sent_count, 2);
}

// Two workers do 2000 steps; every fifth answer of worker 1 comes 3 ms late or, where `lost`,
// never. Returns how many copies that took.
static uint64_t copies_where_every_fifth_answer_is_late(bool lost)
{
    warm_up(2, 1000);
    uint32_t asked = 0;
    for (uint32_t step = 0; step < 2000; step++) {
        announce(1);
        announce(2);
        want(0, step, 200, 1000);
        desk.now_ns += MS / 5;
        struct sent late = {0};
        while (desk.steps_done <= step) {
            for (; answered < desk.sent_count; answered++) {
                const struct sent sent = desk.sent[answered];
                if (sent.worker == 1 && ++asked % 5 == 0)
                    late = sent;
                else
                    answer(sent, MS / 10);
            }
            if (desk.steps_done > step)
                break;
            pass(lost ? MS / 4 : 3 * MS);
            if (!lost)
                answer(late, MS / 10);
        }
        if (!lost && late.worker != 0 && desk.now_ns < late.at_ns + 3 * MS) {
            pass(late.at_ns + 3 * MS - desk.now_ns);
            answer(late, MS / 10);
        }
        desk.sent_count = answered = 0;
    }
    return counters().copies + counters().released;
}

// Where machines are unsteady and nothing gets lost, copies are for nothing: leases become longer
// until they are few.
static void copies_for_nothing_stay_few(void **state)
{
    (void)state;
    assert_true(copies_where_every_fifth_answer_is_late(false) < 2000 / 11 + 20);
}

// Where answers get lost, leases stay short and copies are made.
static void copies_for_lost_answers_are_made_soon(void **state)
{
    (void)state;
    const int64_t start_ns = desk.now_ns;
    assert_true(copies_where_every_fifth_answer_is_late(true) > 300);
    assert_true(desk.now_ns - start_ns < 2000 * MS);
}

// One hiccup of a worker known to be quick does not make its next losses cost as much.
static void hiccup_is_forgotten_soon(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 200, 1000);
    desk.effects.wake_ns = 0; // nobody looks at the clock
    desk.now_ns += 100 * MS;
    answer(desk.sent[0], MS / 5);
    for (uint32_t step = 1; step <= 5; step++) {
        want(0, step, 200, 1000);
        desk.now_ns += MS / 5;
        answer(last_sent(0), MS / 5);
    }
    want(0, 6, 200, 1000);
    const size_t count = desk.sent_count;
    pass(8 * MS);
    assert_true(desk.sent_count > count);
}

// What comes back after more attempts than are remembered still teaches that leases are too short:
// without it a worker whose network became slow would be sent everything twenty times for ever.
static void answer_to_a_forgotten_attempt_teaches(void **state)
{
    (void)state;
    warm_up(1, 1000);
    uint32_t sent = 0;
    for (uint32_t step = 0; step < 30; step++) {
        const size_t first = desk.sent_count;
        want(0, step, 1, 1000);
        pass(200 * MS);
        announce(1);
        answer(desk.sent[first], MS / 10);
        sent = (uint32_t)(desk.sent_count - first);
        if (step == 0)
            assert_true(sent > 4);
    }
    assert_int_equal(sent, 1);
}

// Where all workers wait for what got lost, each takes a copy of another's: nobody is idle by the
// book, and all are.
static void workers_whose_batches_are_late_copy_each_others(void **state)
{
    (void)state;
    warm_up(2, 1000);
    want(0, 0, 200, 1000);
    assert_int_equal(desk.sent_count, 2);
    pass(desk.settings.lease_min_ns - 1);
    assert_int_equal(counters().copies, 2);
    assert_int_equal(counters().released, 0);
    assert_int_equal(desk.sent_count, 4);
    for (size_t i = 2; i < 4; i++) {
        const struct sent copy = desk.sent[i];
        const struct sent original = desk.sent[copy.batch.batch];
        assert_same_batch(copy.batch, original.batch);
        assert_int_not_equal(copy.worker, original.worker);
    }
}

// A worker's last word of what it has does not outlast what it was leased: when the outcome after
// it gets lost the worker would look busy until its next announcement.
static void lost_outcome_leaves_no_worker_busy(void **state)
{
    (void)state;
    warm_up(2, 1000);
    want(0, 0, 200, 1000);
    want(1, 0, 200, 1000);
    // Worker 1 answers one of its two batches, with the other one waiting.
    struct schedule_event event = {
        .kind = SCHEDULE_EVENT_OUTCOME,
        .outcome = {.worker = 1, .queue = 1, .service_ns = MS / 10},
    };
    uint32_t others = 0;
    for (size_t i = 0; i < 4; i++) {
        if (desk.sent[i].worker == 1 && event.outcome.batch.count == 0)
            event.outcome.batch = desk.sent[i].batch;
        others += desk.sent[i].worker == 2;
    }
    assert_int_equal(others, 2);
    desk.now_ns += MS / 10;
    happen(event);
    // The other one is handed out again: to worker 2, or, when its turn comes, to worker 1 itself,
    // and worker 2's late ones go to worker 1.
    pass(desk.settings.lease_min_ns);
    uint32_t copies_to_1 = 0;
    for (size_t i = 4; i < desk.sent_count; i++)
        copies_to_1 += desk.sent[i].worker == 1;
    assert_true(copies_to_1 > 0);
}

// When three later batches of the same worker are answered, an earlier one is lost and handed out
// again at once: waiting for its lease would cost fifty times as long.
static void overtaken_batch_is_handed_out_again(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 100000, 1000);
    assert_true(desk.sent_count >= 4);
    struct sent lost = desk.sent[0];
    for (size_t i = 1; i <= 3; i++) {
        desk.now_ns += MS / 2;
        answer(desk.sent[i], MS / 2);
        assert_int_equal(counters().released, i == 3 ? 1 : 0);
    }
    bool again = false;
    for (size_t i = 4; i < desk.sent_count; i++)
        again |= desk.sent[i].batch.batch == lost.batch.batch;
    assert_true(again);
}

// A worker that hangs gets one batch at a time and only when nobody else has room, instead of
// drawing every batch that is handed out again.
static void stalled_worker_is_avoided(void **state)
{
    (void)state;
    warm_up(2, 100000);
    want(0, 0, 100000, 1000);
    // Worker 2 answers, worker 1 does not.
    for (int i = 0; i < 400; i++) {
        pass(MS);
        struct sent oldest = {0};
        for (; answered < desk.sent_count && oldest.worker == 0; answered++) {
            if (desk.sent[answered].worker == 2)
                oldest = desk.sent[answered];
        }
        if (oldest.worker != 0)
            answer(oldest, 3 * MS);
    }
    assert_in_range(sent_to(1), 2, 24);
    assert_true(sent_to(2) > 100);
    // It says that it has nothing to do: what it was given got lost, so it is trusted again.
    uint32_t before = sent_to(1);
    announce(1);
    announce(1);
    for (int i = 0; i < 10; i++)
        answer(last_sent(0), MS);
    assert_true(sent_to(1) > before);
}

// A worker that was killed holds up a few small steps, not every one until its silence is long
// enough: when copies answer in its place, it is stalled too.
static void killed_worker_holds_up_few_steps(void **state)
{
    (void)state;
    warm_up(2, 1000);
    int64_t start_ns = desk.now_ns;
    for (uint32_t step = 0; step < 100; step++) {
        want(0, step, 200, 1000);
        while (desk.steps_done <= step) {
            pass(MS);
            for (; answered < desk.sent_count; answered++) {
                if (desk.sent[answered].worker == 2)
                    answer(desk.sent[answered], MS / 10);
            }
        }
    }
    assert_in_range(sent_to(1), 3, 4);
    assert_true(desk.now_ns - start_ns < 200 * MS);
    // An announcement that it is there with nothing to do brings it back.
    announce(1);
    uint32_t before = sent_to(1);
    want(0, 100, 200, 1000);
    assert_int_equal(sent_to(1), before + 1);
}

// A stalled worker that is idle may prove itself on a copy of a late batch.
static void stalled_worker_proves_itself_on_a_copy(void **state)
{
    (void)state;
    warm_up(2, 1000);
    for (uint32_t step = 0; step < 3; step++) {
        desk.now_ns += MS;
        want(0, step, 200, 1000);
        pass(20 * MS);
        // Worker 2 answers its own part, then the copy that it is given at once.
        for (; answered < desk.sent_count; answered++) {
            if (desk.sent[answered].worker == 2)
                answer(desk.sent[answered], MS / 10);
        }
    }
    assert_int_equal(desk.steps_done, 3);
    want(0, 3, 200, 1000);
    assert_int_equal(last_sent(0).worker, 2);
    assert_int_equal(last_sent(0).batch.count, 200);
    pass(50 * MS);
    assert_int_equal(last_sent(0).worker, 1);
    answer(last_sent(0), MS / 5);
    assert_int_equal(desk.steps_done, 4);
    want(0, 4, 200, 1000);
    assert_true(last_sent(0).batch.count < 200);
}

// A coordinator that was stopped for a minute does not blame its workers: their outcomes and
// announcements of that time still wait to be read.
static void own_pause_is_not_held_against_workers(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 200, 1000);
    desk.now_ns += 60 * SECOND;
    tick();
    assert_int_equal(counters().released, 0);
    assert_int_equal(counters().workers, 1);
    answer(desk.sent[0], MS / 5);
    assert_int_equal(desk.steps_done, 1);
    assert_true(desk.effects.wake_ns > desk.now_ns);
    // But when nothing comes after all, leases end as ever.
    want(0, 1, 200, 1000);
    desk.now_ns += 60 * SECOND;
    tick();
    pass(SECOND);
    assert_true(counters().released > 0);
}

// A cancelled step leaves nothing behind: no lease, no work, no outcome that counts.
static void cancelled_step_leaves_nothing(void **state)
{
    (void)state;
    announce(1);
    want(0, 0, 100000, 1000);
    happen((struct schedule_event){.kind = SCHEDULE_EVENT_CANCEL, .cancel = {.search = 0}});
    assert_int_equal(counters().batches_leased, 0);
    assert_int_equal(counters().batches_waiting, 0);
    answer(desk.sent[0], MS);
    assert_int_equal(desk.counted, 0);
    assert_int_equal(counters().unknown, 1);
    assert_int_equal(desk.effects.wake_ns, desk.now_ns + desk.settings.silence_ns);
    want(1, 0, 64, 1000);
    assert_int_equal(last_sent(0).batch.search, 1);
}

// Every search gets its turn: one with huge steps does not hold up a small one.
static void huge_step_does_not_hold_up_small_ones(void **state)
{
    (void)state;
    warm_up(1, 1000);
    want(0, 0, 1000000, 1000);
    for (uint32_t search = 1; search <= 5; search++)
        want(search, 0, 200, 1000);
    uint32_t events = 0;
    while (desk.steps_done < 5) {
        desk.now_ns += MS / 2;
        answer(desk.sent[answered++], MS / 2);
        assert_true(++events < 40);
    }
}

// With as many open steps as workers nobody splits them: whole steps cost fewer messages.
static void many_steps_are_not_split(void **state)
{
    (void)state;
    warm_up(2, 1000);
    for (uint32_t search = 0; search < 50; search++)
        want(search, 0, 200, 1000);
    desk.sent_count = answered = 0;
    for (int i = 0; i < 8; i++) {
        want(100 + (uint32_t)i, 0, 200, 1000);
        answer_all(MS / 5, MS / 5);
    }
    for (size_t i = 0; i + 8 < desk.sent_count && i < 20; i++)
        assert_int_equal(desk.sent[i].batch.count, 200);
}

// Nothing is due when nothing goes on, and the next deadline is asked for when something does.
static void wake_is_the_nearest_deadline(void **state)
{
    (void)state;
    tick();
    assert_true(desk.effects.wake_ns == INT64_MAX);
    want(0, 0, 64, 0);
    assert_int_equal(desk.effects.wake_ns, desk.now_ns + SECOND);
    announce(1);
    assert_true(desk.effects.wake_ns < desk.now_ns + SECOND);
    answer(desk.sent[0], MS);
    assert_int_equal(desk.effects.wake_ns, desk.now_ns + desk.settings.silence_ns);
    leave(1);
    assert_true(desk.effects.wake_ns == INT64_MAX);
}

// Strangers that announce themselves by the hundred thousand neither fill the memory nor push out
// workers that are there.
static void roster_is_bounded(void **state)
{
    (void)state;
    announce(1);
    struct schedule_event event = announcement(1, 1);
    event.worker.acceptable = false;
    for (uint64_t id = 2; id < 200000; id++) {
        event.worker.id = id;
        event.now_ns = desk.now_ns;
        schedule_step(desk.schedule, &event, &desk.effects);
    }
    assert_int_equal(counters().workers, 1);
    assert_int_equal(counters().workers_refused, 65535);
}

// Ten thousand searches over a thousand workers, with every tenth outcome lost and every tenth sent
// twice: all samples are counted, nothing stays leased.
static void ten_thousand_searches_over_a_thousand_workers(void **state)
{
    (void)state;
    for (uint64_t worker = 1; worker <= 1000; worker++)
        announce(worker);
    for (uint32_t search = 0; search < 10000; search++)
        want(search, 0, 200, 1000);
    for (uint32_t i = 0; desk.steps_done < 10000; i++) {
        if (answered == desk.sent_count) {
            pass(100 * MS);
            for (uint64_t worker = 1; worker <= 1000; worker++)
                announce(worker);
            continue;
        }
        struct sent sent = desk.sent[answered++];
        desk.now_ns += 200;
        if (i % 10 != 3)
            answer(sent, MS / 5);
        if (i % 10 == 5)
            answer(sent, MS / 5);
    }
    assert_int_equal(desk.counted, 2000000);
    assert_int_equal(counters().batches_leased, 0);
    assert_int_equal(counters().batches_waiting, 0);
}

// The counts of the batches sent, but for the last of each step, which is what is left.
static void assert_counts(uint32_t least, uint32_t most)
{
    for (size_t i = 0; i < desk.sent_count; i++) {
        const struct batch_identity *batch = &desk.sent[i].batch;
        const bool last = i + 1 == desk.sent_count || desk.sent[i + 1].batch.step != batch->step ||
                          desk.sent[i + 1].batch.search != batch->search;
        if (!last)
            assert_in_range(batch->count, least, most);
    }
}

// A hundred workers and one search: a step of 2,000 samples of 1 us could be split into a hundred
// parts of 20 us, and their messages would take a hundred times as long as one of them. Parts worth
// sqrt(2 ms x 20 us) = 200 us are ten, and their messages as long as they are.
static void step_of_one_search_is_split_as_far_as_messages_are_worth_it(void **state)
{
    (void)state;
    desk.settings.message_ns = 20000;
    desk_reopen(&desk.settings);
    for (uint64_t worker = 1; worker <= 100; worker++)
        announce(worker);
    want(0, 0, 2000, 1000);
    assert_in_range(desk.sent_count, 9, 11);
    assert_counts(200, 208);
}

// A hundred workers and many searches: with half of its time the loop can send a batch to each
// worker in 4 ms, so that is what a batch should take, though fewer steps are open than there are
// workers.
static void batches_of_many_searches_are_worth_a_message_for_each_worker(void **state)
{
    (void)state;
    desk.settings.message_ns = 20000;
    desk.settings.batch_samples_max[VERDICT_DETAIL_FULL] = 10000;
    desk_reopen(&desk.settings);
    for (uint64_t worker = 1; worker <= 100; worker++)
        announce(worker);
    for (uint32_t search = 0; search < 20; search++)
        want(search, 0, 20, 1000);
    const size_t before = desk.sent_count;
    for (uint32_t search = 20; search < 23; search++)
        want(search, 0, 20000, 1000);
    assert_in_range(desk.sent_count - before, 12, 18);
    for (size_t i = before; i < desk.sent_count; i++)
        assert_in_range(desk.sent[i].batch.count, 2000, 6000);
}

// Thousands of workers: the time a batch should take grows with them, beyond batch_target_ns.
static void batches_grow_with_the_workers(void **state)
{
    (void)state;
    desk.settings.message_ns = 20000;
    desk.settings.batch_samples_max[VERDICT_DETAIL_FULL] = 65536;
    desk_reopen(&desk.settings);
    for (uint64_t worker = 1; worker <= 1000; worker++)
        announce(worker);
    for (uint32_t search = 0; search < 1000; search++)
        want(search, 0, 100, 1000);
    const size_t before = desk.sent_count;
    for (uint32_t search = 1000; search < 2000; search++)
        want(search, 0, 60000, 1000);
    assert_true(desk.sent_count > before);
    for (size_t i = before; i < desk.sent_count; i++)
        assert_in_range(desk.sent[i].batch.count, 20000, 40000);
}

// Small batches of a slow model on many threads: a vector of samples is computed by one thread, so
// more than two such batches must be there for all threads to have one, and as many wait.
static void window_holds_vectors_for_all_threads(void **state)
{
    (void)state;
    happen(announcement(1, 16));
    want(0, 0, 8, 0);
    desk.now_ns += 16 * MS;
    answer(desk.sent[0], 16 * MS);
    for (uint32_t search = 1; search <= 60; search++)
        want(search, 0, 8, 0);
    assert_int_equal(desk.sent_count, 1 + 2 * 16);
}

// Thousands of workers announce themselves less often, so that they do not drown in each other's
// announcements: none of them is taken for silent meanwhile, and a dead one is all the same.
static void thousands_of_workers_may_be_silent_for_longer(void **state)
{
    (void)state;
    for (uint64_t worker = 1; worker <= 2000; worker++)
        announce(worker);
    pass(3 * 4 * SECOND);
    assert_int_equal(counters().workers, 2000);
    for (uint64_t worker = 2; worker <= 2000; worker++)
        announce(worker);
    pass(24 * SECOND);
    announce(2);
    assert_true(strstr(desk.notes, "host1/1 is silent") != NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define TEST(name) cmocka_unit_test_setup_teardown(name, desk_open, desk_close)
        TEST(step_of_one_search_is_split_as_far_as_messages_are_worth_it),
        TEST(batches_of_many_searches_are_worth_a_message_for_each_worker),
        TEST(batches_grow_with_the_workers),
        TEST(window_holds_vectors_for_all_threads),
        TEST(thousands_of_workers_may_be_silent_for_longer),
        TEST(step_is_done_when_all_samples_are_counted),
        TEST(batches_cover_the_step_once),
        TEST(small_step_is_split_between_two_workers),
        TEST(small_step_stays_whole_for_one_worker),
        TEST(shares_follow_measured_rates),
        TEST(batch_size_follows_measured_time),
        TEST(share_only_batches_are_larger),
        TEST(first_batches_are_small_when_nothing_is_known),
        TEST(batch_has_a_vector_for_each_thread),
        TEST(window_holds_two_long_batches),
        TEST(window_holds_two_batches_before_the_first_answer),
        TEST(leases_grow_with_what_is_learned),
        TEST(window_holds_many_short_batches),
        TEST(lapsed_lease_returns_to_queue),
        TEST(lease_backs_off_within_bounds),
        TEST(lapsed_batch_goes_to_another_worker),
        TEST(lease_follows_measured_service_time),
        TEST(lease_allows_for_work_ahead),
        TEST(late_outcome_counts),
        TEST(late_outcome_lengthens_the_next_lease),
        TEST(duplicate_counts_once),
        TEST(outcome_from_unknown_worker_counts),
        TEST(foreign_outcomes_are_ignored),
        TEST(absurd_service_time_is_bounded_by_what_was_seen),
        TEST(absurd_claims_starve_nobody),
        TEST(silent_worker_loses_its_leases),
        TEST(worker_heard_after_silence_is_taken_back),
        TEST(outcomes_are_signs_of_life),
        TEST(leaving_worker_hands_back_its_batches),
        TEST(restarted_worker_is_another_one),
        TEST(other_kernel_is_refused),
        TEST(joining_is_noted),
        TEST(waiting_without_workers_is_noted),
        TEST(waiting_with_refused_workers_says_so),
        TEST(idle_worker_copies_late_batch),
        TEST(busy_workers_make_no_copies),
        TEST(short_hiccup_makes_no_copies),
        TEST(copies_for_nothing_stay_few),
        TEST(copies_for_lost_answers_are_made_soon),
        TEST(hiccup_is_forgotten_soon),
        TEST(answer_to_a_forgotten_attempt_teaches),
        TEST(workers_whose_batches_are_late_copy_each_others),
        TEST(lost_outcome_leaves_no_worker_busy),
        TEST(overtaken_batch_is_handed_out_again),
        TEST(stalled_worker_is_avoided),
        TEST(killed_worker_holds_up_few_steps),
        TEST(stalled_worker_proves_itself_on_a_copy),
        TEST(own_pause_is_not_held_against_workers),
        TEST(cancelled_step_leaves_nothing),
        TEST(huge_step_does_not_hold_up_small_ones),
        TEST(many_steps_are_not_split),
        TEST(wake_is_the_nearest_deadline),
        TEST(roster_is_bounded),
        TEST(ten_thousand_searches_over_a_thousand_workers),
    };
    return cmocka_run_group_tests_name("schedule", tests, NULL, NULL);
}
