#include "worker/batch/batch.h"

#include "common/scenario/scenario_read.h"
#include "worker/batch/fingerprint.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef __clang__
// Clang's OpenMP library keeps some memory for each thread it ever had, and says so to nobody.
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libomp\n";
}
#endif

enum { STRIDE = 3, SAMPLES = 1000 };

static const char text[] = "name: batch\n"
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

static struct scenario scenario;
static struct model *model;

static int set_up(void **state)
{
    (void)state;
    struct error error = {0};
    if (scenario_read_text(&scenario, "batch", text, strlen(text), NULL, 0, &error) != STATUS_OK) {
        print_error("%s\n", error.text);
        return -1;
    }
    model = model_create(&scenario);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    model_free(model);
    scenario_fini(&scenario);
    return 0;
}

// The verdict on outcomes that are all 0 but s_L and yaw, under three constraints made by hand:
// s_L >= 0.25 on a scale of 0.5, -20 <= yaw <= 20 on a scale of 40, s_L <= 1 on a scale of 2.
static struct verdict judged(double s_l, double yaw)
{
    struct scenario_constraint constraints[] = {
        {.outcome = OUTCOME_S_L, .min = 0.25, .max = INFINITY, .scale = 0.5},
        {.outcome = OUTCOME_YAW_DEG, .min = -20, .max = 20, .scale = 40},
        {.outcome = OUTCOME_S_L, .min = -INFINITY, .max = 1, .scale = 2},
    };
    struct scenario by_hand = {
        .spring_count = 1, .constraints = constraints, .constraint_count = 3};
    double outcomes[(OUTCOME_ENERGY_ABSORBED + 2) * STRIDE] = {0};
    for (size_t i = 1; i < sizeof outcomes / sizeof outcomes[0]; i += STRIDE)
        outcomes[i] = outcomes[i + 1] = NAN; // other samples' lanes: not to be looked at
    outcomes[OUTCOME_S_L * STRIDE] = s_l;
    outcomes[OUTCOME_YAW_DEG * STRIDE] = yaw;
    return batch_verdict(&by_hand, outcomes, STRIDE);
}

static void assert_verdict(struct verdict verdict, uint8_t constraint, double relative)
{
    assert_int_equal(verdict.violation, verdict_violation(relative));
    assert_int_equal(verdict.constraint, constraint);
}

// On and within the bounds a design is good.
static void design_within_bounds_is_good(void **state)
{
    (void)state;
    assert_verdict(judged(0.5, 0), 0, 0);
    assert_verdict(judged(0.25, -20), 0, 0);
    assert_verdict(judged(1, 20), 0, 0);
}

// The violation is the distance to the bound on the constraint's scale, whichever side is passed.
static void violation_is_relative_to_the_scale(void **state)
{
    (void)state;
    assert_verdict(judged(0.0, 0), 0, 0.5);
    assert_verdict(judged(0.5, 30), 1, 0.25);
    assert_verdict(judged(0.5, -40), 1, 0.5);
    assert_verdict(judged(2, 0), 2, 0.5);
}

// Of several violated constraints the one with the greatest relative violation stands in the
// verdict, and the first of those that are equal on the scale.
static void worst_constraint_is_named(void **state)
{
    (void)state;
    assert_verdict(judged(0.0, 60), 1, 1);
    assert_verdict(judged(-1, 60), 0, 2.5);
    assert_verdict(judged(0.0, 40), 0, 0.5);
    assert_verdict(judged(2, 40), 1, 0.5);
    assert_verdict(judged(0.0, 40.000001), 0, 0.5); // equal on the scale, if not in the number
}

// An outcome that is no number is the worst there is, wherever it stands.
static void non_finite_outcome_is_worst(void **state)
{
    (void)state;
    assert_verdict(judged(NAN, 1e6), 0, INFINITY);
    assert_verdict(judged(0.0, NAN), 1, INFINITY);
    assert_verdict(judged(INFINITY, 0), 0, INFINITY);
    assert_verdict(judged(0.5, -INFINITY), 1, INFINITY);

    double outcomes[OUTCOME_ENERGY_ABSORBED + 2] = {[OUTCOME_S_L] = 0.5};
    outcomes[OUTCOME_TRAVEL_Y] = NAN; // no constraint concerns it
    assert_verdict(batch_verdict(&scenario, outcomes, 1), 0, INFINITY);
}

// A block is judged outcome by outcome, a design as a whole: both must come to the same, where no
// number comes out too. No scenario has forces that leave motions without end, so the box is given
// some.
static void block_is_judged_as_its_designs_are(void **state)
{
    (void)state;
    static const char *const narrow[] = {
        "constraints={yaw_deg: {min: -5, max: 5}, s_L: {min: 0.4}}"};
    struct scenario s;
    struct error error = {0};
    if (scenario_read_text(&s, "batch", text, strlen(text), narrow, 1, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    s.design_space.upper[1] = 1e308; // [N]
    struct model *of = model_create(&s);
    enum { COUNT = 200, OUTCOMES = OUTCOME_ENERGY_ABSORBED + 2 };
    static double values[8 * MODEL_BLOCK], outcomes[OUTCOMES * MODEL_BLOCK];
    assert_true(model_variable_count(of) <= 8 && model_outcome_count(of) == OUTCOMES);
    const struct batch batch = {.sampling = {.seed = 4, .samples = COUNT}, .count = COUNT};
    static struct verdict verdicts[COUNT];
    uint32_t non_finite = batch_evaluate(&s, of, &s.design_space, &batch, 1, verdicts);
    assert_true(non_finite > 0);
    for (uint32_t first = 0; first < COUNT; first += MODEL_BLOCK) {
        uint32_t count = COUNT - first < MODEL_BLOCK ? COUNT - first : MODEL_BLOCK;
        sampling_fill(&batch.sampling, &s.design_space, first, count, values, MODEL_BLOCK);
        model_evaluate_judged(of, count, values, outcomes);
        for (uint32_t i = 0; i < count; i++) {
            struct verdict alone = batch_verdict(&s, outcomes + i, MODEL_BLOCK);
            assert_int_equal(verdicts[first + i].violation, alone.violation);
            assert_int_equal(verdicts[first + i].constraint, alone.constraint);
            non_finite -= alone.violation == VERDICT_NON_FINITE;
        }
    }
    assert_int_equal(non_finite, 0);
    model_free(of);
    scenario_fini(&s);
}

static struct batch batch_of(uint32_t first, uint32_t count)
{
    return (struct batch){
        .sampling = {.seed = 9, .step = 5, .samples = SAMPLES},
        .first = first,
        .count = count,
    };
}

static uint32_t evaluate(uint32_t first, uint32_t count, int threads, struct verdict *verdicts)
{
    struct batch batch = batch_of(first, count);
    return batch_evaluate(&scenario, model, &scenario.design_space, &batch, threads, verdicts);
}

static void assert_verdicts_equal(const struct verdict *a, const struct verdict *b, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(a[i].violation, b[i].violation);
        assert_int_equal(a[i].constraint, b[i].constraint);
    }
}

// The design space of the test has good and bad designs, or the tests below would compare nothing.
static void design_space_has_good_and_bad_designs(void **state)
{
    (void)state;
    struct verdict verdicts[SAMPLES];
    assert_int_equal(evaluate(0, SAMPLES, 1, verdicts), 0);
    uint32_t good = verdict_good_count(verdicts, SAMPLES);
    assert_in_range(good, SAMPLES / 50, SAMPLES - SAMPLES / 50);
}

// Any number of threads gives the same verdicts, more threads than blocks included.
static void thread_count_does_not_matter(void **state)
{
    (void)state;
    static const int threads[] = {1, 2, 7, 40};
    struct verdict one[SAMPLES], many[SAMPLES];
    evaluate(0, SAMPLES, 1, one);
    for (size_t i = 0; i < sizeof threads / sizeof threads[0]; i++) {
        memset(many, 0xAA, sizeof many);
        assert_int_equal(evaluate(0, SAMPLES, threads[i], many), 0);
        assert_verdicts_equal(one, many, SAMPLES);
    }
}

// A step cut into batches at any place gives the verdicts of the whole: no sample depends on its
// lane, its block or its batch.
static void pieces_of_a_step_make_the_whole(void **state)
{
    (void)state;
    struct verdict whole[SAMPLES], pieces[SAMPLES];
    evaluate(0, SAMPLES, 2, whole);
    static const uint32_t size[] = {1, 63, 64, 65, 200, 7};
    uint32_t first = 0;
    for (size_t i = 0; first < SAMPLES; i++) {
        uint32_t left = SAMPLES - first;
        uint32_t count = size[i % 6] < left ? size[i % 6] : left;
        assert_int_equal(evaluate(first, count, 2, pieces + first), 0);
        first += count;
    }
    assert_verdicts_equal(whole, pieces, SAMPLES);
}

// The verdicts are those of the outcomes that the model gives for the samples, one by one.
static void verdicts_are_those_of_each_sample(void **state)
{
    (void)state;
    enum { FIRST = 17, COUNT = 70 };
    struct verdict verdicts[COUNT];
    evaluate(FIRST, COUNT, 1, verdicts);
    struct batch batch = batch_of(FIRST, COUNT);
    uint32_t variables = model_variable_count(model), outcomes = model_outcome_count(model);
    double *values = aligned_alloc(64, variables * MODEL_BLOCK * sizeof *values);
    double *outcome = aligned_alloc(64, outcomes * MODEL_BLOCK * sizeof *outcome);
    for (uint32_t i = 0; i < COUNT; i++) {
        sampling_fill(&batch.sampling, &scenario.design_space, FIRST + i, 1, values, MODEL_BLOCK);
        model_evaluate(model, 1, values, outcome);
        struct verdict verdict = batch_verdict(&scenario, outcome, MODEL_BLOCK);
        assert_verdicts_equal(&verdict, &verdicts[i], 1);
    }
    free(values);
    free(outcome);
}

// Given designs have the outcomes that the model gives each of them alone, wherever one stands and
// however they are cut: no outcome may slip into a neighbour's row.
static void given_designs_have_the_outcomes_of_each(void **state)
{
    (void)state;
    enum { COUNT = 3 * MODEL_BLOCK + 5 };
    const uint32_t variables = model_variable_count(model), outcomes = model_outcome_count(model);
    double *values = calloc((size_t)COUNT * variables, sizeof *values);
    double *found[2];
    for (int i = 0; i < 2; i++)
        found[i] = calloc((size_t)COUNT * outcomes, sizeof *found[i]);
    const struct box *space = &scenario.design_space;
    for (uint32_t i = 0; i < COUNT; i++)
        for (uint32_t v = 0; v < variables; v++)
            values[i * variables + v] = space->lower[v] + (space->upper[v] - space->lower[v]) *
                                                              (i * 7 + v * 3) / (9 * COUNT);
    struct batch_scratch scratch = {0};
    batch_evaluate_designs(model, values, COUNT, &scratch, found[0]);
    for (uint32_t done = 0; done < COUNT; done += 37)
        batch_evaluate_designs(model, values + done * variables,
                               COUNT - done < 37 ? COUNT - done : 37, &scratch,
                               found[1] + done * outcomes);
    batch_scratch_fini(&scratch);
    assert_memory_equal(found[0], found[1], (size_t)COUNT * outcomes * sizeof(double));

    double *column = aligned_alloc(64, variables * MODEL_BLOCK * sizeof *column);
    double *outcome = aligned_alloc(64, outcomes * MODEL_BLOCK * sizeof *outcome);
    for (uint32_t i = 0; i < COUNT; i++) {
        for (uint32_t v = 0; v < variables; v++)
            column[v * MODEL_BLOCK] = values[i * variables + v];
        model_evaluate(model, 1, column, outcome);
        for (uint32_t o = 0; o < outcomes; o++)
            assert_memory_equal(&found[0][i * outcomes + o], &outcome[o * MODEL_BLOCK],
                                sizeof(double));
    }
    free(column);
    free(outcome);
    free(values);
    free(found[0]);
    free(found[1]);
}

// Two workers of one version must come to the same fingerprint, or none would be accepted.
static void fingerprint_is_the_same_each_time(void **state)
{
    (void)state;
    struct digest first = fingerprint_compute();
    struct digest second = fingerprint_compute();
    assert_true(digest_equal(&first, &second));
}

// The verdict over all cases is that of the worst one, and its constraint says which one that is.
static void cases_are_good_only_together(void **state)
{
    (void)state;
    static const char *const cases[] = {
        "cases=[{name: fast, vehicle.speed: 19}, {name: rotating, response: rotating}]"};
    struct scenario joint;
    struct error error = {0};
    assert_int_equal(scenario_read_text(&joint, "cases", text, strlen(text), cases, 1, &error),
                     STATUS_OK);
    static struct verdict together[SAMPLES], alone[2][SAMPLES];
    const struct batch batch = {.sampling = {.seed = 3, .samples = SAMPLES}, .count = SAMPLES};
    struct model *of_all = model_create(&joint);
    batch_evaluate(&joint, of_all, &joint.design_space, &batch, 2, together);
    for (uint32_t i = 0; i < 2; i++) {
        struct model *of_one = model_create(&joint.cases[i]);
        batch_evaluate(&joint.cases[i], of_one, &joint.design_space, &batch, 1, alone[i]);
        model_free(of_one);
    }
    uint32_t good = 0, worst[2] = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const uint32_t of = alone[1][i].violation > alone[0][i].violation;
        assert_int_equal(together[i].violation, alone[of][i].violation);
        if (together[i].violation == VERDICT_GOOD) {
            good++;
            continue;
        }
        worst[of]++;
        assert_int_equal(together[i].constraint,
                         alone[of][i].constraint + (of == 1 ? joint.cases[0].constraint_count : 0));
    }
    // Each case stands in the way of some designs, or this would show nothing.
    assert_true(good > 0 && worst[0] > 0 && worst[1] > 0);
    model_free(of_all);
    scenario_fini(&joint);
}

// The margin of constraint `constraint` of judged(), made by hand in the same way.
static double margin_by_hand(uint32_t constraint, double s_l, double yaw)
{
    struct scenario_constraint constraints[] = {
        {.outcome = OUTCOME_S_L, .min = 0.25, .max = INFINITY, .scale = 0.5},
        {.outcome = OUTCOME_YAW_DEG, .min = -20, .max = 20, .scale = 40},
    };
    struct scenario by_hand = {
        .spring_count = 1, .constraints = constraints, .constraint_count = 2};
    double outcomes[(OUTCOME_ENERGY_ABSORBED + 2) * STRIDE] = {0};
    outcomes[OUTCOME_S_L * STRIDE] = s_l;
    outcomes[OUTCOME_YAW_DEG * STRIDE] = yaw;
    return batch_margin(&by_hand, constraint, outcomes, STRIDE);
}

// How far inside, on the constraint's own scale, to the nearer of two bounds; below 0 outside.
static void margin_is_the_distance_to_the_nearest_bound(void **state)
{
    (void)state;
    assert_true(margin_by_hand(0, 0.5, 0) == 0.5);
    assert_true(margin_by_hand(0, 0.25, 99) == 0); // another constraint's outcome is not its own
    assert_true(margin_by_hand(0, -0.25, 0) == -1);
    assert_true(margin_by_hand(1, 0.5, 0) == 0.5);
    assert_true(margin_by_hand(1, 0.5, 10) == 0.25);
    assert_true(margin_by_hand(1, 0.5, -10) == 0.25);
    assert_true(margin_by_hand(1, 0.5, -60) == -1);
}

// A crash that broke down in any outcome has no margin in another one.
static void margin_of_a_non_finite_outcome_is_the_least(void **state)
{
    (void)state;
    assert_true(margin_by_hand(0, NAN, 0) == -INFINITY);
    assert_true(margin_by_hand(1, NAN, 0) == -INFINITY);
    assert_true(margin_by_hand(0, INFINITY, 0) == -INFINITY);
    double outcomes[OUTCOME_ENERGY_ABSORBED + 2] = {[OUTCOME_S_L] = 0.5};
    outcomes[OUTCOME_TRAVEL_Y] = NAN; // no constraint concerns it
    assert_true(batch_margin(&scenario, 0, outcomes, 1) == -INFINITY);
}

// The outcomes of each sample of a step, by the other way: its values, then the model.
static double *outcomes_of(const struct scenario *of, const struct model *its,
                           const struct sampling *sampling)
{
    const uint32_t count = sampling->samples, variables = of->design_space.count;
    double *values = malloc((size_t)count * variables * sizeof *values);
    double *rows = malloc((size_t)count * variables * sizeof *rows);
    double *outcomes = malloc((size_t)count * model_outcome_count(its) * sizeof *outcomes);
    assert_true(values != NULL && rows != NULL && outcomes != NULL);
    sampling_fill(sampling, &of->design_space, 0, count, values, count);
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t v = 0; v < variables; v++)
            rows[(size_t)i * variables + v] = values[(size_t)v * count + i];
    }
    struct batch_scratch scratch = {0};
    batch_evaluate_designs(its, rows, count, &scratch, outcomes);
    batch_scratch_fini(&scratch);
    free(values);
    free(rows);
    return outcomes;
}

// Asserts that each verdict has the margin of its outcomes: of `targets` a sample, or the least.
static void assert_margins(const struct scenario *of, const struct model *its,
                           const struct sampling *sampling, uint32_t per_attack)
{
    const uint32_t count = sampling->samples;
    const struct batch batch = {
        .sampling = *sampling, .count = count, .detail = VERDICT_DETAIL_MARGIN};
    struct verdict *verdicts = calloc(count, sizeof *verdicts);
    assert_non_null(verdicts);
    batch_evaluate(of, its, &of->design_space, &batch, 2, verdicts);
    double *outcomes = outcomes_of(of, its, sampling);
    for (uint32_t i = 0; i < count; i++) {
        const double *mine = outcomes + (size_t)i * model_outcome_count(its);
        double expected = INFINITY;
        for (uint32_t c = 0; c < of->constraint_count; c++) {
            const bool asked = per_attack == 0 || moves_target(sampling, per_attack, i) == c;
            expected = asked ? fmin(expected, batch_margin(of, c, mine, 1)) : expected;
        }
        assert_true(verdicts[i].margin == (float)expected);
        if (per_attack == 0 && verdicts[i].violation == VERDICT_GOOD)
            assert_true(verdicts[i].margin >= 0);
        if (per_attack == 0 && verdicts[i].violation > 1)
            assert_true(verdicts[i].margin < 0);
    }
    free(outcomes);
    free(verdicts);
}

// Samples of an attack tell the margin of the constraint that it attacks, all others the least one.
static void margins_are_those_that_are_asked_for(void **state)
{
    (void)state;
    static const char *const narrow[] = {"constraints={yaw_deg: {min: -5, max: 5}}"};
    struct scenario two;
    struct error error = {0};
    assert_int_equal(scenario_read_text(&two, "batch", text, strlen(text), narrow, 1, &error),
                     STATUS_OK);
    const struct scenario *of = &two;
    struct model *its = model_create(of);
    struct sampling sampling = {.seed = 3, .samples = SAMPLES, .curves = &of->curves};
    assert_margins(of, its, &sampling, 0);

    assert_true(of->constraint_count > 1);
    const uint32_t variables = of->design_space.count, attacks = of->constraint_count;
    uint8_t *rows = calloc(attacks, 1 + variables);
    assert_non_null(rows);
    for (uint32_t attack = 0; attack < attacks; attack++) {
        rows[attack * (1 + variables)] = (uint8_t)attack;
        for (uint32_t v = 0; v < variables; v++)
            rows[attack * (1 + variables) + 1 + v] = (uint8_t)(attack * 80 + v * 9);
    }
    const struct moves moves = {.variables = variables, .attacks = attacks, .rows = rows};
    const uint32_t per_attack = moves_count(&of->curves, &of->design_space);
    sampling.method = SAMPLING_METHOD_MOVES;
    sampling.moves = &moves;
    sampling.samples = attacks * per_attack;
    assert_margins(of, its, &sampling, per_attack);
    free(rows);
    model_free(its);
    scenario_fini(&two);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(design_within_bounds_is_good),
        cmocka_unit_test(violation_is_relative_to_the_scale),
        cmocka_unit_test(worst_constraint_is_named),
        cmocka_unit_test(non_finite_outcome_is_worst),
        cmocka_unit_test(margin_is_the_distance_to_the_nearest_bound),
        cmocka_unit_test(margin_of_a_non_finite_outcome_is_the_least),
        cmocka_unit_test(margins_are_those_that_are_asked_for),
        cmocka_unit_test(block_is_judged_as_its_designs_are),
        cmocka_unit_test(design_space_has_good_and_bad_designs),
        cmocka_unit_test(thread_count_does_not_matter),
        cmocka_unit_test(pieces_of_a_step_make_the_whole),
        cmocka_unit_test(verdicts_are_those_of_each_sample),
        cmocka_unit_test(given_designs_have_the_outcomes_of_each),
        cmocka_unit_test(fingerprint_is_the_same_each_time),
        cmocka_unit_test(cases_are_good_only_together),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
