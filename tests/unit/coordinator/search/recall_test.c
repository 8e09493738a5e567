#include "coordinator/search/recall.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { VARIABLES = 3, SAMPLES = 10000 };

static double lower[VARIABLES] = {0, 4, -1};
static double upper[VARIABLES] = {1, 4, 1};
static const struct scenario scenario = {
    .design_space = {.count = VARIABLES, .lower = lower, .upper = upper}};
static const struct sampling sampling = {.seed = 7, .step = 3, .samples = SAMPLES};
static struct verdict verdicts[SAMPLES];
static double all[VARIABLES * SAMPLES];

// Every third sample is bad, by its own number.
static uint32_t judge(uint32_t good_every)
{
    uint32_t good = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const bool is_good = good_every > 0 && i % good_every != 0;
        verdicts[i] = (struct verdict){.violation = is_good ? VERDICT_GOOD : (uint16_t)(i + 1)};
        good += is_good;
    }
    return good;
}

static void assert_sample(const struct cloud *cloud, uint32_t point, uint32_t sample)
{
    assert_true(cloud_column(cloud, 0)[point] == all[sample]);
    assert_true(cloud_column(cloud, 1)[point] == all[2 * SAMPLES + sample]);
}

static struct recall recalled(struct frame *frame, uint32_t good_count, bool known)
{
    struct recall recall;
    frame_init(frame, &scenario);
    recall_init(&recall, frame);
    sampling_fill(&sampling, &scenario.design_space, 0, SAMPLES, all, SAMPLES);
    recall_step(&recall, &sampling, &scenario.design_space, verdicts, good_count, known);
    return recall;
}

// The bits are those that a worker evaluated, in the free variables only, and of a large step the
// first ones serve.
static void first_samples_come_again(void **state)
{
    (void)state;
    struct frame frame;
    struct recall recall = recalled(&frame, judge(3), true);
    assert_int_equal(recall.good.count, 512);
    assert_int_equal(recall.bad.count, 2048);
    assert_int_equal(recall.looked_at, 3 * 2047 + 1);
    for (uint32_t i = 0; i < recall.bad.count; i++) {
        assert_sample(&recall.bad, i, 3 * i);
        assert_int_equal(recall.bad.violation[i], 3 * i + 1);
    }
    assert_sample(&recall.good, 0, 1);
    assert_sample(&recall.good, 1, 2);
    recall_fini(&recall);
    frame_fini(&frame);
}

// Where nothing is good the least violating one may be the last.
static void all_are_looked_at_while_none_is_good(void **state)
{
    (void)state;
    struct frame frame;
    struct recall recall = recalled(&frame, judge(0), true);
    assert_int_equal(recall.good.count, 0);
    assert_int_equal(recall.bad.count, SAMPLES);
    assert_int_equal(recall.looked_at, SAMPLES);
    recall_fini(&recall);
    frame_fini(&frame);
}

static void unknown_violations_are_the_least(void **state)
{
    (void)state;
    struct frame frame;
    struct recall recall = recalled(&frame, judge(2), false);
    for (uint32_t i = 0; i < recall.bad.count; i++)
        assert_int_equal(recall.bad.violation[i], 1);
    recall_fini(&recall);
    frame_fini(&frame);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_samples_come_again),
        cmocka_unit_test(all_are_looked_at_while_none_is_good),
        cmocka_unit_test(unknown_violations_are_the_least),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
