#include "worker/reduction/branches.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <glib.h>

#include <cmocka.h>

static void spring_fini(struct design_spring *spring)
{
    struct design design = {g_memdup2(spring, sizeof *spring), 1};
    design_fini(&design);
}

// Up, back a little, further up, down: the load branch holds the two ways up without the stretch
// that was passed twice, the unload branch the way down, ascending.
static void way_up_loads_and_way_down_unloads(void **state)
{
    (void)state;
    static const struct branches_sample samples[] = {
        {0.0, {0, 0}}, {0.2, {10, 1}}, {0.1, {3, 4}}, {0.3, {20, 2}}, {0.25, {7, 1}}, {0.1, {2, 0}},
    };
    static const double load[][3] = {{0.0, 0, 0}, {0.2, 10, 1}, {0.3, 20, 2}};
    static const double unload[][3] = {{0.1, 2, 0}, {0.25, 7, 1}};
    struct design_spring spring = {0};
    assert_true(branches_make(samples, 6, 100, &spring) == 5.0);
    assert_int_equal(spring.load.point_count, 3);
    assert_int_equal(spring.unload.point_count, 2);
    for (int i = 0; i < 3; i++) {
        assert_true(spring.load.deformation[i] == load[i][0]);
        assert_true(spring.load.force[0][i] == load[i][1]);
        assert_true(spring.load.force[1][i] == load[i][2]);
    }
    for (int i = 0; i < 2; i++) {
        assert_true(spring.unload.deformation[i] == unload[i][0]);
        assert_true(spring.unload.force[0][i] == unload[i][1]);
        assert_true(spring.unload.force[1][i] == unload[i][2]);
    }
    spring_fini(&spring);
}

// Every spring of a design has a load branch of two points, also one that was never touched or
// touched once.
static void short_branches_are_completed(void **state)
{
    (void)state;
    static const struct branches_sample sample = {0.4, {30, 5}};
    struct design_spring spring = {0};
    assert_true(branches_make(NULL, 0, 2, &spring) == 0.0);
    assert_int_equal(spring.load.point_count, 2);
    assert_true(spring.load.force[0][1] == 0.0);
    assert_int_equal(spring.unload.point_count, 0);
    spring_fini(&spring);
    spring = (struct design_spring){0};
    assert_true(branches_make(&sample, 1, 2, &spring) == 0.0);
    assert_int_equal(spring.load.point_count, 2);
    assert_true(spring.load.deformation[0] == 0.4 && spring.load.deformation[1] > 0.4);
    assert_true(spring.load.force[0][0] == 30 && spring.load.force[0][1] == 30);
    spring_fini(&spring);
}

// A long branch keeps its ends and its corners: a roof of 1001 points is three of them.
static void thinning_keeps_what_matters(void **state)
{
    (void)state;
    static struct branches_sample samples[1001];
    for (int i = 0; i <= 1000; i++) {
        samples[i] = (struct branches_sample){1e-3 * i, {i < 700 ? i : 1400 - i, 0.5 * i}};
    }
    struct design_spring spring = {0};
    branches_make(samples, 1001, 3, &spring);
    assert_int_equal(spring.load.point_count, 3);
    assert_true(spring.load.deformation[0] == 0.0);
    assert_true(fabs(spring.load.deformation[1] - 0.7) < 1e-12 && spring.load.force[0][1] == 700);
    assert_true(spring.load.deformation[2] == 1.0 && spring.load.force[1][2] == 500);
    spring_fini(&spring);
}

// However many points there are, no more come out than asked for.
static void thinning_never_keeps_too_many(void **state)
{
    (void)state;
    static struct branches_sample samples[5000];
    for (int i = 0; i < 5000; i++) {
        samples[i] = (struct branches_sample){1e-3 * i, {(i * 7919) % 101, (i * 31) % 17}};
    }
    for (uint32_t point_max = 2; point_max < 600; point_max = 2 * point_max + 1) {
        struct design_spring spring = {0};
        branches_make(samples, 5000, point_max, &spring);
        assert_int_equal(spring.load.point_count, point_max);
        for (uint32_t i = 1; i < point_max; i++) {
            assert_true(spring.load.deformation[i] > spring.load.deformation[i - 1]);
        }
        spring_fini(&spring);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(way_up_loads_and_way_down_unloads),
        cmocka_unit_test(short_branches_are_completed),
        cmocka_unit_test(thinning_keeps_what_matters),
        cmocka_unit_test(thinning_never_keeps_too_many),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
