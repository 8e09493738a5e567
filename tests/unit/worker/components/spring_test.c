#include "worker/components/spring.h"

#include "common/scenario/scenario_read.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <glib.h>

#include <cmocka.h>

static struct component_list components;
static struct group_list groups;
static struct spring spring;

static void read_table(const char *text)
{
    struct error error = {0};
    if (component_parse(&components, "boxes.csv", text, strlen(text), &error) != STATUS_OK ||
        group_make(&groups, &components, &error) != STATUS_OK) {
        fail_msg("%s", error.text);
    }
}

static void make(uint32_t group, double face_x)
{
    struct error error = {0};
    if (spring_make(&spring, &components, &groups, group, face_x, &error) != STATUS_OK) {
        fail_msg("%s", error.text);
    }
}

#define HEADER "name,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m,z_max_m,force_x_N,force_y_N,group\n"

// A crash box, a free way of 0.2 m and a rail behind it: lengths add, the free way does not; the
// curve begins where the crash box does, and its foot is no point.
static void components_in_line_follow_each_other(void **state)
{
    (void)state;
    read_table(HEADER "crash-box,-1.9,-1.7,-0.6,-0.5,0.4,0.5,30e3,10e3,rail\n"
                      "rail,-1.5,-1.0,-0.6,-0.5,0.4,0.5,120e3,50e3,rail\n");
    assert_true(spring_foremost(&groups) == -1.9);
    make(0, -2.0);
    assert_string_equal(spring.name, "rail");
    assert_true(spring.position[0] == -1.0 && spring.position[1] == -0.55);
    assert_true(spring.length == 1.0 && spring.height == 0.45);
    assert_true(spring.path == 0.7);
    static const double deformation[] = {0.1, 0.3, 0.5};
    static const double force_x[] = {30e3, 30e3, 120e3};
    assert_int_equal(spring.point_count, 3);
    for (int i = 0; i < 3; i++) {
        assert_true(spring.deformation[i] == deformation[i]);
        assert_true(spring.force_upper[0][i] == force_x[i]);
    }
    assert_true(spring.force_upper[1][2] == 50e3);
}

// Two rails side by side carry together where both stand.
static void components_side_by_side_add_their_forces(void **state)
{
    (void)state;
    read_table(HEADER "long,-2.0,-1.0,-0.7,-0.6,0.4,0.5,100e3,10e3,rails\n"
                      "short,-1.5,-1.2,-0.6,-0.5,0.4,0.5,50e3,5e3,rails\n");
    make(0, -2.0);
    static const double force_x[] = {100e3, 150e3, 100e3};
    assert_int_equal(spring.point_count, 3);
    for (int i = 0; i < 3; i++) {
        assert_true(spring.force_upper[0][i] == force_x[i]);
    }
    assert_true(spring.path == 1.0);
}

// A spring needs two points: a component alone has its front and its foot.
static void one_component_has_two_points(void **state)
{
    (void)state;
    read_table(HEADER "rail,-2.0,-1.0,-0.6,-0.5,0.4,0.5,100e3,10e3,\n");
    make(0, -2.0);
    assert_int_equal(spring.point_count, 2);
    assert_true(spring.deformation[0] == 0.0 && spring.deformation[1] == 1.0);
    assert_true(spring.force_upper[0][1] == 100e3);
}

static void component_in_front_of_the_face_is_pointed_at(void **state)
{
    (void)state;
    read_table(HEADER "rail,-2.0,-1.0,-0.6,-0.5,0.4,0.5,100e3,10e3,\n");
    struct error error = {0};
    assert_int_equal(spring_make(&spring, &components, &groups, 0, -1.9, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "boxes.csv:2:1: x_min_m: expected at least -1.9 m"));
}

static void more_ends_than_points_are_refused(void **state)
{
    (void)state;
    g_autoptr(GString) text = g_string_new(HEADER);
    for (int i = 0; i < 33; i++) {
        g_string_append_printf(text, "c%d,%g,%g,-0.6,-0.5,0.4,0.5,1,1,rail\n", i, -2.0 + 0.01 * i,
                               -1.99 + 0.01 * i);
    }
    read_table(text->str);
    struct error error = {0};
    assert_int_equal(spring_make(&spring, &components, &groups, 0, -2.0, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "group rail: its components begin and end at 33 places"));
}

// The boxes of the sedan's five groups (thesis figure 8.6) are the springs of its scenario.
static void boxes_of_the_sedan_are_its_ten_springs(void **state)
{
    (void)state;
    g_autofree char *text = NULL;
    assert_true(g_file_get_contents(SOBOX_SOURCE_DIR "/deploy/scenarios/sedan-components.csv",
                                    &text, NULL, NULL));
    read_table(text);
    struct scenario scenario = {0};
    struct error error = {0};
    if (scenario_read_file(&scenario, SOBOX_SOURCE_DIR "/deploy/scenarios/sedan-ten-springs.yaml",
                           NULL, 0, &error) != STATUS_OK) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(groups.count, scenario.spring_count);
    for (uint32_t i = 0; i < groups.count; i++) {
        const struct scenario_spring *expected = &scenario.springs[i];
        make(i, scenario.barrier.face_x);
        assert_string_equal(spring.name, expected->name);
        assert_true(spring.position[0] == expected->position[0]);
        assert_true(spring.position[1] == expected->position[1]);
        assert_true(fabs(spring.length - expected->length) < 1e-9);
        assert_int_equal(spring.point_count, expected->point_count);
        for (uint32_t point = 0; point < spring.point_count; point++) {
            assert_true(spring.deformation[point] == expected->deformation[point]);
            for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
                assert_true(spring.force_upper[k][point] == expected->force_upper[k][point]);
            }
        }
    }
    scenario_fini(&scenario);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(components_in_line_follow_each_other),
        cmocka_unit_test(components_side_by_side_add_their_forces),
        cmocka_unit_test(one_component_has_two_points),
        cmocka_unit_test(component_in_front_of_the_face_is_pointed_at),
        cmocka_unit_test(more_ends_than_points_are_refused),
        cmocka_unit_test(boxes_of_the_sedan_are_its_ten_springs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
