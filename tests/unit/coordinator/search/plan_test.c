#include "coordinator/search/plan.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static struct scenario with_budget(uint64_t evaluations)
{
    return (struct scenario){
        .search = {.samples = 200,
                   .exploration_steps = 100,
                   .consolidation_steps = 50,
                   .certificate_samples = 10000,
                   .target_purity = 0.99,
                   .evaluations = evaluations},
    };
}

static void without_a_budget_all_steps_are_spent(void **state)
{
    (void)state;
    const struct scenario scenario = with_budget(0);
    struct plan plan;
    plan_init(&plan, &scenario, 1000000);
    assert_int_equal(plan.exploration_steps, 100);
    assert_int_equal(plan.consolidation_steps, 50);
    assert_true(plan_steps_affordable(&plan, 1000000, 200) == UINT64_MAX);
}

// 30,000 leave 20,000 beside the certificate, 14,000 after what was spent: 70 steps, shared 2 to 1.
static void budget_is_shared_as_the_steps_are(void **state)
{
    (void)state;
    const struct scenario scenario = with_budget(30000);
    struct plan plan;
    plan_init(&plan, &scenario, 6000);
    assert_int_equal(plan_steps_affordable(&plan, 6000, 200), 70);
    assert_int_equal(plan.exploration_steps, 46);
    assert_int_equal(plan.consolidation_steps, 24);
    assert_int_equal(plan_steps_affordable(&plan, 25000, 200), 0);
}

static void given_start_is_the_only_one_unless_asked(void **state)
{
    (void)state;
    struct scenario scenario = with_budget(0);
    struct plan plan;
    plan_init(&plan, &scenario, 0);
    const uint32_t sought = plan_starts(&plan);
    assert_true(sought > 1);
    double start[1] = {0};
    scenario.search.start = start;
    assert_int_equal(plan_starts(&plan), 1);
    scenario.search.starts = 3;
    assert_int_equal(plan_starts(&plan), 3);
    scenario.search.starts = 1000; // two steps each at least
    assert_int_equal(plan_starts(&plan), 50);
}

// The share aimed at passes the next look, and a missed look makes it smaller.
static void bad_share_lies_below_what_the_certificate_allows(void **state)
{
    (void)state;
    const struct scenario scenario = with_budget(0);
    struct plan plan;
    plan_init(&plan, &scenario, 0);
    struct certificate certificate = {0};
    const double first = plan_bad_share(&plan, &certificate);
    assert_true(first > 0.001 && first < 0.0082);
    certificate_look(&certificate, 10000, 200);
    assert_true(plan_bad_share(&plan, &certificate) < first);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_budget_all_steps_are_spent),
        cmocka_unit_test(budget_is_shared_as_the_steps_are),
        cmocka_unit_test(given_start_is_the_only_one_unless_asked),
        cmocka_unit_test(bad_share_lies_below_what_the_certificate_allows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
