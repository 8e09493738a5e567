#include "worker/components/component.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <glib.h>

#include <cmocka.h>

#define HEADER "name,group,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m,z_max_m\n"

static struct component_list list;

static enum status parse(const char *text, struct error *error)
{
    return component_parse(&list, "boxes.csv", text, strlen(text), error);
}

static void assert_wrong(const char *text, const char *message)
{
    struct error error = {0};
    assert_int_equal(parse(text, &error), STATUS_INVALID);
    if (strstr(error.text, message) == NULL) {
        fail_msg("expected \"%s\" in \"%s\"", message, error.text);
    }
}

// Columns stand in any order; a group may be empty, a force may be unknown.
static void boxes_are_read_by_their_column_names(void **state)
{
    (void)state;
    struct error error;
    assert_int_equal(parse("z_max_m,z_min_m,y_max_m,y_min_m,x_max_m,x_min_m,force_x_N,force_y_N,"
                           "group,name\n"
                           "# a comment\n"
                           "0.7,0.1,-0.6,-0.9,-1,-2,80e3,40e3,wheel,tyre\n"
                           "0.8,0.2,-0.4,-0.5,-1,-2,,,,rail\n",
                           &error),
                     STATUS_OK);
    assert_int_equal(list.count, 2);
    assert_string_equal(list.items[0].name, "tyre");
    assert_string_equal(list.items[0].group, "wheel");
    assert_true(list.items[0].box.min[0] == -2.0 && list.items[0].box.max[0] == -1.0);
    assert_true(list.items[0].box.min[1] == -0.9 && list.items[0].box.max[1] == -0.6);
    assert_true(list.items[0].box.min[2] == 0.1 && list.items[0].box.max[2] == 0.7);
    assert_true(list.items[0].force[0] == 80e3 && list.items[0].force[1] == 40e3);
    assert_int_equal(list.items[0].line, 3);
    assert_string_equal(list.items[1].group, "");
    assert_true(isnan(list.items[1].force[0]));
    assert_false(list.forces);
}

// Every complaint says where it stands and what would be right.
static void wrong_tables_are_pointed_at(void **state)
{
    (void)state;
    assert_wrong("", "boxes.csv:1:1: expected the columns name");
    assert_wrong(HEADER, "boxes.csv:2:1: expected at least one component");
    assert_wrong("name,x\n", "boxes.csv:1:6: expected the columns name");
    assert_wrong("name,name\n", "boxes.csv:1:6: expected the column name once");
    assert_wrong("name,group,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m\n", "found no z_max_m");
    assert_wrong(HEADER "a,b,-2,-1,-0.9,-0.6,0.1\n", "boxes.csv:2:24: expected 8 fields");
    assert_wrong(HEADER "a b,,-2,-1,-0.9,-0.6,0.1,0.7\n", "boxes.csv:2:1: name: expected a name");
    assert_wrong(HEADER ",,-2,-1,-0.9,-0.6,0.1,0.7\n", "boxes.csv:2:1: name: expected a name");
    assert_wrong(HEADER "a,,-2,x,-0.9,-0.6,0.1,0.7\n", "boxes.csv:2:7: x_max_m: expected a finite");
    assert_wrong(HEADER "a,,-1,-2,-0.9,-0.6,0.1,0.7\n",
                 "boxes.csv:2:7: x_max_m: expected more than x_min_m, -1 m, found -2");
    assert_wrong(HEADER "a,,-2000,-1000,-900,-600,100,700\n", "in millimetres?");
    assert_wrong(HEADER "a,,-2,-1,-0.9,-0.6,-0.1,0.7\n", "a height above the road within 0 .. 10");
    assert_wrong(HEADER "a,,-2,-1,-0.9,-0.6,0.1,0.7\na,,-2,-1,-0.9,-0.6,0.1,0.7\n",
                 "boxes.csv:3:1: name: expected a name that no other component has, found a");
    assert_wrong("name,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m,z_max_m,force_x_N\n"
                 "a,-2,-1,-0.9,-0.6,0.1,0.7,-5\n",
                 "boxes.csv:2:27: force_x_N: expected at least 0 N, found -5");
}

static void more_components_than_there_is_room_for_are_refused(void **state)
{
    (void)state;
    g_autoptr(GString) text = g_string_new(HEADER);
    for (int i = 0; i <= COMPONENT_MAX; i++) {
        g_string_append_printf(text, "c%d,,-2,-1,-0.9,-0.6,0.1,0.7\n", i);
    }
    assert_wrong(text->str, "boxes.csv:1026:1: expected at most 1024 components");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_are_read_by_their_column_names),
        cmocka_unit_test(wrong_tables_are_pointed_at),
        cmocka_unit_test(more_components_than_there_is_room_for_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
