// The dispatcher: what its user is asked to do, and in which order.
#include "coordinator/dispatch/dispatcher.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

enum {
    WORKER = 7,
    SAMPLES = 100,
    PIECE_SIZE = 10, // [bytes]
    PIECES_MAX = 80,
    SENT_MAX = 16,
};

static const int64_t SECOND_NS = 1000000000;

// A user that writes down what it is asked.
struct user {
    struct dispatcher *dispatcher;
    int64_t now_ns;
    struct batch_identity sent[SENT_MAX];
    uint64_t sent_to[SENT_MAX];
    uint32_t sent_count;
    uint32_t counted; // samples
    uint32_t finished;
    uint32_t finished_step;
    uint32_t counted_before; // samples that were counted when the step was finished
    uint32_t steps_left;     // that the user wants as soon as one is finished
    uint32_t notes;
    struct text_piece pieces[PIECES_MAX];
    uint32_t piece_count;
};

static void want_step(struct user *user, uint32_t step)
{
    dispatcher_take(user->dispatcher,
                    &(struct schedule_event){.kind = SCHEDULE_EVENT_STEP,
                                             .now_ns = user->now_ns,
                                             .step = {.step = step, .samples = SAMPLES}});
}

static void send(void *context, uint64_t worker, const struct batch_identity *batch)
{
    struct user *user = context;
    assert_true(user->sent_count < SENT_MAX);
    user->sent_to[user->sent_count] = worker;
    user->sent[user->sent_count++] = *batch;
}

static void count(void *context, const struct batch_identity *batch)
{
    ((struct user *)context)->counted += batch->count;
}

static void finished(void *context, uint32_t search, uint32_t step)
{
    struct user *user = context;
    assert_int_equal(search, 0);
    user->finished++;
    user->finished_step = step;
    user->counted_before = user->counted;
    if (user->steps_left > 0) {
        user->steps_left--;
        want_step(user, step + 1);
    }
}

static void piece(void *context, const struct text_piece *text)
{
    struct user *user = context;
    assert_true(user->piece_count < PIECES_MAX);
    user->pieces[user->piece_count++] = *text;
}

static void note(void *context, const char *text)
{
    assert_true(strlen(text) > 0);
    ((struct user *)context)->notes++;
}

static int setup(void **state)
{
    static const struct dispatcher_calls calls = {
        .send = send, .count = count, .finished = finished, .piece = piece, .note = note};
    static struct user user;
    const struct schedule_settings settings = schedule_settings_default();
    user = (struct user){.now_ns = SECOND_NS};
    user.dispatcher = dispatcher_create(&settings, PIECE_SIZE, &calls, &user);
    *state = &user;
    return 0;
}

static int teardown(void **state)
{
    dispatcher_free(((struct user *)*state)->dispatcher);
    return 0;
}

static void announce(struct user *user, uint64_t worker, bool acceptable)
{
    dispatcher_take(
        user->dispatcher,
        &(struct schedule_event){
            .kind = SCHEDULE_EVENT_WORKER,
            .now_ns = user->now_ns,
            .worker = {.id = worker, .threads = 1, .acceptable = acceptable, .name = "host/1"}});
}

// The worker answers the batch that was sent as the `index`-th.
static void answer(struct user *user, uint32_t index)
{
    user->now_ns += 1000;
    dispatcher_take(user->dispatcher,
                    &(struct schedule_event){.kind = SCHEDULE_EVENT_OUTCOME,
                                             .now_ns = user->now_ns,
                                             .outcome = {.worker = user->sent_to[index],
                                                         .batch = user->sent[index],
                                                         .service_ns = 1000}});
}

// Answers all that is sent, also what is sent meanwhile, up to a number of batches.
static void answer_from(struct user *user, uint32_t first, uint32_t batches)
{
    for (uint32_t i = first; i < user->sent_count && i < first + batches; i++)
        answer(user, i);
}

// ---- Work ----

// A step waits until somebody is there; then its batches are sent and leased.
static void step_is_sent_when_a_worker_comes(void **state)
{
    struct user *user = *state;
    want_step(user, 1);
    assert_int_equal(user->sent_count, 0);
    announce(user, WORKER, true);
    assert_true(user->sent_count > 0);
    assert_int_equal(user->sent_to[0], WORKER);
    assert_int_equal(user->sent[0].step, 1);
    struct schedule_counters counters;
    dispatcher_counters(user->dispatcher, &counters);
    assert_int_equal(counters.workers, 1);
    assert_int_equal(counters.batches_leased, user->sent_count);
}

// A worker of another version gets nothing, and a person is told why.
static void worker_of_another_version_gets_nothing(void **state)
{
    struct user *user = *state;
    want_step(user, 1);
    announce(user, WORKER, false);
    assert_int_equal(user->sent_count, 0);
    assert_int_equal(user->notes, 1);
}

// The user hears that a step is finished once, after its last outcome has been counted.
static void step_is_finished_after_its_last_outcome_is_counted(void **state)
{
    struct user *user = *state;
    announce(user, WORKER, true);
    want_step(user, 1);
    answer_from(user, 0, SENT_MAX);
    assert_int_equal(user->counted, SAMPLES);
    assert_int_equal(user->finished, 1);
    assert_int_equal(user->finished_step, 1);
    assert_int_equal(user->counted_before, SAMPLES);
}

// The same outcome twice counts once, as LCM may deliver a packet twice.
static void doubled_outcome_counts_once(void **state)
{
    struct user *user = *state;
    announce(user, WORKER, true);
    want_step(user, 1);
    answer(user, 0);
    const uint32_t counted = user->counted;
    assert_true(counted > 0);
    answer(user, 0);
    assert_int_equal(user->counted, counted);
}

// A user asks for the next step from within finished(), and it is sent: the list of effects is not
// overwritten while it is being carried out.
static void next_step_may_be_wanted_when_one_is_finished(void **state)
{
    struct user *user = *state;
    user->steps_left = 1;
    announce(user, WORKER, true);
    want_step(user, 1);
    answer_from(user, 0, SENT_MAX);
    assert_int_equal(user->finished, 2);
    assert_int_equal(user->finished_step, 2);
    assert_int_equal(user->counted, 2 * SAMPLES);
}

// A lease that lapses brings its batch back: at the time that the dispatcher named, a tick sends it
// to the worker that is left.
static void tick_brings_back_what_a_silent_worker_holds(void **state)
{
    struct user *user = *state;
    announce(user, WORKER, true);
    want_step(user, 1);
    const uint32_t sent = user->sent_count;
    assert_true(dispatcher_wake_ns(user->dispatcher) > user->now_ns);
    for (int i = 0; i < 1000 && user->sent_count == sent; i++) {
        const int64_t wake_ns = dispatcher_wake_ns(user->dispatcher);
        assert_true(wake_ns < INT64_MAX);
        user->now_ns = wake_ns;
        announce(user, WORKER + 1, true);
        dispatcher_take(user->dispatcher, &(struct schedule_event){.kind = SCHEDULE_EVENT_TICK,
                                                                   .now_ns = user->now_ns});
    }
    assert_true(user->sent_count > sent);
    assert_int_equal(user->sent_to[sent], WORKER + 1);
    assert_int_equal(user->sent[sent].first, user->sent[0].first);
}

// Nothing is due while nothing is wanted and nobody is known.
static void nothing_is_due_at_first(void **state)
{
    const struct user *user = *state;
    assert_true(dispatcher_wake_ns(user->dispatcher) == INT64_MAX);
}

// ---- Texts ----

static const char text[] = "front rails and spring domes"; // 29 bytes: three pieces

// A text arrives in pieces that cover it without gap and overlap.
static void text_leaves_in_pieces(void **state)
{
    struct user *user = *state;
    const struct digest digest = digest_of(text, sizeof text);
    text_server_offer(dispatcher_texts(user->dispatcher), &digest, text, sizeof text);
    dispatcher_request(user->dispatcher, &digest, 0, user->now_ns);
    assert_int_equal(user->piece_count, 3);
    size_t offset = 0;
    for (uint32_t i = 0; i < user->piece_count; i++) {
        assert_true(digest_equal(&user->pieces[i].digest, &digest));
        assert_int_equal(user->pieces[i].total, sizeof text);
        assert_int_equal(user->pieces[i].offset, offset);
        assert_memory_equal(user->pieces[i].bytes, text + offset, user->pieces[i].size);
        offset += user->pieces[i].size;
    }
    assert_int_equal(offset, sizeof text);
}

// A worker that lost the end asks from there on, and gets the end alone.
static void text_is_sent_from_where_it_is_asked(void **state)
{
    struct user *user = *state;
    const struct digest digest = digest_of(text, sizeof text);
    text_server_offer(dispatcher_texts(user->dispatcher), &digest, text, sizeof text);
    dispatcher_request(user->dispatcher, &digest, 2 * PIECE_SIZE, user->now_ns);
    assert_int_equal(user->piece_count, 1);
    assert_int_equal(user->pieces[0].offset, 2 * PIECE_SIZE);
}

// A hundred workers that ask for the same text at once cause one sending of it; a later request is
// answered again, because the first answer may have been lost.
static void same_text_is_not_repeated_at_once(void **state)
{
    struct user *user = *state;
    const struct digest digest = digest_of(text, sizeof text);
    text_server_offer(dispatcher_texts(user->dispatcher), &digest, text, sizeof text);
    for (int worker = 0; worker < 100; worker++)
        dispatcher_request(user->dispatcher, &digest, 0, user->now_ns + worker);
    assert_int_equal(user->piece_count, 3);
    dispatcher_request(user->dispatcher, &digest, 0, user->now_ns + SECOND_NS);
    assert_int_equal(user->piece_count, 6);
}

// One request brings a bounded burst, whatever the text's size: a socket's buffer is bounded too.
static void long_text_is_sent_in_bursts(void **state)
{
    struct user *user = *state;
    static char long_text[10000];
    memset(long_text, 'a', sizeof long_text);
    const struct digest digest = digest_of(long_text, sizeof long_text);
    text_server_offer(dispatcher_texts(user->dispatcher), &digest, long_text, sizeof long_text);
    dispatcher_request(user->dispatcher, &digest, 0, user->now_ns);
    assert_int_equal(user->piece_count, 64);
}

// A text that is not offered, or no longer, is not answered.
static void unknown_text_is_not_answered(void **state)
{
    struct user *user = *state;
    const struct digest digest = digest_of(text, sizeof text);
    dispatcher_request(user->dispatcher, &digest, 0, user->now_ns);
    text_server_offer(dispatcher_texts(user->dispatcher), &digest, text, sizeof text);
    text_server_withdraw(dispatcher_texts(user->dispatcher), &digest);
    dispatcher_request(user->dispatcher, &digest, 0, user->now_ns);
    assert_int_equal(user->piece_count, 0);
}

#define WITH_USER(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_USER(step_is_sent_when_a_worker_comes),
        WITH_USER(worker_of_another_version_gets_nothing),
        WITH_USER(step_is_finished_after_its_last_outcome_is_counted),
        WITH_USER(doubled_outcome_counts_once),
        WITH_USER(next_step_may_be_wanted_when_one_is_finished),
        WITH_USER(tick_brings_back_what_a_silent_worker_holds),
        WITH_USER(nothing_is_due_at_first),
        WITH_USER(text_leaves_in_pieces),
        WITH_USER(text_is_sent_from_where_it_is_asked),
        WITH_USER(same_text_is_not_repeated_at_once),
        WITH_USER(long_text_is_sent_in_bursts),
        WITH_USER(unknown_text_is_not_answered),
    };
    return cmocka_run_group_tests_name("dispatcher", tests, NULL, NULL);
}
