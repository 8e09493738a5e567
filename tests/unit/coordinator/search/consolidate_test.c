#include "coordinator/search/consolidate.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { SAMPLES = 200 };

typedef bool good_function(const double *point, uint32_t variables);

static bool ball(const double *point, uint32_t variables)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += point[v] * point[v];
    return sum <= 1;
}

// All but the upper corner of the unit cube.
static bool cornerless(const double *point, uint32_t variables)
{
    for (uint32_t v = 0; v < variables; v++) {
        if (point[v] <= 0.5)
            return true;
    }
    return false;
}

// Consolidates `box` in `space`; returns the bad share of the result, from fresh points.
static double consolidated(good_function *good, const struct box *space, struct box *box,
                           uint32_t steps, double bad_to)
{
    const uint32_t variables = box->count;
    struct explore explore;
    struct consolidate consolidate;
    struct survey survey;
    struct cloud goods;
    struct cloud bads;
    explore_init(&explore, space, box->lower, 1);
    explore_move(&explore, box);
    consolidate_init(&consolidate, space);
    consolidate_start(&consolidate, &explore, steps, 0.3, bad_to);
    survey_init(&survey, space);
    uint64_t bad = 0;
    for (uint32_t step = 0; step < steps + 50; step++) {
        cloud_init(&goods, variables);
        cloud_init(&bads, variables);
        for (uint32_t i = 0; i < SAMPLES; i++) {
            double point[8];
            for (uint32_t v = 0; v < variables; v++)
                point[v] = explore.sampled.lower[v] +
                           random_uniform(6, 0, step, i, v) *
                               (explore.sampled.upper[v] - explore.sampled.lower[v]);
            const bool is_good = good(point, variables);
            cloud_add(is_good ? &goods : &bads, point, 1, 1);
        }
        survey_add(&survey, &explore.sampled, SAMPLES, &bads, 100000);
        const struct explore_step shown = {.good = &goods,
                                           .bad = &bads,
                                           .samples = SAMPLES,
                                           .good_count = goods.count,
                                           .threads = 1};
        if (step < steps)
            assert_int_equal(consolidate_complete(&consolidate, &explore, shown, &survey),
                             step + 1 == steps);
        else
            bad += bads.count;
        cloud_fini(&goods);
        cloud_fini(&bads);
    }
    box_assign(box, &explore.box);
    survey_fini(&survey);
    consolidate_fini(&consolidate);
    explore_fini(&explore);
    return (double)bad / (50 * SAMPLES);
}

// The box ends near the bad share that was asked for, and near the cube, which is the best shape.
static void ball_is_consolidated_to_the_wanted_share(void **state)
{
    (void)state;
    struct box space = box_cube(4, -2, 2);
    struct box box = box_cube(4, -0.6, 0.6);
    const double share = consolidated(ball, &space, &box, 100, 0.01);
    assert_true(share > 0.004 && share < 0.02);
    for (uint32_t v = 0; v < 4; v++) {
        assert_true(fabs(box.upper[v] - 0.56) < 0.06);
        assert_true(fabs(box.lower[v] + 0.56) < 0.06);
    }
    box_fini(&space);
    box_fini(&box);
}

// The one cut that removes the corner leaves half of the cube.
static void assert_corner_cut(uint32_t variables)
{
    struct box space = box_cube(variables, 0, 1);
    struct box box = box_cube(variables, 0, 1);
    assert_true(consolidated(cornerless, &space, &box, 100, 0.003) < 0.008);
    double volume = 1;
    for (uint32_t v = 0; v < variables; v++)
        volume *= box.upper[v] - box.lower[v];
    if (!(volume > 0.48 && volume < 0.56))
        fail_msg("volume %.4f", volume);
    box_fini(&space);
    box_fini(&box);
}

// Sides in balance would shrink alike in all four variables; the trial of the box without known
// bad samples finds that one cut does.
static void one_cut_removes_a_full_corner(void **state)
{
    (void)state;
    assert_corner_cut(4);
}

// In two and three variables the box is fitted, and finds it too.
static void few_variables_are_fitted(void **state)
{
    (void)state;
    assert_corner_cut(2);
    assert_corner_cut(3);
    struct box space = box_cube(2, -2, 2);
    struct box box = box_cube(2, -0.8, 0.8);
    const double share = consolidated(ball, &space, &box, 100, 0.002);
    assert_true(share < 0.004);
    for (uint32_t v = 0; v < 2; v++) {
        assert_true(fabs(box.upper[v] - 0.72) < 0.08);
        assert_true(fabs(box.lower[v] + 0.72) < 0.08);
    }
    box_fini(&space);
    box_fini(&box);
}

// One step and a few steps end too, without a trial that would not be over.
static void few_steps_are_enough_to_end(void **state)
{
    (void)state;
    struct box space = box_cube(2, -2, 2);
    for (uint32_t steps = 1; steps <= 20; steps++) {
        struct box box = box_cube(2, -0.7, 0.7);
        consolidated(ball, &space, &box, steps, 0.01);
        assert_true(box.upper[0] > box.lower[0]);
        box_fini(&box);
    }
    box_fini(&space);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ball_is_consolidated_to_the_wanted_share),
        cmocka_unit_test(one_cut_removes_a_full_corner),
        cmocka_unit_test(few_variables_are_fitted),
        cmocka_unit_test(few_steps_are_enough_to_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
