// Batches of an adversarial step: their attacks come with the box, from the network.
#include "common/sampling/box_text.h"
#include "worker/batch/intake.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { VARIABLES = 4, ATTACKS = 2, ROW = 1 + VARIABLES };

static const char text[] = "name: attacked\n"
                           "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                           "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                           "springs:\n"
                           "  - name: front\n"
                           "    position: [-0.83, -0.75]\n"
                           "    deformation: [0.0, 1.2]\n"
                           "    force_x: {lower: 0, upper: [80e3, 450e3]}\n"
                           "    force_y: {lower: 0, upper: 250e3}\n"
                           "response: any\n"
                           "firewall_distance: 0.25\n"
                           "constraints: {yaw_deg: {min: -20, max: 20}}\n";

static double lower[VARIABLES] = {0, 0, 0, 0};
static double upper[VARIABLES] = {1e5, 4e5, 1e5, 2e5};
static const struct box box = {.count = VARIABLES, .lower = lower, .upper = upper};

// Two curves of two free variables.
enum { PER_ATTACK = 1 + 2 * VARIABLES + 3 * 2 + MOVES_LEAPS };

// What a coordinator sends: targets of both attacks, how many come, and what the step says.
static enum status take_in(uint8_t target, uint32_t attacks, uint32_t samples,
                           struct intake_work *work)
{
    uint8_t rows[ATTACKS * ROW] = {0, 0, 254, 0, 254, target, 127, 0, 1, 2};
    const struct moves moves = {.variables = VARIABLES, .attacks = attacks, .rows = rows};
    GByteArray *box_text = g_byte_array_new();
    box_text_put(box_text, &box, attacks > 0 ? &moves : NULL);
    struct intake_batch batch = {
        .run = 7,
        .coordinator = 11,
        .scenario = digest_of(text, sizeof text - 1),
        .box = digest_of(box_text->data, box_text->len),
        .identity = {.step = 3, .first = 5, .count = 10},
        .sampling = {.seed = 1, .step = 3, .samples = samples, .method = SAMPLING_METHOD_MOVES},
        .detail = VERDICT_DETAIL_MARGIN,
        .variables = VARIABLES,
        .text = box_text->data,
        .text_size = box_text->len,
    };
    struct intake *intake = intake_create();
    struct error error = {0};
    enum status status = intake_batch(intake, &batch, 0, &error);
    if (status == STATUS_OK) // it waits for its scenario
        status = intake_text(intake, &batch.scenario, sizeof text - 1, 0, (const uint8_t *)text,
                             sizeof text - 1, 0, &error);
    assert_int_equal(status == STATUS_OK, error.text[0] == '\0');
    assert_int_equal(intake_queue(intake), status == STATUS_OK ? 1 : 0);
    struct intake_work taken;
    assert_int_equal(intake_take(intake, &taken), status == STATUS_OK);
    if (status == STATUS_OK && work != NULL) {
        // What is evaluated is what the coordinator would make of the same attacks.
        struct verdict verdicts[10];
        struct batch samples_of = intake_samples(&taken.batch);
        assert_non_null(samples_of.sampling.moves);
        assert_int_equal(samples_of.sampling.moves->attacks, attacks);
        assert_memory_equal(samples_of.sampling.moves->rows, rows, moves_size(&moves));
        batch_evaluate(taken.scenario, taken.model, taken.box, &samples_of, 1, verdicts);
        *work = taken;
    }
    if (status == STATUS_OK)
        intake_done(intake, &taken);
    intake_free(intake);
    g_byte_array_unref(box_text);
    return status;
}

// Attacks that fit are there when the batch is evaluated.
static void attacks_come_with_the_box(void **state)
{
    (void)state;
    struct intake_work work;
    assert_int_equal(take_in(1, ATTACKS, ATTACKS * PER_ATTACK, &work), STATUS_OK);
    assert_int_equal(take_in(0, 1, PER_ATTACK, &work), STATUS_OK);
}

// Sampling them all the same would read attacks that are not there.
static void missing_attacks_drop_the_batch(void **state)
{
    (void)state;
    assert_int_equal(take_in(0, 0, PER_ATTACK, NULL), STATUS_INVALID);
    assert_int_equal(take_in(0, 1, 2 * PER_ATTACK, NULL), STATUS_INVALID);
}

static void wrong_number_of_samples_drops_the_batch(void **state)
{
    (void)state;
    assert_int_equal(take_in(0, ATTACKS, ATTACKS * PER_ATTACK - 1, NULL), STATUS_INVALID);
    assert_int_equal(take_in(0, ATTACKS, ATTACKS * PER_ATTACK + 1, NULL), STATUS_INVALID);
}

// The scenario's constraints are known to the worker alone: the message's bounds cannot tell.
static void attack_on_an_unknown_constraint_drops_the_batch(void **state)
{
    (void)state;
    assert_int_equal(take_in(200, ATTACKS, ATTACKS * PER_ATTACK, NULL), STATUS_INVALID);
    assert_int_equal(take_in(255, ATTACKS, ATTACKS * PER_ATTACK, NULL), STATUS_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attacks_come_with_the_box),
        cmocka_unit_test(missing_attacks_drop_the_batch),
        cmocka_unit_test(wrong_number_of_samples_drops_the_batch),
        cmocka_unit_test(attack_on_an_unknown_constraint_drops_the_batch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
