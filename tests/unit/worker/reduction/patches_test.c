#include "worker/reduction/patches.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static struct scenario_spring springs[4];
static struct scenario scenario;
static struct patches patches;

// A car against a face from y = -1.6 to -0.4, 2 m ahead. Springs in no particular order: two at the
// wheel, one above the other, one at the rail, one beside the barrier.
static int set_up(void **state)
{
    (void)state;
    static const double places[4][2] = {{-0.5, NAN}, {-0.8, 0.7}, {-0.2, NAN}, {-0.8, 0.3}};
    scenario = (struct scenario){
        .name = "car",
        .barrier = {.face_x = -2.0, .edge_y = -0.4, .width = 1.2, .edge_radius = 0.15},
        .springs = springs,
        .spring_count = 4,
    };
    memset(springs, 0, sizeof springs);
    for (int i = 0; i < 4; i++) {
        springs[i] = (struct scenario_spring){
            .name = {(char)('a' + i)},
            .position = {-0.8, places[i][0]},
            .length = 1.2,
            .height = places[i][1],
        };
    }
    struct error error;
    assert_int_equal(patches_init(&patches, &scenario, NULL, &error), STATUS_OK);
    return 0;
}

// Straight on, the columns meet half-way between y = -0.8 and -0.5 and reach to the face's ends;
// the spring at -0.2 passes the barrier and has no patch. Rows meet half-way between 0.3 and 0.7.
static void borders_lie_half_way(void **state)
{
    (void)state;
    patches_move(&patches, 0.0, 0.0, 0.0);
    assert_int_equal(patches_find(&patches, -0.66, 0.2), 3);
    assert_int_equal(patches_find(&patches, -0.66, 0.49), 3);
    assert_int_equal(patches_find(&patches, -0.66, 0.51), 1);
    assert_int_equal(patches_find(&patches, -0.64, 0.2), 0);
    assert_int_equal(patches_find(&patches, -0.4, 0.2), 0);
    assert_int_equal(patches_find(&patches, -1.6, 5.0), 1);
    assert_int_equal(patches_find(&patches, -0.39, 0.2), PATCHES_NONE);
    assert_int_equal(patches_find(&patches, -1.61, 0.2), PATCHES_NONE);
    assert_int_equal(patches_find(&patches, (double)NAN, 0.2), PATCHES_NONE);
}

// Moved aside by 0.15 m, the rail has passed the face's end: the wheel takes the whole face.
static void patches_move_with_the_vehicle(void **state)
{
    (void)state;
    patches_move(&patches, -0.3, 0.05, 0.0);
    assert_int_equal(patches_find(&patches, -0.61, 0.2), 3);
    assert_int_equal(patches_find(&patches, -0.59, 0.2), 0);
    patches_move(&patches, -0.3, 0.15, 0.0);
    assert_false(patches.springs[0].projected);
    assert_int_equal(patches_find(&patches, -0.41, 0.2), 3);
    patches_move(&patches, -0.3, 0.45, 0.0);
    assert_int_equal(patches_find(&patches, -0.41, 0.2), PATCHES_NONE);
}

// Equations 6.9 to 6.12 as the thesis has them: P1 turned with the car, P2 along its axis.
static void projection_follows_the_equations(void **state)
{
    (void)state;
    const double x = -0.4;
    const double y = 0.02;
    const double yaw = 0.2;
    patches_move(&patches, x, y, yaw);
    for (int i = 0; i < 4; i++) {
        const double *p = springs[i].position;
        const double p1_x = x + p[0] * cos(yaw) - p[1] * sin(yaw);
        const double p1_y = y + p[0] * sin(yaw) + p[1] * cos(yaw);
        const double length = (p1_x + 2.0) / cos(yaw);
        assert_true(fabs(patches.springs[i].projection - (p1_y - (p1_x + 2.0) * tan(yaw))) < 1e-12);
        assert_true(fabs(patches.springs[i].deformation - (1.2 - length)) < 1e-12);
    }
}

// On a rounded edge P2 lies on the circle; a line that misses it has no projection.
static void rounded_edge_is_met_on_its_circle(void **state)
{
    (void)state;
    scenario.barrier.profile = SCENARIO_PROFILE_ROUNDED;
    patches_move(&patches, -0.3, 0.03, 0.0); // the rail's line at y = -0.47
    const double rise = -0.47 - -0.55;
    const double back = 0.15 - sqrt(0.15 * 0.15 - rise * rise);
    assert_true(patches.springs[0].projected);
    assert_true(fabs(patches.springs[0].projection - -0.47) < 1e-12);
    assert_true(fabs(patches.springs[0].deformation - (0.3 - back)) < 1e-12);
    assert_true(fabs(patches.springs[3].deformation - 0.3) < 1e-12);
    patches_move(&patches, -0.3, 0.11, 0.0);
    assert_false(patches.springs[0].projected);
}

// Beyond a quarter turn lines point away from the barrier.
static void quarter_turn_leaves_no_patch(void **state)
{
    (void)state;
    patches_move(&patches, -0.3, 0.0, 1.6);
    assert_int_equal(patches_find(&patches, -0.5, 0.2), PATCHES_NONE);
    patches_move(&patches, -0.3, 0.0, -1.6);
    assert_int_equal(patches_find(&patches, -0.5, 0.2), PATCHES_NONE);
}

// Two springs at one y cannot be told apart without heights, or with equal ones.
static void springs_that_share_y_need_heights(void **state)
{
    (void)state;
    static const double wrong[][2] = {{NAN, 0.3}, {0.7, NAN}, {0.3, 0.3}, {NAN, NAN}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        springs[1].height = wrong[i][0];
        springs[3].height = wrong[i][1];
        struct error error;
        assert_int_equal(patches_init(&patches, &scenario, NULL, &error), STATUS_INVALID);
        assert_non_null(strstr(error.text, "share y = -0.8 m"));
    }
}

// With boxes a force goes to the nearest rectangle, in an overlap to the nearest middle, and the
// rectangles move with the car; heights are not asked for, groups of all springs are.
static void boxes_take_what_is_nearest(void **state)
{
    (void)state;
    static const double patches_of[4][4] = {{-0.6, -0.4, 0.2, 0.4},
                                            {-0.9, -0.7, 0.6, 0.8},
                                            {-0.3, -0.1, 0.2, 0.4},
                                            {-0.9, -0.58, 0.2, 0.4}};
    static struct group_list groups = {.count = 4};
    for (int i = 0; i < 4; i++) {
        const double *p = patches_of[i];
        groups.items[i] = (struct group){.name = {(char)('a' + i)},
                                         .box = {{-2.0, p[0], p[2]}, {-0.8, p[1], p[3]}}};
        springs[i].height = (double)NAN;
    }
    struct error error = {0};
    assert_int_equal(patches_init(&patches, &scenario, &groups, &error), STATUS_OK);
    patches_move(&patches, 0.0, 0.0, 0.0);
    assert_int_equal(patches_find(&patches, -0.65, 0.3), 3);
    assert_int_equal(patches_find(&patches, -0.65, 0.55), 1);
    assert_int_equal(patches_find(&patches, -0.65, 0.45), 3);
    assert_int_equal(patches_find(&patches, -0.582, 0.3), 0);
    assert_int_equal(patches_find(&patches, -0.41, 0.5), 0);
    assert_int_equal(patches_find(&patches, -0.39, 0.3), PATCHES_NONE);
    patches_move(&patches, -0.3, 0.05, 0.0);
    assert_int_equal(patches_find(&patches, -0.56, 0.3), 3);
    patches_move(&patches, -0.3, 0.15, 0.0);
    assert_int_equal(patches_find(&patches, -0.41, 0.3), 3);
    groups.count = 3;
    assert_int_equal(patches_init(&patches, &scenario, &groups, &error), STATUS_INVALID);
    assert_string_equal(error.text,
                        "car: spring d has no components: expected a group of its name");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(borders_lie_half_way, set_up),
        cmocka_unit_test_setup(patches_move_with_the_vehicle, set_up),
        cmocka_unit_test_setup(projection_follows_the_equations, set_up),
        cmocka_unit_test_setup(rounded_edge_is_met_on_its_circle, set_up),
        cmocka_unit_test_setup(quarter_turn_leaves_no_patch, set_up),
        cmocka_unit_test_setup(springs_that_share_y_need_heights, set_up),
        cmocka_unit_test_setup(boxes_take_what_is_nearest, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
