#include "coordinator/search/carve.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// What carve keeps up to date move by move, counted anew.
static void assert_consistent(const struct carve *carve)
{
    const struct cloud *bad = carve->points->cloud;
    for (uint32_t i = 0; i < bad->count; i++) {
        uint32_t count = 0;
        uint32_t sum = 0;
        for (uint32_t v = 0; v < bad->variables; v++) {
            const double coordinate = cloud_column(bad, v)[i];
            const bool below = coordinate < carve->box.lower[v];
            const bool above = coordinate > carve->box.upper[v];
            count += below || above;
            sum += (below || above) ? 2 * v + above : 0;
        }
        assert_int_equal(carve->out[i] & UINT16_MAX, count);
        assert_int_equal(carve->out[i] >> 16, sum);
    }
}

// Limits are kept up through all moves; here each is found anew. A support that got lost would let
// a side move over a bad point, and one that was kept too long would hold it back.
static void assert_limits(const struct carve *carve)
{
    const struct cloud *bad = carve->points->cloud;
    for (uint32_t side = 0; side < 2 * bad->variables; side++) {
        const double *column = cloud_column(bad, side / 2);
        const bool lower = side % 2 == 0;
        double limit = lower ? carve->grown->lower[side / 2] : carve->grown->upper[side / 2];
        for (uint32_t i = 0; i < bad->count; i++) {
            if (carve->out[i] == (side << 16 | 1))
                limit = lower ? fmax(limit, nextafter(column[i], INFINITY))
                              : fmin(limit, nextafter(column[i], -INFINITY));
        }
        assert_true(carve->limit[side] == limit);
    }
}

// Some hundred points, all moves: the bookkeeping must match the box after each, or a bad point
// would be taken for outside.
static void bookkeeping_matches_the_box(void **state)
{
    (void)state;
    struct box grown = box_cube(4, 0, 1);
    struct cloud bad;
    cloud_init(&bad, 4);
    for (uint32_t i = 0; i < 300; i++) {
        double point[4];
        for (uint32_t v = 0; v < 4; v++) // a coarse grid, so that coordinates coincide
            point[v] = floor(20 * random_uniform(1, 0, 0, i, v)) / 20;
        cloud_add(&bad, point, 1, 1);
    }
    const double anchor[4] = {0.51, 0.52, 0.53, 0.54};
    struct carve_points points;
    carve_points_init(&points, &bad, &grown, 1);
    struct carve carve;
    struct carve scratch;
    carve_init(&carve, &grown, &points);
    carve_init(&scratch, &grown, &points);
    carve.anchor = anchor;
    for (uint32_t i = 0; i < bad.count; i++) {
        if (carve_holds(&carve, i))
            assert_true(carve_off(&carve, i, CARVE_SIDE_NONE));
        assert_false(carve_holds(&carve, i));
    }
    assert_consistent(&carve);
    assert_true(box_contains(&carve.box, anchor));
    const struct volume cut = volume_of(&carve.box, &grown);
    carve_expand(&carve);
    assert_consistent(&carve);
    assert_limits(&carve);
    assert_false(volume_above(cut, volume_of(&carve.box, &grown)));
    const struct volume expanded = volume_of(&carve.box, &grown);
    while (carve_improve(&carve, &scratch)) {
        assert_consistent(&carve);
        assert_limits(&carve);
    }
    assert_consistent(&carve);
    assert_limits(&carve);
    assert_false(volume_above(expanded, volume_of(&carve.box, &grown)));
    for (uint32_t i = 0; i < bad.count; i++)
        assert_false(carve_holds(&carve, i));
    assert_true(box_contains(&carve.box, anchor));
    carve_fini(&carve);
    carve_fini(&scratch);
    carve_points_fini(&points);
    cloud_fini(&bad);
    box_fini(&grown);
}

// Both points are cut off at the top, which leaves a third; at the right they cost less. No side
// can move out, so only giving up a support finds that.
static void improving_leaves_a_local_best(void **state)
{
    (void)state;
    struct box grown = box_cube(2, 0, 1);
    struct cloud bad = CLOUD(2, .72, .75, .7, .35);
    const double anchor[2] = {.3, .3};
    struct carve_points points;
    carve_points_init(&points, &bad, &grown, 1);
    struct carve carve;
    struct carve scratch;
    carve_init(&carve, &grown, &points);
    carve_init(&scratch, &grown, &points);
    carve.anchor = anchor;
    carve_cut(&carve, 3, nextafter(.35, 0)); // both points, at the top: .35
    carve_expand(&carve);
    assert_true(carve.box.upper[1] < .35);
    assert_true(carve_improve(&carve, &scratch));
    assert_true(carve.box.upper[0] == nextafter(.7, 0) && carve.box.upper[1] == 1);
    carve_fini(&carve);
    carve_fini(&scratch);
    carve_points_fini(&points);
    cloud_fini(&bad);
    box_fini(&grown);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bookkeeping_matches_the_box),
        cmocka_unit_test(improving_leaves_a_local_best),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
