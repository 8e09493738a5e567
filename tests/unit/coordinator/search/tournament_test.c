#include "coordinator/search/tournament.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { SAMPLES = 200, STEPS = 100 };

// Good are three balls on a line, around 10, 30 and 50; the middle one is the largest.
static bool good(const double *point)
{
    static const double radii[3] = {1, 4, 2};
    for (int ball = 0; ball < 3; ball++) {
        double sum = 0;
        for (int v = 0; v < 3; v++) {
            const double difference = point[v] - (10 + 20 * ball);
            sum += difference * difference;
        }
        if (sum <= radii[ball] * radii[ball])
            return true;
    }
    return false;
}

static bool step(struct tournament *tournament)
{
    const struct box *sampled = &tournament_current(tournament)->sampled;
    struct cloud goods;
    struct cloud bads;
    cloud_init(&goods, 3);
    cloud_init(&bads, 3);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double point[3];
        for (uint32_t v = 0; v < 3; v++)
            point[v] = sampled->lower[v] + random_uniform(4, 0, tournament->steps, i, v) *
                                               (sampled->upper[v] - sampled->lower[v]);
        cloud_add(good(point) ? &goods : &bads, point, 1, 1);
    }
    const bool spent =
        tournament_complete(tournament, &(struct explore_step){.good = &goods,
                                                               .bad = &bads,
                                                               .samples = SAMPLES,
                                                               .good_count = goods.count,
                                                               .bad_share = 0.3,
                                                               .gain = explore_gain,
                                                               .volume_gain = 1,
                                                               .volume_eager_max = 1,
                                                               .threads = 1});
    cloud_fini(&goods);
    cloud_fini(&bads);
    return spent;
}

// The box of the largest region wins whatever its place in the line, a bad start does no harm, and
// all steps are spent, no more.
static void box_of_the_largest_region_wins(void **state)
{
    (void)state;
    static const double starts[4][4] = {
        {10, 30, 50, 20}, {30, 10, 50, 20}, {20, 50, 30, 10}, {50, 20, 10, 30}};
    struct box space = box_cube(3, 0, 60);
    for (int order = 0; order < 4; order++) {
        struct cloud cloud;
        cloud_init(&cloud, 3);
        for (int i = 0; i < 4; i++)
            cloud_add(&cloud, &starts[order][i], 0, 0);
        struct tournament tournament = {0};
        assert_null(tournament_current(&tournament));
        tournament_start(&tournament, &space, &cloud, STEPS);
        for (uint32_t i = 1; i < STEPS; i++)
            assert_false(step(&tournament));
        assert_true(step(&tournament));
        const struct box *box = &tournament_current(&tournament)->box;
        assert_int_equal(tournament.left_count, 1);
        for (uint32_t v = 0; v < 3; v++)
            assert_true(box->lower[v] > 25 && box->upper[v] < 35);
        tournament_fini(&tournament);
        cloud_fini(&cloud);
    }
    box_fini(&space);
}

// With few steps there are few starts, but never only the middle of the good designs.
static void few_steps_mean_few_starts(void **state)
{
    (void)state;
    assert_int_equal(tournament_starts(0), 2);
    assert_int_equal(tournament_starts(20), 2);
    assert_int_equal(tournament_starts(60), 4);
    assert_int_equal(tournament_starts(100), TOURNAMENT_STARTS);
    assert_int_equal(tournament_starts(100000), TOURNAMENT_STARTS);
}

// A box that needs no tournament is the one left, and is sampled as it stands.
static void award_ends_before_it_starts(void **state)
{
    (void)state;
    struct box space = box_cube(2, 0, 60);
    struct tournament tournament = {0};
    tournament_award(&tournament, &space, &space);
    assert_int_equal(tournament.left_count, 1);
    assert_true(box_equal(&tournament_current(&tournament)->sampled, &space));
    tournament_fini(&tournament);
    box_fini(&space);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_of_the_largest_region_wins),
        cmocka_unit_test(few_steps_mean_few_starts),
        cmocka_unit_test(award_ends_before_it_starts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
