#include "worker/batch/intake.h"

#include "common/base/clock.h"
#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define MS CLOCK_MILLISECOND_NS

enum {
    BOUND_COUNT = 8, // 2 bounds for each of 2 points in 2 directions
    PIECE = 100,     // [bytes] of a text in these tests
};

// A text that a coordinator would send.
struct sent {
    struct digest digest;
    uint8_t bytes[2048];
    uint32_t size;
};

static struct sent scenario;
static struct sent box;
static double bounds[BOUND_COUNT] = {0, 0, 0, 0, 1e5, 4e5, 1e5, 2e5};

static void scenario_write(struct sent *sent, const char *name)
{
    int size = g_snprintf((char *)sent->bytes, sizeof sent->bytes,
                          "name: %s\n"
                          "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                          "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                          "springs:\n"
                          "  - name: front\n"
                          "    position: [-0.83, -0.75]\n"
                          "    deformation: [0.0, 1.2]\n"
                          "    force_x: {lower: 0, upper: [80e3, 450e3]}\n"
                          "    force_y: {lower: 0, upper: 250e3}\n"
                          "response: any\n"
                          "firewall_distance: 0.25\n",
                          name);
    sent->size = (uint32_t)size;
    sent->digest = digest_of(sent->bytes, sent->size);
}

static void box_write(struct sent *sent, const double *values, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        for (int byte = 0; byte < 8; byte++)
            sent->bytes[i * 8 + byte] = (uint8_t)(bits >> (8 * byte));
    }
    sent->size = count * 8;
    sent->digest = digest_of(sent->bytes, sent->size);
}

static int set_up(void **state)
{
    scenario_write(&scenario, "intake");
    box_write(&box, bounds, BOUND_COUNT);
    *state = intake_create();
    return 0;
}

static int tear_down(void **state)
{
    intake_free(*state);
    return 0;
}

static struct intake_batch batch_of(uint32_t index)
{
    return (struct intake_batch){
        .run = 7,
        .coordinator = 11,
        .scenario = scenario.digest,
        .box = box.digest,
        .identity = {.step = 3, .batch = index, .first = index * 10, .count = 10},
        .sampling = {.seed = 1, .step = 3, .samples = 1000},
        .variables = BOUND_COUNT / 2,
    };
}

static struct intake_batch batch_with_bounds(uint32_t index)
{
    struct intake_batch batch = batch_of(index);
    batch.text = (const uint8_t *)bounds;
    batch.text_size = sizeof bounds;
    return batch;
}

static struct intake_batch designs_of(uint32_t index, const double *designs, uint32_t value_count)
{
    struct intake_batch batch = batch_of(index);
    batch.identity.count = 2;
    batch.designs = designs;
    batch.design_value_count = value_count;
    return batch;
}

static void assert_taken_in(struct intake *intake, struct intake_batch batch)
{
    struct error error = {0};
    assert_int_equal(intake_batch(intake, &batch, 0, &error), STATUS_OK);
    assert_string_equal(error.text, "");
}

static void assert_refused(struct intake *intake, struct intake_batch batch, enum status status)
{
    struct error error = {0};
    assert_int_equal(intake_batch(intake, &batch, 0, &error), status);
    assert_string_not_equal(error.text, "");
}

static enum status feed(struct intake *intake, const struct sent *sent, uint32_t offset,
                        uint32_t size, int64_t now_ns)
{
    struct error error = {0};
    return intake_text(intake, &sent->digest, sent->size, offset, sent->bytes + offset, size,
                       now_ns, &error);
}

static void assert_fed(struct intake *intake, const struct sent *sent)
{
    for (uint32_t offset = 0; offset < sent->size; offset += PIECE)
        assert_int_equal(feed(intake, sent, offset, MIN(PIECE, sent->size - offset), 0), STATUS_OK);
}

static void assert_asks(struct intake *intake, int64_t now_ns, const struct sent *sent,
                        uint32_t offset)
{
    struct intake_request request;
    assert_true(intake_request(intake, now_ns, &request));
    assert_true(digest_equal(&request.digest, &sent->digest));
    assert_int_equal(request.offset, offset);
    assert_int_equal(request.run, 7);
}

static void assert_asks_nothing(struct intake *intake, int64_t now_ns)
{
    struct intake_request request;
    assert_false(intake_request(intake, now_ns, &request));
}

static void assert_takes(struct intake *intake, uint32_t index)
{
    struct intake_work work;
    assert_true(intake_take(intake, &work));
    assert_int_equal(work.batch.identity.batch, index);
    assert_null(work.batch.text);
    assert_int_equal(work.scenario->design_space.count, BOUND_COUNT / 2);
    assert_int_equal(model_variable_count(work.model), BOUND_COUNT / 2);
    assert_memory_equal(work.box->lower, bounds, sizeof bounds / 2);
    assert_memory_equal(work.box->upper, bounds + BOUND_COUNT / 2, sizeof bounds / 2);
    intake_done(intake, &work);
}

static void assert_takes_nothing(struct intake *intake)
{
    struct intake_work work;
    assert_false(intake_take(intake, &work));
}

// The whole way: a batch misses both texts, asks for both at once, and can be taken when the second
// has arrived, with exactly the box that was sent.
static void batch_becomes_ready_with_its_texts(void **state)
{
    struct intake *intake = *state;
    assert_int_equal(intake_wake_ns(intake), INT64_MAX);
    assert_taken_in(intake, batch_of(0));
    assert_int_equal(intake_wake_ns(intake), 0);
    assert_asks(intake, 0, &scenario, 0);
    assert_asks(intake, 0, &box, 0);
    assert_asks_nothing(intake, 0);
    assert_takes_nothing(intake);
    assert_fed(intake, &box);
    assert_takes_nothing(intake);
    assert_fed(intake, &scenario);
    assert_int_equal(intake_wake_ns(intake), INT64_MAX);
    assert_int_equal(intake_queue(intake), 1);
    assert_takes(intake, 0);
    assert_int_equal(intake_queue(intake), 0);
    assert_takes_nothing(intake);
}

// A batch of given designs needs its scenario only, and hands its designs on as they came, though
// the message they came in is long gone.
static void given_designs_wait_for_the_scenario_alone(void **state)
{
    struct intake *intake = *state;
    double designs[2 * BOUND_COUNT / 2] = {1, 2, 3, 4, 5, 6, 7, 8};
    struct intake_batch batch = designs_of(0, designs, 8);
    assert_taken_in(intake, batch);
    assert_taken_in(intake, batch); // once more
    assert_int_equal(intake_queue(intake), 1);
    memset(designs, 0, sizeof designs);
    assert_asks(intake, 0, &scenario, 0);
    assert_asks_nothing(intake, 0);
    assert_fed(intake, &scenario);
    struct intake_work work;
    assert_true(intake_take(intake, &work));
    assert_null(work.box);
    assert_int_equal(work.batch.design_value_count, 8);
    for (int i = 0; i < 8; i++)
        assert_true(work.batch.designs[i] == i + 1);
    intake_done(intake, &work);
    assert_int_equal(intake_queue(intake), 0);
}

// Anyone on the network can send designs that fit no scenario, or are no numbers.
static void designs_that_do_not_fit_are_refused(void **state)
{
    struct intake *intake = *state;
    const double designs[] = {1, 2, 3, 4, 5, NAN};
    assert_refused(intake, designs_of(0, designs, 0), STATUS_INVALID);
    assert_refused(intake, designs_of(0, designs, 5), STATUS_INVALID);
    assert_refused(intake, designs_of(0, designs, 6), STATUS_INVALID); // the last is no number
    assert_taken_in(intake, designs_of(1, designs, 4)); // two variables each, the scenario has four
    assert_int_equal(feed(intake, &scenario, 0, scenario.size, 0), STATUS_INVALID);
    assert_int_equal(intake_queue(intake), 0);
    assert_takes_nothing(intake);
}

// A coordinator that sends without end must not fill the worker's memory: what is beyond the bound
// is refused, and its lease brings it back when there is room.
static void designs_beyond_the_room_are_refused(void **state)
{
    struct intake *intake = *state;
    enum { VALUES = 1 << 20, FIT = INTAKE_DESIGN_SIZE_MAX / (VALUES * 8) };
    double *designs = g_new0(double, VALUES);
    for (uint32_t i = 0; i < FIT; i++)
        assert_taken_in(intake, designs_of(i, designs, VALUES));
    assert_refused(intake, designs_of(FIT, designs, VALUES), STATUS_REFUSED);
    // They do not fit the scenario, so they go.
    assert_int_equal(feed(intake, &scenario, 0, scenario.size, 0), STATUS_INVALID);
    assert_taken_in(intake, designs_of(FIT, designs, 8));
    g_free(designs);
}

// What was fetched for one batch serves the next ones without a word on the network.
static void texts_are_kept_for_later_batches(void **state)
{
    struct intake *intake = *state;
    assert_taken_in(intake, batch_of(0));
    assert_fed(intake, &box);
    assert_fed(intake, &scenario);
    assert_takes(intake, 0);
    assert_taken_in(intake, batch_of(1));
    assert_asks_nothing(intake, 0);
    assert_takes(intake, 1);
}

// Bounds that come with one batch serve others of the same box, those that wait for it included.
static void bounds_of_a_batch_serve_others(void **state)
{
    struct intake *intake = *state;
    assert_taken_in(intake, batch_of(0));
    assert_fed(intake, &scenario);
    assert_takes_nothing(intake);
    assert_taken_in(intake, batch_with_bounds(1));
    assert_asks_nothing(intake, 0);
    assert_takes(intake, 0);
    assert_takes(intake, 1);
}

// The oldest batch goes first even when a younger one was ready before it.
static void oldest_ready_batch_is_taken_first(void **state)
{
    struct intake *intake = *state;
    struct sent other;
    double other_bounds[BOUND_COUNT];
    memcpy(other_bounds, bounds, sizeof bounds);
    other_bounds[7] = 1e5;
    box_write(&other, other_bounds, BOUND_COUNT);
    struct intake_batch first = batch_of(0);
    first.box = other.digest;

    assert_taken_in(intake, first);
    assert_taken_in(intake, batch_with_bounds(1));
    assert_fed(intake, &scenario);
    assert_fed(intake, &other);
    struct intake_work work;
    assert_true(intake_take(intake, &work));
    assert_int_equal(work.batch.identity.batch, 0);
    assert_true(work.box->upper[3] == 1e5);
    assert_takes(intake, 1);
    intake_done(intake, &work);
}

// A batch that is sent again while it waits or is in work is evaluated once.
static void waiting_batch_is_not_queued_twice(void **state)
{
    struct intake *intake = *state;
    struct intake_batch batch = batch_with_bounds(0);
    assert_taken_in(intake, batch);
    batch.identity.attempt = 2;
    assert_taken_in(intake, batch);
    assert_int_equal(intake_queue(intake), 1);
    assert_fed(intake, &scenario);
    struct intake_work work;
    assert_true(intake_take(intake, &work));
    assert_int_equal(work.batch.identity.attempt, 2);
    assert_taken_in(intake, batch);
    assert_takes_nothing(intake);
    intake_done(intake, &work);
    assert_taken_in(intake, batch); // its outcome was lost: this time it counts again
    assert_takes(intake, 0);
}

// Two coordinators may number their batches alike.
static void batches_of_two_coordinators_differ(void **state)
{
    struct intake *intake = *state;
    struct intake_batch batch = batch_with_bounds(0);
    assert_taken_in(intake, batch);
    batch.coordinator = 12;
    assert_taken_in(intake, batch);
    assert_int_equal(intake_queue(intake), 2);
}

// The queue is bounded, and has room again as batches are done.
// Who sends more does not get more: eight batches that came first do not go before another's only
// one.
static void coordinators_are_served_in_turn(void **state)
{
    struct intake *intake = *state;
    struct intake_work work;
    for (uint32_t i = 0; i < 8; i++)
        assert_taken_in(intake, batch_with_bounds(i));
    struct intake_batch other = batch_with_bounds(0);
    other.coordinator = 12;
    assert_taken_in(intake, other);
    assert_fed(intake, &scenario);
    assert_takes(intake, 0);
    assert_true(intake_take(intake, &work));
    assert_int_equal(work.batch.coordinator, 12);
    intake_done(intake, &work);
    for (uint32_t i = 1; i < 8; i++)
        assert_takes(intake, i);
}

static void full_queue_refuses(void **state)
{
    struct intake *intake = *state;
    for (uint32_t i = 0; i < INTAKE_QUEUE_MAX; i++)
        assert_taken_in(intake, batch_with_bounds(i));
    assert_refused(intake, batch_with_bounds(INTAKE_QUEUE_MAX), STATUS_REFUSED);
    assert_taken_in(intake, batch_with_bounds(5)); // known: nothing to queue
    assert_fed(intake, &scenario);
    assert_takes(intake, 0);
    assert_taken_in(intake, batch_with_bounds(INTAKE_QUEUE_MAX));
}

// So is the number of scenarios: beyond it the one unused for longest is forgotten, and asked for
// again when it is needed. A worker of a sweep of many thousand cases would grow otherwise.
static void scenarios_are_bounded(void **state)
{
    struct intake *intake = *state;
    struct sent *sent = g_new0(struct sent, INTAKE_SCENARIO_MAX + 1);
    char name[32];
    for (uint32_t i = 0; i <= INTAKE_SCENARIO_MAX; i++) {
        g_snprintf(name, sizeof name, "number-%u", i);
        scenario_write(&sent[i], name);
        struct intake_batch batch = batch_with_bounds(i);
        batch.scenario = sent[i].digest;
        assert_taken_in(intake, batch);
        assert_fed(intake, &sent[i]);
        assert_takes(intake, i);
    }
    struct intake_batch second = batch_with_bounds(1);
    second.scenario = sent[1].digest;
    assert_taken_in(intake, second);
    assert_takes(intake, 1);
    struct intake_batch first = batch_with_bounds(0);
    first.scenario = sent[0].digest;
    assert_taken_in(intake, first);
    assert_takes_nothing(intake);
    assert_asks(intake, 0, &sent[0], 0);
    assert_fed(intake, &sent[0]);
    assert_takes(intake, 0);
    g_free(sent);
}

// A text is asked for again after 50 ms, then ever more seldom, at most once a second.
static void request_is_repeated_at_growing_intervals(void **state)
{
    struct intake *intake = *state;
    assert_taken_in(intake, batch_with_bounds(0));
    static const int64_t interval_ms[] = {50, 100, 200, 400, 800, 1000, 1000};
    int64_t now_ns = 0;
    assert_asks(intake, now_ns, &scenario, 0);
    for (size_t i = 0; i < G_N_ELEMENTS(interval_ms); i++) {
        assert_int_equal(intake_wake_ns(intake), now_ns + interval_ms[i] * MS);
        assert_asks_nothing(intake, now_ns + interval_ms[i] * MS - 1);
        now_ns += interval_ms[i] * MS;
        assert_asks(intake, now_ns, &scenario, 0);
    }
}

// Pieces that arrive put the next request off; a hole behind the last piece is asked for at once,
// from its first byte on.
static void lost_piece_is_asked_for_at_once(void **state)
{
    struct intake *intake = *state;
    assert_taken_in(intake, batch_with_bounds(0));
    assert_asks(intake, 0, &scenario, 0);
    assert_int_equal(feed(intake, &scenario, 0, PIECE, 40 * MS), STATUS_OK);
    assert_asks_nothing(intake, 60 * MS);
    assert_int_equal(feed(intake, &scenario, 2 * PIECE, scenario.size - 2 * PIECE, 61 * MS),
                     STATUS_OK);
    assert_int_equal(intake_wake_ns(intake), 61 * MS);
    assert_asks(intake, 61 * MS, &scenario, PIECE);
    assert_asks_nothing(intake, 61 * MS);
    // The last piece once more, as multicast may have it: no second request.
    assert_int_equal(feed(intake, &scenario, scenario.size - 5, 5, 62 * MS), STATUS_OK);
    assert_asks_nothing(intake, 62 * MS);
    assert_int_equal(feed(intake, &scenario, PIECE, PIECE, 63 * MS), STATUS_OK);
    assert_takes(intake, 0);
}

// A text that nobody sends is given up, so that the batches of a coordinator that died do not fill
// the queue for ever.
static void unanswered_text_is_given_up(void **state)
{
    struct intake *intake = *state;
    assert_taken_in(intake, batch_with_bounds(0));
    assert_taken_in(intake, batch_with_bounds(1));
    for (int i = 0; i < INTAKE_ASK_MAX; i++)
        assert_asks(intake, intake_wake_ns(intake), &scenario, 0);
    assert_int_equal(intake_queue(intake), 2);
    assert_asks_nothing(intake, intake_wake_ns(intake));
    assert_int_equal(intake_queue(intake), 0);
    assert_int_equal(intake_wake_ns(intake), INT64_MAX);
}

// Pieces nobody asked for cost nothing and change nothing.
static void unwanted_text_is_ignored(void **state)
{
    struct intake *intake = *state;
    assert_fed(intake, &scenario);
    assert_taken_in(intake, batch_with_bounds(0));
    assert_asks(intake, 0, &scenario, 0);
    assert_takes_nothing(intake);
}

// A text that is not the one its digest promises drops the batches that wait for it; a later batch
// may ask again.
static void forged_text_drops_its_batches(void **state)
{
    struct intake *intake = *state;
    assert_taken_in(intake, batch_with_bounds(0));
    assert_taken_in(intake, batch_with_bounds(1));
    struct sent forged = scenario;
    forged.bytes[6] ^= 1;
    assert_int_equal(feed(intake, &forged, 0, forged.size, 0), STATUS_INVALID);
    assert_int_equal(intake_queue(intake), 0);
    assert_int_equal(intake_wake_ns(intake), INT64_MAX);
    assert_taken_in(intake, batch_with_bounds(0));
    assert_fed(intake, &scenario);
    assert_takes(intake, 0);
}

// A scenario that this worker cannot read drops its batches, and says where the text is wrong.
static void unreadable_scenario_drops_its_batches(void **state)
{
    struct intake *intake = *state;
    struct sent broken = {.size = 12};
    memcpy(broken.bytes, "name: [what\n", broken.size);
    broken.digest = digest_of(broken.bytes, broken.size);
    struct intake_batch batch = batch_with_bounds(0);
    batch.scenario = broken.digest;
    assert_taken_in(intake, batch);
    struct error error = {0};
    assert_int_equal(
        intake_text(intake, &broken.digest, broken.size, 0, broken.bytes, broken.size, 0, &error),
        STATUS_INVALID);
    char hex[DIGEST_HEX_SIZE];
    assert_non_null(strstr(error.text, digest_hex(&broken.digest, hex)));
    assert_int_equal(intake_queue(intake), 0);
}

// Bounds that came with a batch are held against the digest it names, and must be intervals.
static void wrong_bounds_drop_the_batch(void **state)
{
    struct intake *intake = *state;
    double wrong[BOUND_COUNT];
    memcpy(wrong, bounds, sizeof bounds);
    wrong[0] = 1;
    struct intake_batch batch = batch_with_bounds(0);
    batch.text = (const uint8_t *)wrong;
    assert_refused(intake, batch, STATUS_INVALID); // not those of the digest

    static const double bad[] = {5e5, NAN, INFINITY};
    for (size_t i = 0; i < G_N_ELEMENTS(bad); i++) {
        struct sent sent;
        wrong[0] = bad[i];
        box_write(&sent, wrong, BOUND_COUNT);
        batch.box = sent.digest;
        assert_refused(intake, batch, STATUS_INVALID); // upside down, not finite
    }
    assert_int_equal(intake_queue(intake), 0);
    assert_int_equal(intake_wake_ns(intake), INT64_MAX);
}

// A box that does not fit its scenario drops the batch, whichever of the two comes last.
static void box_of_other_scenario_drops_the_batch(void **state)
{
    struct intake *intake = *state;
    struct sent small;
    const double small_bounds[] = {0, 1};
    box_write(&small, small_bounds, G_N_ELEMENTS(small_bounds));
    struct intake_batch batch = batch_of(0);
    batch.box = small.digest;
    batch.variables = G_N_ELEMENTS(small_bounds) / 2;
    assert_taken_in(intake, batch);
    assert_fed(intake, &small);
    assert_int_equal(feed(intake, &scenario, 0, scenario.size, 0), STATUS_INVALID);
    assert_int_equal(intake_queue(intake), 0);
    batch.text = (const uint8_t *)small_bounds;
    batch.text_size = sizeof small_bounds;
    assert_refused(intake, batch, STATUS_INVALID);
    assert_taken_in(intake, batch_with_bounds(1)); // the scenario itself is good
    assert_takes(intake, 1);
}

// Forged sizes: what no box or scenario can have is ignored, and many unfinished texts of the
// greatest size are kept within bounds, the oldest first.
static void unfinished_texts_are_bounded(void **state)
{
    struct intake *intake = *state;
    static const uint8_t piece[8] = {0};
    struct intake_batch batch = batch_of(0);
    assert_taken_in(intake, batch);
    assert_int_equal(intake_text(intake, &box.digest, 1000, 0, piece, sizeof piece, 0, NULL),
                     STATUS_OK);
    assert_asks(intake, 0, &scenario, 0);
    assert_asks(intake, 0, &box, 0); // 1000 bytes are no intervals
    enum { OTHERS = 64 };            // far more than partial texts may take together
    struct sent other[OTHERS];
    char name[32];
    for (uint32_t i = 1; i < OTHERS; i++) {
        g_snprintf(name, sizeof name, "number-%u", i);
        scenario_write(&other[i], name);
        batch = batch_with_bounds(i);
        batch.scenario = other[i].digest;
        assert_taken_in(intake, batch);
        assert_int_equal(intake_text(intake, &other[i].digest, SCENARIO_TEXT_SIZE_MAX, 0, piece,
                                     sizeof piece, 0, NULL),
                         STATUS_OK);
    }
    assert_fed(intake, &scenario); // the oldest finds room all the same
    assert_takes(intake, 0);
    for (uint32_t i = 1; i < OTHERS; i++) {
        assert_fed(intake, &other[i]);
        assert_takes(intake, i);
    }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(batch_becomes_ready_with_its_texts),
        TEST(given_designs_wait_for_the_scenario_alone),
        TEST(designs_that_do_not_fit_are_refused),
        TEST(designs_beyond_the_room_are_refused),
        TEST(texts_are_kept_for_later_batches),
        TEST(bounds_of_a_batch_serve_others),
        TEST(oldest_ready_batch_is_taken_first),
        TEST(waiting_batch_is_not_queued_twice),
        TEST(batches_of_two_coordinators_differ),
        TEST(coordinators_are_served_in_turn),
        TEST(full_queue_refuses),
        TEST(scenarios_are_bounded),
        TEST(request_is_repeated_at_growing_intervals),
        TEST(lost_piece_is_asked_for_at_once),
        TEST(unanswered_text_is_given_up),
        TEST(unwanted_text_is_ignored),
        TEST(forged_text_drops_its_batches),
        TEST(unreadable_scenario_drops_its_batches),
        TEST(wrong_bounds_drop_the_batch),
        TEST(box_of_other_scenario_drops_the_batch),
        TEST(unfinished_texts_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
