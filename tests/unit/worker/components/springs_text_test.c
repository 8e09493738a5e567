#include "worker/components/springs_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <glib.h>

#include <cmocka.h>

// Numbers are short where they can be, and a table without forces leaves them to the user.
static void springs_read_as_a_scenario_has_them(void **state)
{
    (void)state;
    static struct group_list groups;
    static struct spring spring;
    groups.count = 1;
    groups.items[0] = (struct group){
        .name = "rail",
        .box = {{-2.0, -0.6, 0.4}, {-1.0, -0.5, 0.5}},
        .component_count = 1,
    };
    spring = (struct spring){
        .name = "rail",
        .position = {-1.0, -0.55},
        .length = 1.1,
        .height = 0.45,
        .path = 1.0,
        .point_count = 2,
        .deformation = {0.1, 1.1},
        .forces = true,
        .force_upper = {{100e3, 120e3}, {1.5, 2}},
    };
    static const char head[] = "springs:\n"
                               "  # 1 component along 1 m; patch y -0.6 .. -0.5, z 0.4 .. 0.5 m\n"
                               "  - name: rail\n"
                               "    position: [-1, -0.55]\n"
                               "    length: 1.1\n"
                               "    height: 0.45\n"
                               "    deformation: [0.1, 1.1]\n";
    static const char forces[] = "    force_x: {lower: 0, upper: [100000, 120000]}\n"
                                 "    force_y: {lower: 0, upper: [1.5, 2]}\n";
    g_autofree char *text = springs_text(&spring, 1, &groups);
    g_autofree char *expected = g_strconcat(head, forces, NULL);
    assert_string_equal(text, expected);
    spring.forces = false;
    g_autofree char *without = springs_text(&spring, 1, &groups);
    assert_string_equal(without, head);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(springs_read_as_a_scenario_has_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
