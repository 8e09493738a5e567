#include "worker/components/group.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static struct component_list components;
static struct group_list groups;

static int set_up(void **state)
{
    (void)state;
    memset(&components, 0, sizeof components);
    components.source = "boxes.csv";
    return 0;
}

static void add(const char *name, const char *group, struct component_box box)
{
    struct component *item = &components.items[components.count++];
    snprintf(item->name, sizeof item->name, "%s", name);
    snprintf(item->group, sizeof item->group, "%s", group);
    item->box = box;
}

// The box of a group is around its components, wherever they stand.
static void named_components_share_their_group(void **state)
{
    (void)state;
    add("tyre", "wheel", (struct component_box){{-1.5, -0.9, 0.1}, {-1.1, -0.6, 0.7}});
    add("shotgun", "shotgun", (struct component_box){{-1.9, -0.8, 0.7}, {-0.8, -0.6, 1.0}});
    add("rim", "wheel", (struct component_box){{-1.1, -0.8, 0.2}, {-0.8, -0.5, 0.6}});
    struct error error;
    assert_int_equal(group_make(&groups, &components, &error), STATUS_OK);
    assert_int_equal(groups.count, 2);
    assert_string_equal(groups.items[0].name, "wheel");
    assert_string_equal(groups.items[1].name, "shotgun");
    assert_int_equal(groups.of[2], 0);
    assert_int_equal(groups.items[0].component_count, 2);
    assert_true(groups.items[0].box.min[0] == -1.5 && groups.items[0].box.max[0] == -0.8);
    assert_true(groups.items[0].box.min[1] == -0.9 && groups.items[0].box.max[1] == -0.5);
    assert_true(groups.items[0].box.min[2] == 0.1 && groups.items[0].box.max[2] == 0.7);
}

// A crash box stands in line with the rail behind it, a narrow rail in line with a wide one; a
// shotgun that only touches them does not, nor does a component that lies beside by more than half.
static void components_in_line_share_a_spring(void **state)
{
    (void)state;
    add("crash-box", "", (struct component_box){{-2.0, -0.6, 0.4}, {-1.8, -0.5, 0.5}});
    add("shotgun", "", (struct component_box){{-1.9, -0.8, 0.5}, {-0.8, -0.5, 0.8}});
    add("rail", "", (struct component_box){{-1.8, -0.58, 0.42}, {-1.0, -0.48, 0.52}});
    add("beside", "", (struct component_box){{-1.8, -0.54, 0.4}, {-1.0, -0.30, 0.5}});
    struct error error;
    assert_int_equal(group_make(&groups, &components, &error), STATUS_OK);
    assert_int_equal(groups.count, 3);
    assert_string_equal(groups.items[0].name, "crash-box");
    assert_int_equal(groups.of[2], groups.of[0]);
    assert_int_not_equal(groups.of[1], groups.of[0]);
    assert_int_not_equal(groups.of[3], groups.of[0]);
}

// What stands in line with a named group belongs to it, also where the table names it first.
static void named_groups_take_what_stands_in_line(void **state)
{
    (void)state;
    add("bumper", "", (struct component_box){{-2.0, -0.8, 0.2}, {-1.9, -0.7, 0.6}});
    add("tyre", "wheel", (struct component_box){{-1.5, -0.9, 0.1}, {-1.1, -0.6, 0.7}});
    struct error error;
    assert_int_equal(group_make(&groups, &components, &error), STATUS_OK);
    assert_int_equal(groups.count, 1);
    assert_string_equal(groups.items[0].name, "wheel");
    assert_int_equal(groups.items[0].component_count, 2);
}

static void more_groups_than_springs_are_refused(void **state)
{
    (void)state;
    for (int i = 0; i <= GROUP_MAX; i++) {
        char name[16];
        snprintf(name, sizeof name, "c%d", i);
        add(name, "", (struct component_box){{-2.0, i, 0.0}, {-1.0, i + 1.0, 1.0}});
        components.items[i].line = (uint32_t)i + 2;
    }
    struct error error = {0};
    assert_int_equal(group_make(&groups, &components, &error), STATUS_INVALID);
    assert_string_equal(error.text,
                        "boxes.csv:66:1: expected at most 64 groups: c64 would be another one");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(named_components_share_their_group, set_up),
        cmocka_unit_test_setup(components_in_line_share_a_spring, set_up),
        cmocka_unit_test_setup(named_groups_take_what_stands_in_line, set_up),
        cmocka_unit_test_setup(more_groups_than_springs_are_refused, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
