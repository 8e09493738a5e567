#include "coordinator/search/explore.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { SAMPLES = 200 };

// Samples the box that exploration asks for; good is the ball of radius `radius` around `centre`.
static uint32_t step(struct explore *explore, double centre, double radius, uint32_t number)
{
    const uint32_t variables = explore->space->count;
    struct cloud good;
    struct cloud bad;
    cloud_init(&good, variables);
    cloud_init(&bad, variables);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double point[8];
        double sum = 0;
        for (uint32_t v = 0; v < variables; v++) {
            const double width = explore->sampled.upper[v] - explore->sampled.lower[v];
            point[v] = explore->sampled.lower[v] + random_uniform(2, 0, number, i, v) * width;
            sum += (point[v] - centre) * (point[v] - centre);
        }
        cloud_add(sum <= radius * radius ? &good : &bad, point, 1, 1);
    }
    const uint32_t good_count = good.count;
    explore_complete(explore, &(struct explore_step){.good = &good,
                                                     .bad = &bad,
                                                     .samples = SAMPLES,
                                                     .good_count = good_count,
                                                     .bad_share = 0.3,
                                                     .gain = 0.15,
                                                     .volume_gain = 1,
                                                     .volume_eager_max = 1,
                                                     .threads = 1});
    cloud_fini(&good);
    cloud_fini(&bad);
    return good_count;
}

// A point becomes a box about the size of the ball in a dozen steps, whatever its size.
static void point_grows_to_the_size_of_the_region(void **state)
{
    (void)state;
    static const double radii[] = {3, 0.3, 0.01};
    struct box space = box_cube(3, -10, 10);
    for (int i = 0; i < 3; i++) {
        struct explore explore;
        explore_init(&explore, &space, (const double[]){2, 2, 2}, 1);
        for (uint32_t number = 0; number < 15; number++)
            step(&explore, 2, radii[i], number);
        assert_true(explore.grown);
        for (uint32_t v = 0; v < 3; v++) {
            const double width = explore.box.upper[v] - explore.box.lower[v];
            assert_true(width > 0.5 * radii[i] && width < 2.2 * radii[i]);
        }
        explore_fini(&explore);
    }
    box_fini(&space);
}

// A growth that swallows the good region is taken back: the box stays and the next growth is less.
static void bad_growth_is_taken_back(void **state)
{
    (void)state;
    struct box space = box_cube(2, -10, 10);
    struct explore explore;
    explore_init(&explore, &space, (const double[]){0, 0}, 1);
    const double rate = explore.growth.rate;
    assert_int_equal(step(&explore, 50, 1, 0), 0);
    assert_true(explore.box.lower[0] == 0 && explore.box.upper[0] == 0);
    assert_true(explore.growth.rate < rate);
    explore_fini(&explore);
    box_fini(&space);
}

// Settled, it samples the box as it stands and holds the good share at what is wanted.
static void settled_box_keeps_its_share(void **state)
{
    (void)state;
    struct box space = box_cube(3, -10, 10);
    struct explore explore;
    explore_init(&explore, &space, (const double[]){1, -1, 0}, 1);
    uint32_t number = 0;
    while (number < 15)
        step(&explore, 0, 4, number++);
    explore_settle(&explore);
    uint32_t good = 0;
    for (uint32_t i = 0; i < 100; i++) {
        assert_true(box_equal(&explore.box, &explore.sampled));
        uint32_t count = step(&explore, 0, 4, number++);
        good += i >= 50 ? count : 0;
    }
    assert_true(fabs(good / (50.0 * SAMPLES) - 0.7) < 0.03);
    explore_fini(&explore);
    box_fini(&space);
}

// The box with more room is ahead, whichever was made first.
static void box_in_the_larger_region_is_ahead(void **state)
{
    (void)state;
    struct box space = box_cube(3, -10, 10);
    struct explore small;
    struct explore large;
    explore_init(&small, &space, (const double[]){0, 0, 0}, 1);
    explore_init(&large, &space, (const double[]){0, 0, 0}, 1);
    for (uint32_t number = 0; number < 10; number++) {
        step(&small, 0, 1, number);
        step(&large, 0, 2, number);
    }
    assert_true(explore_ahead(&large, &small));
    assert_false(explore_ahead(&small, &large));
    explore_fini(&small);
    explore_fini(&large);
    box_fini(&space);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(point_grows_to_the_size_of_the_region),
        cmocka_unit_test(bad_growth_is_taken_back),
        cmocka_unit_test(settled_box_keeps_its_share),
        cmocka_unit_test(box_in_the_larger_region_is_ahead),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
