// A worker over memq://, and in the same main context a coordinator of a few lines that sends
// batches, answers (or loses) requests for texts and keeps what it hears.
#include "worker/runtime/worker.h"

#include "common/scenario/scenario_read.h"
#include "common/wire/source.h"
#include "sobox_outcome_batch_t.h"
#include "sobox_run_status_t.h"
#include "sobox_sample_batch_t.h"
#include "sobox_text_request_t.h"
#include "sobox_text_t.h"
#include "sobox_worker_status_t.h"
#include "worker/batch/batch.h"
#include "worker/batch/fingerprint.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum {
    SENDER = 4711, // of the wire that both share
    RUN = 12,
    COUNT = 200,   // samples of a batch
    BATCHES = 100, // of a step
    PIECE = 50,    // [bytes] of a text
};

static const char yaml[] = "name: runtime\n"
                           "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                           "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                           "springs:\n"
                           "  - name: front\n"
                           "    position: [-0.83, -0.75]\n"
                           "    deformation: [0.0, 0.6, 1.2]\n"
                           "    force_x: {lower: 0, upper: [80e3, 450e3, 450e3]}\n"
                           "    force_y: {lower: 0, upper: 250e3}\n"
                           "response: any\n"
                           "firewall_distance: 0.25\n";

struct coordinator {
    struct wire *wire;
    struct worker *worker;
    struct scenario scenario;
    struct digest scenario_digest;
    struct digest box_digest;
    double *bounds; // (bound_count)
    uint32_t bound_count;

    bool mute;       // loses requests
    int lose_pieces; // how many of the next pieces are lost
    uint32_t requests;
    uint32_t statuses;
    sobox_worker_status_t status; // the last
    uint32_t outcomes;
    uint32_t outcomes_of[BATCHES];
    bool wrong; // an outcome was not that of its batch
};

// ---- The coordinator ----

static struct batch batch_of(uint32_t index)
{
    return (struct batch){
        .sampling = {.seed = 3, .step = 4, .samples = BATCHES * COUNT},
        .first = index * COUNT,
        .count = COUNT,
    };
}

static void send_batch_to(struct coordinator *coordinator, uint32_t index, bool with_bounds,
                          int64_t holder)
{
    struct batch batch = batch_of(index);
    sobox_sample_batch_t message = {
        .header.run = RUN,
        .holder = holder,
        .seed = (int64_t)batch.sampling.seed,
        .batch = {.search = 1,
                  .step = (int32_t)batch.sampling.step,
                  .batch = (int32_t)index,
                  .first = (int32_t)batch.first,
                  .count = (int32_t)batch.count},
        .step_samples = (int32_t)batch.sampling.samples,
        .sampling = SAMPLING_METHOD_UNIFORM,
        .detail = VERDICT_DETAIL_FULL,
        .variables = (int32_t)(coordinator->bound_count / 2),
    };
    memcpy(message.scenario, coordinator->scenario_digest.bytes, DIGEST_SIZE);
    memcpy(message.box, coordinator->box_digest.bytes, DIGEST_SIZE);
    if (with_bounds) {
        message.text_size = (int32_t)(coordinator->bound_count * sizeof *coordinator->bounds);
        message.text = (uint8_t *)coordinator->bounds;
    }
    assert_int_equal(wire_publish(coordinator->wire, WIRE_SAMPLE_BATCH, &message), STATUS_OK);
}

static void send_batch(struct coordinator *coordinator, uint32_t index, bool with_bounds)
{
    send_batch_to(coordinator, index, with_bounds, SENDER);
}

static void send_run_status(struct coordinator *coordinator, int8_t state)
{
    sobox_run_status_t status = {.header.run = RUN, .state = state, .searches = 1};
    memcpy(status.name, "runtime", sizeof "runtime");
    assert_int_equal(wire_publish(coordinator->wire, WIRE_RUN_STATUS, &status), STATUS_OK);
}

static void on_request(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct coordinator *coordinator = user;
    const sobox_text_request_t *request = received;
    coordinator->requests++;
    if (coordinator->mute)
        return;
    bool box = memcmp(request->digest, coordinator->box_digest.bytes, DIGEST_SIZE) == 0;
    size_t size = box ? coordinator->bound_count * sizeof(double) : strlen(yaml);
    const uint8_t *bytes = box ? (const uint8_t *)coordinator->bounds : (const uint8_t *)yaml;
    for (size_t offset = (size_t)request->offset; offset < size; offset += PIECE) {
        sobox_text_t text = {
            .header.run = RUN,
            .total_size = (int32_t)size,
            .offset = (int32_t)offset,
            .piece_size = (int32_t)MIN(PIECE, size - offset),
            .piece = (uint8_t *)bytes + offset,
        };
        memcpy(text.digest, request->digest, DIGEST_SIZE);
        bool last = offset + PIECE >= size;
        if (!last && coordinator->lose_pieces > 0) {
            coordinator->lose_pieces--;
            continue;
        }
        assert_int_equal(wire_publish(coordinator->wire, WIRE_TEXT, &text), STATUS_OK);
    }
}

static void on_status(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct coordinator *coordinator = user;
    coordinator->status = *(const sobox_worker_status_t *)received;
    coordinator->statuses++;
}

// Whether an outcome is what evaluating its batch here gives.
static bool outcome_right(const struct coordinator *coordinator,
                          const sobox_outcome_batch_t *outcome)
{
    struct batch batch = batch_of((uint32_t)outcome->batch.batch);
    struct verdict expected[COUNT], found[COUNT];
    struct model *model = model_create(&coordinator->scenario);
    uint32_t non_finite = batch_evaluate(&coordinator->scenario, model,
                                         &coordinator->scenario.design_space, &batch, 1, expected);
    model_free(model);
    if (outcome->header.run != RUN || outcome->batch.search != 1 || outcome->batch.step != 4 ||
        outcome->batch.count != COUNT || outcome->batch.first != (int32_t)batch.first ||
        outcome->non_finite != (int32_t)non_finite || outcome->detail != VERDICT_DETAIL_FULL ||
        !verdict_unpack(found, COUNT, VERDICT_DETAIL_FULL, coordinator->scenario.constraint_count,
                        outcome->packed, (size_t)outcome->packed_size))
        return false;
    for (uint32_t i = 0; i < COUNT; i++) {
        if (expected[i].violation != found[i].violation ||
            expected[i].constraint != found[i].constraint)
            return false;
    }
    return true;
}

static void on_outcome(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct coordinator *coordinator = user;
    const sobox_outcome_batch_t *outcome = received;
    coordinator->outcomes++;
    if (outcome->batch.batch >= BATCHES || !outcome_right(coordinator, outcome))
        coordinator->wrong = true;
    else
        coordinator->outcomes_of[outcome->batch.batch]++;
}

// ---- The tests ----

static void turn(void)
{
    g_main_context_iteration(NULL, TRUE);
}

static void wait_for_outcomes(struct coordinator *coordinator, uint32_t count)
{
    while (coordinator->outcomes < count)
        turn();
    assert_int_equal(coordinator->outcomes, count);
    assert_false(coordinator->wrong);
}

// Everything that is on its way has arrived and been answered.
static void settle(struct coordinator *coordinator)
{
    struct worker_counters counters;
    do {
        while (g_main_context_iteration(NULL, FALSE))
            ;
        worker_counters(coordinator->worker, &counters);
        if (counters.queue > 0)
            turn();
    } while (counters.queue > 0);
    while (g_main_context_iteration(NULL, FALSE))
        ;
}

static int set_up(void **state)
{
    struct coordinator *coordinator = g_new0(struct coordinator, 1);
    *state = coordinator;
    struct error error = {0};
    const struct wire_settings settings = wire_settings_default();
    const struct worker_settings worker = {.threads = 2, .priority = 1};
    if (wire_open(&coordinator->wire, &settings, SENDER, &error) != STATUS_OK ||
        wire_subscribe(coordinator->wire, WIRE_TEXT_REQUEST, on_request, coordinator, &error) !=
            STATUS_OK ||
        wire_subscribe(coordinator->wire, WIRE_OUTCOME_BATCH, on_outcome, coordinator, &error) !=
            STATUS_OK ||
        wire_subscribe(coordinator->wire, WIRE_WORKER_STATUS, on_status, coordinator, &error) !=
            STATUS_OK ||
        scenario_read_text(&coordinator->scenario, "runtime", yaml, strlen(yaml), NULL, 0,
                           &error) != STATUS_OK ||
        worker_start(&coordinator->worker, coordinator->wire, SENDER, &worker, &error) !=
            STATUS_OK) {
        print_error("%s\n", error.text);
        return -1;
    }
    const struct box *space = &coordinator->scenario.design_space;
    coordinator->bound_count = 2 * space->count;
    coordinator->bounds = g_new(double, coordinator->bound_count);
    memcpy(coordinator->bounds, space->lower, space->count * sizeof(double));
    memcpy(coordinator->bounds + space->count, space->upper, space->count * sizeof(double));
    coordinator->box_digest =
        digest_of(coordinator->bounds, coordinator->bound_count * sizeof(double));
    coordinator->scenario_digest = digest_of(yaml, strlen(yaml));
    return 0;
}

static int tear_down(void **state)
{
    struct coordinator *coordinator = *state;
    worker_stop(coordinator->worker);
    wire_close(coordinator->wire);
    scenario_fini(&coordinator->scenario);
    g_free(coordinator->bounds);
    g_free(coordinator);
    return 0;
}

// A worker says who it is as soon as it is there, so that nobody has to wait for the next second.
static void worker_announces_itself(void **state)
{
    struct coordinator *coordinator = *state;
    while (coordinator->statuses == 0)
        turn();
    struct digest fingerprint = fingerprint_compute();
    assert_memory_equal(coordinator->status.fingerprint, fingerprint.bytes, DIGEST_SIZE);
    assert_int_equal(coordinator->status.threads, 2);
    assert_int_equal(coordinator->status.leaving, 0);
    assert_int_equal(coordinator->status.header.sender, SENDER);
    assert_string_not_equal((const char *)coordinator->status.host, "");
}

// A coordinator that the worker has not heard before is answered at once; one that it knows is not,
// or every run status would bring a status from every worker.
static void new_coordinator_is_greeted(void **state)
{
    struct coordinator *coordinator = *state;
    settle(coordinator);
    uint32_t before = coordinator->statuses;
    send_run_status(coordinator, 0);
    send_run_status(coordinator, 0);
    settle(coordinator);
    assert_int_equal(coordinator->statuses, before + 1);
    struct worker_counters counters;
    worker_counters(coordinator->worker, &counters);
    assert_int_equal(counters.coordinators, 1);
    send_run_status(coordinator, 2);
    settle(coordinator);
    worker_counters(coordinator->worker, &counters);
    assert_int_equal(counters.coordinators, 0);
}

// A batch with its box: the scenario is asked for once, and the outcome is exactly what evaluating
// the batch elsewhere gives.
static void outcome_is_that_of_the_batch(void **state)
{
    struct coordinator *coordinator = *state;
    send_batch(coordinator, 0, true);
    wait_for_outcomes(coordinator, 1);
    assert_int_equal(coordinator->requests, 1);
    send_batch(coordinator, 1, true);
    wait_for_outcomes(coordinator, 2);
    assert_int_equal(coordinator->requests, 1);
}

// A batch without its box: scenario and box are asked for, and the outcome is the same.
static void box_comes_by_request(void **state)
{
    struct coordinator *coordinator = *state;
    send_batch(coordinator, 0, false);
    wait_for_outcomes(coordinator, 1);
    assert_int_equal(coordinator->requests, 2);
    send_batch(coordinator, 1, false);
    wait_for_outcomes(coordinator, 2);
    assert_int_equal(coordinator->requests, 2);
}

// Pieces of texts get lost: the worker asks again from where it lacks something.
static void lost_pieces_are_asked_for_again(void **state)
{
    struct coordinator *coordinator = *state;
    coordinator->lose_pieces = 5;
    send_batch(coordinator, 0, false);
    wait_for_outcomes(coordinator, 1);
    assert_in_range(coordinator->requests, 3, 6);
}

// A request gets lost: the worker asks again by itself.
static void lost_request_is_repeated(void **state)
{
    struct coordinator *coordinator = *state;
    coordinator->mute = true;
    send_batch(coordinator, 0, true);
    while (coordinator->requests == 0)
        turn();
    coordinator->mute = false;
    wait_for_outcomes(coordinator, 1);
    assert_in_range(coordinator->requests, 2, 12); // 2, but for a machine that stalls
}

// The same batch twice in a row gives one outcome; once more after its outcome, and it is evaluated
// again, because the coordinator did not get it.
static void doubled_batch_is_evaluated_once(void **state)
{
    struct coordinator *coordinator = *state;
    send_batch(coordinator, 0, true);
    send_batch(coordinator, 0, true);
    wait_for_outcomes(coordinator, 1);
    settle(coordinator);
    assert_int_equal(coordinator->outcomes, 1);
    send_batch(coordinator, 0, true);
    wait_for_outcomes(coordinator, 2);
}

// Every worker hears every batch; only the holder of the lease works.
static void batch_of_another_worker_is_left_alone(void **state)
{
    struct coordinator *coordinator = *state;
    send_batch_to(coordinator, 0, true, SENDER + 1);
    send_batch(coordinator, 1, true);
    wait_for_outcomes(coordinator, 1);
    settle(coordinator);
    assert_int_equal(coordinator->outcomes_of[0], 0);
    assert_int_equal(coordinator->outcomes_of[1], 1);
}

// Many batches at once, half of them without a box and before the scenario is there: each gives one
// outcome.
static void many_batches_give_an_outcome_each(void **state)
{
    struct coordinator *coordinator = *state;
    for (uint32_t i = 0; i < BATCHES; i++)
        send_batch(coordinator, i, i % 2 == 1);
    wait_for_outcomes(coordinator, BATCHES);
    for (uint32_t i = 0; i < BATCHES; i++)
        assert_int_equal(coordinator->outcomes_of[i], 1);
    struct worker_counters counters;
    worker_counters(coordinator->worker, &counters);
    assert_int_equal(counters.batches, BATCHES);
    assert_int_equal(counters.samples, BATCHES * COUNT);
    assert_int_equal(counters.queue, 0);
}

// A worker that is stopped in the midst of work says that it leaves, gives no outcome twice, and
// hears nothing more: what is still under way must not reach what is released.
static void stopped_worker_says_that_it_leaves(void **state)
{
    struct coordinator *coordinator = *state;
    for (uint32_t i = 0; i < BATCHES; i++)
        send_batch(coordinator, i, true);
    while (coordinator->outcomes == 0)
        turn();
    worker_stop(coordinator->worker);
    coordinator->worker = NULL;
    send_batch(coordinator, 0, true);
    send_run_status(coordinator, 0);
    while (g_main_context_iteration(NULL, FALSE))
        ;
    assert_int_equal(coordinator->status.leaving, 1);
    assert_false(coordinator->wrong);
    for (uint32_t i = 0; i < BATCHES; i++)
        assert_in_range(coordinator->outcomes_of[i], 0, 1);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(worker_announces_itself),           TEST(new_coordinator_is_greeted),
        TEST(outcome_is_that_of_the_batch),      TEST(box_comes_by_request),
        TEST(lost_pieces_are_asked_for_again),   TEST(lost_request_is_repeated),
        TEST(doubled_batch_is_evaluated_once),   TEST(batch_of_another_worker_is_left_alone),
        TEST(many_batches_give_an_outcome_each), TEST(stopped_worker_says_that_it_leaves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
