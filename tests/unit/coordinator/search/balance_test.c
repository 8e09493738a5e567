#include "coordinator/search/balance.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { SAMPLES = 200 };

// Bad where the weighted sum of squares exceeds 1: an ellipsoid.
static uint32_t sample(const struct box *box, const double *weights, uint32_t step,
                       struct cloud *bad)
{
    cloud_clear(bad);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double point[8];
        double sum = 0;
        for (uint32_t v = 0; v < box->count; v++) {
            point[v] =
                box->lower[v] + random_uniform(3, 0, step, i, v) * (box->upper[v] - box->lower[v]);
            sum += weights[v] * point[v] * point[v];
        }
        if (sum > 1)
            cloud_add(bad, point, 1, 1);
    }
    return bad->count;
}

// The largest box in an ellipsoid is the cube in a ball, stretched: the widths go as 1 / sqrt of
// the weights and it is centred. Balancing must find that shape from a lopsided start.
static void sides_come_to_the_largest_shape(void **state)
{
    (void)state;
    const double weights[4] = {1, 4, 9, 16};
    struct box space = box_cube(4, -2, 2);
    struct box box = box_cube(4, -0.1, 0.25);
    struct balance balance;
    struct cloud bad;
    balance_init(&balance, 4);
    cloud_init(&bad, 4);
    double width[4] = {0};
    double centre[4] = {0};
    uint32_t bad_count = 0;
    for (uint32_t step = 0; step < 400; step++) {
        sample(&box, weights, step, &bad);
        const struct balance_step balancing = {.samples = SAMPLES,
                                               .bad = &bad,
                                               .bad_count = bad.count,
                                               .bad_share = 0.2,
                                               .gain = 0.1,
                                               .volume_gain = 0.5,
                                               .volume_eager_max = 1,
                                               .threads = 1};
        balance_move(&balance, &box, &space, &balancing);
        if (step < 200)
            continue;
        bad_count += bad.count;
        for (uint32_t v = 0; v < 4; v++) {
            width[v] += (box.upper[v] - box.lower[v]) / 200;
            centre[v] += (box.upper[v] + box.lower[v]) / 400;
        }
    }
    assert_true(fabs(bad_count / (200.0 * SAMPLES) - 0.2) < 0.02);
    for (uint32_t v = 0; v < 4; v++) {
        assert_true(fabs(width[v] * sqrt(weights[v]) / width[0] - 1) < 0.06);
        assert_true(fabs(centre[v]) < 0.04 * width[v]);
    }
    balance_fini(&balance);
    cloud_fini(&bad);
    box_fini(&space);
    box_fini(&box);
}

// Without bad samples all sides move out together, never past the design space.
static void good_box_grows_into_the_space(void **state)
{
    (void)state;
    struct box space = box_cube(2, 0, 1);
    struct box box = box_cube(2, 0.4, 0.6);
    struct balance balance;
    struct cloud none;
    balance_init(&balance, 2);
    cloud_init(&none, 2);
    const struct balance_step balancing = {.samples = SAMPLES,
                                           .bad = &none,
                                           .bad_share = 0.25,
                                           .gain = 0.1,
                                           .volume_gain = 1,
                                           .volume_eager_max = 1,
                                           .threads = 1};
    balance_move(&balance, &box, &space, &balancing);
    assert_true(box.lower[0] < 0.4 && box.upper[0] > 0.6);
    assert_true(box.lower[0] == box.lower[1] && box.upper[0] == box.upper[1]);
    for (int step = 0; step < 100; step++)
        balance_move(&balance, &box, &space, &balancing);
    assert_true(box_equal(&box, &space));
    balance_fini(&balance);
    cloud_fini(&none);
    box_fini(&space);
    box_fini(&box);
}

// A box that is far too small grows faster and faster where that is allowed.
static void small_box_gathers_speed(void **state)
{
    (void)state;
    struct box space = box_cube(2, -1000, 1000);
    struct cloud none;
    cloud_init(&none, 2);
    double width[2];
    for (int eager = 0; eager < 2; eager++) {
        struct box box = box_cube(2, -1, 1);
        struct balance balance;
        balance_init(&balance, 2);
        const struct balance_step balancing = {.samples = SAMPLES,
                                               .bad = &none,
                                               .bad_share = 0.25,
                                               .gain = 0.1,
                                               .volume_gain = 0.1,
                                               .volume_eager_max = eager ? 4 : 1,
                                               .threads = 1};
        for (int step = 0; step < 20; step++)
            balance_move(&balance, &box, &space, &balancing);
        width[eager] = box.upper[0] - box.lower[0];
        balance_fini(&balance);
        box_fini(&box);
    }
    assert_true(width[1] > 2 * width[0]);
    cloud_fini(&none);
    box_fini(&space);
}

// A variable whose interval has no width stays as it is and divides nothing by zero.
static void flat_variable_stays(void **state)
{
    (void)state;
    struct box space = box_cube(2, 0, 1);
    struct box box = box_cube(2, 0.2, 0.8);
    box.lower[1] = box.upper[1] = 0.5;
    struct balance balance;
    struct cloud bad = CLOUD(2, 0.79, 0.5, 0.78, 0.5);
    balance_init(&balance, 2);
    const struct balance_step balancing = {.samples = 10,
                                           .bad = &bad,
                                           .bad_count = bad.count,
                                           .bad_share = 0.2,
                                           .gain = 0.1,
                                           .volume_gain = 1,
                                           .volume_eager_max = 1,
                                           .threads = 1};
    balance_move(&balance, &box, &space, &balancing);
    assert_true(box.lower[1] == 0.5 && box.upper[1] == 0.5);
    assert_true(box.upper[0] < 0.8 && isfinite(box.lower[0]));
    balance_fini(&balance);
    cloud_fini(&bad);
    box_fini(&space);
    box_fini(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_come_to_the_largest_shape),
        cmocka_unit_test(good_box_grows_into_the_space),
        cmocka_unit_test(small_box_gathers_speed),
        cmocka_unit_test(flat_variable_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
