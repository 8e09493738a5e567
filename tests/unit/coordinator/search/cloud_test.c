#include "tests/unit/coordinator/search/cloud_of.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// Growing moves the columns apart; a value left behind would end up in another variable.
static void points_survive_growth(void **state)
{
    (void)state;
    struct cloud cloud;
    cloud_init(&cloud, 3);
    for (uint32_t i = 0; i < 1000; i++)
        cloud_add(&cloud, (double[]){i, 0.5 * i, -1.0 * i}, 1, (uint16_t)i);
    assert_int_equal(cloud.count, 1000);
    for (uint32_t i = 0; i < 1000; i++) {
        assert_true(cloud_column(&cloud, 0)[i] == i);
        assert_true(cloud_column(&cloud, 1)[i] == 0.5 * i);
        assert_true(cloud_column(&cloud, 2)[i] == -1.0 * i);
        assert_int_equal(cloud.violation[i], i);
    }
    cloud_fini(&cloud);
}

// Points on a bound belong to the box; blocks of the filter join without loss.
static void inside_keeps_what_the_box_contains(void **state)
{
    (void)state;
    struct cloud all;
    struct cloud some;
    cloud_init(&all, 2);
    cloud_init(&some, 2);
    for (uint32_t i = 0; i < 3000; i++)
        cloud_add(&all, (double[]){i % 10, i % 7}, 1, (uint16_t)i);
    struct box box = box_cube(2, 2, 4);
    cloud_add_inside(&some, &all, &box);
    uint32_t expected = 0;
    for (uint32_t i = 0; i < 3000; i++) {
        if (i % 10 < 2 || i % 10 > 4 || i % 7 < 2 || i % 7 > 4)
            continue;
        assert_int_equal(some.violation[expected], i);
        assert_true(cloud_column(&some, 1)[expected] == i % 7);
        expected++;
    }
    assert_int_equal(some.count, expected);
    box_fini(&box);
    cloud_fini(&all);
    cloud_fini(&some);
}

// The view holds the last points and leaves the cloud alone.
static void newest_points_are_a_view(void **state)
{
    (void)state;
    struct cloud cloud = CLOUD(2, 1, 10, 2, 20, 3, 30);
    const struct cloud newest = cloud_newest(&cloud, 2);
    assert_int_equal(newest.count, 2);
    assert_true(cloud_column(&newest, 0)[0] == 2 && cloud_column(&newest, 1)[1] == 30);
    assert_int_equal(cloud_newest(&cloud, 5).count, 3);
    assert_int_equal(cloud.count, 3);
    cloud_fini(&cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(newest_points_are_a_view),
        cmocka_unit_test(points_survive_growth),
        cmocka_unit_test(inside_keeps_what_the_box_contains),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
