#include "worker/components/reference.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static struct reference_list list;

static void assert_wrong(const char *text, const char *message)
{
    struct error error = {0};
    assert_int_equal(reference_parse(&list, "c.csv", text, strlen(text), &error), STATUS_INVALID);
    assert_int_equal(list.count, 0);
    if (strstr(error.text, message) == NULL) {
        fail_msg("expected \"%s\" in \"%s\"", message, error.text);
    }
}

// A design is a reference: its unload branches are passed over, and so is what goes back or hardly
// on; rows of springs may be mixed.
static void curves_are_read_as_they_go_on(void **state)
{
    (void)state;
    static const char text[] = "spring,branch,deformation_m,force_x_N,force_y_N\n"
                               "wheel,load,0,0,0\n"
                               "rail,load,0.1,5,1\n"
                               "wheel,load,0.2,100,10\n"
                               "wheel,load,0.15,90,9\n"
                               "wheel,load,0.20005,101,9\n"
                               "wheel,load,0.3,120,12\n"
                               "wheel,unload,0.4,0,0\n"
                               "rail,load,0.4,7,2\n";
    struct error error;
    assert_int_equal(reference_parse(&list, "c.csv", text, strlen(text), &error), STATUS_OK);
    assert_int_equal(list.count, 2);
    const struct reference *wheel = reference_find(&list, "wheel");
    assert_int_equal(wheel->count, 3);
    assert_int_equal(wheel->passed, 2);
    assert_true(wheel->deformation[2] == 0.3);
    assert_true(wheel->force[SCENARIO_DIRECTION_X][1] == 100.0);
    assert_true(wheel->force[SCENARIO_DIRECTION_Y][2] == 12.0);
    assert_null(reference_find(&list, "dome"));
    reference_fini(&list);
    assert_int_equal(list.count, 0);
}

static void wrong_curves_are_pointed_at(void **state)
{
    (void)state;
    assert_wrong("", "c.csv:1:1: expected the columns spring");
    assert_wrong("spring,deformation_m\n", "found no force_x_N");
    assert_wrong("spring,deformation_m,force_x_N\n", "expected a curve of at least one spring");
    assert_wrong("spring,deformation_m,force_x_N\na,0,1\n",
                 "spring a: expected at least 2 points that ascend by 0.1 mm");
    assert_wrong("spring,deformation_m,force_x_N\na,0,1\na,x,1\n", "c.csv:3:3: deformation_m: ");
    assert_wrong("spring,deformation_m,force_x_N\na,0,1\na,200,1\n", "in millimetres?");
    assert_wrong("spring,deformation_m,force_x_N\na,0,1\na,0.1\n", "c.csv:3:6: expected 3 fields");
    assert_wrong("spring,deformation_m,force_x_N\na b,0,1\n", "c.csv:2:1: spring: expected a name");
    assert_wrong("spring,branch,deformation_m,force_x_N\na,up,0,1\n",
                 "c.csv:2:3: branch: expected load or unload");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_are_read_as_they_go_on),
        cmocka_unit_test(wrong_curves_are_pointed_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
