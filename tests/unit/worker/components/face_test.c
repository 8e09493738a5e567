#include "worker/components/face.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static struct group_list groups;
static struct face_check check;
static const struct face open_face = {INFINITY, -INFINITY};

static int set_up(void **state)
{
    (void)state;
    memset(&groups, 0, sizeof groups);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    face_check_fini(&check);
    return 0;
}

static void add(double y_min, double y_max, double z_min, double z_max)
{
    groups.items[groups.count++].box =
        (struct component_box){{-2.0, y_min, z_min}, {-1.0, y_max, z_max}};
}

static void assert_place(const struct face_place *place, double y_min, double y_max, double z_min,
                         double z_max)
{
    assert_true(fabs(place->y[0] - y_min) < 1e-12 && fabs(place->y[1] - y_max) < 1e-12);
    assert_true(fabs(place->z[0] - z_min) < 1e-12 && fabs(place->z[1] - z_max) < 1e-12);
}

// Two columns and two rows that fill the front have neither overlap nor gap.
static void tiles_fill_the_front(void **state)
{
    (void)state;
    add(-0.9, -0.7, 0.2, 0.6);
    add(-0.9, -0.7, 0.6, 1.0);
    add(-0.7, -0.5, 0.2, 1.0);
    face_check_make(&check, &groups, &open_face);
    assert_int_equal(check.overlap_count, 0);
    assert_int_equal(check.gap_count, 0);
    assert_place(&check.front, -0.9, -0.5, 0.2, 1.0);
}

// The larger overlap comes first, each with its groups; one of less than 1 cm2 is not told.
static void overlaps_are_told_by_size(void **state)
{
    (void)state;
    add(-0.9, -0.7, 0.2, 0.6);
    add(-0.75, -0.5, 0.2, 0.6);
    add(-0.9, -0.5, 0.4, 1.0);
    add(-0.9, -0.5, 0.9999, 1.2);
    face_check_make(&check, &groups, &open_face);
    assert_int_equal(check.overlap_count, 3);
    assert_int_equal(check.overlaps[0].one, 1);
    assert_int_equal(check.overlaps[0].other, 2);
    assert_place(&check.overlaps[0], -0.75, -0.5, 0.4, 0.6);
    assert_true(fabs(face_area(&check.overlaps[0]) - 0.05) < 1e-12);
    assert_place(&check.overlaps[1], -0.9, -0.7, 0.4, 0.6);
    assert_place(&check.overlaps[2], -0.75, -0.7, 0.2, 0.6);
}

// Gaps are disjoint and add up to what the patches leave of the front, which ends where the
// barrier's face does: also where a group reaches further.
static void gaps_reach_to_the_ends_of_the_face(void **state)
{
    (void)state;
    add(-0.9, -0.7, 0.2, 0.6);
    add(-0.6, -0.5, 0.2, 1.0);
    face_check_make(&check, &groups, &(struct face){.edge_y = -0.35, .far_y = -0.8});
    assert_place(&check.front, -0.8, -0.35, 0.2, 1.0);
    assert_true(fabs(check.gap_area - (0.36 - 0.04 - 0.08)) < 1e-12);
    double sum = 0.0;
    for (uint32_t i = 0; i < check.gap_count; i++) {
        assert_true(i == 0 || face_area(&check.gaps[i]) <= face_area(&check.gaps[i - 1]));
        sum += face_area(&check.gaps[i]);
    }
    assert_true(fabs(sum - check.gap_area) < 1e-12);
    assert_int_equal(check.gap_count, 3);
    assert_place(&check.gaps[0], -0.5, -0.35, 0.2, 1.0);
}

static void width_beside_the_face_is_measured(void **state)
{
    (void)state;
    add(-0.6, -0.4, 0.2, 0.6);
    add(-0.3, -0.1, 0.2, 0.6);
    const struct face face = {.edge_y = -0.45, .far_y = -0.55};
    assert_true(fabs(face_beside(&groups.items[0], &face) - 0.1) < 1e-12);
    assert_true(fabs(face_beside(&groups.items[1], &face) - 0.2) < 1e-12);
    assert_true(face_beside(&groups.items[1], &open_face) == 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(tiles_fill_the_front, set_up, tear_down),
        cmocka_unit_test_setup_teardown(overlaps_are_told_by_size, set_up, tear_down),
        cmocka_unit_test_setup_teardown(gaps_reach_to_the_ends_of_the_face, set_up, tear_down),
        cmocka_unit_test_setup_teardown(width_beside_the_face_is_measured, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
