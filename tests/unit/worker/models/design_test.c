#include "worker/models/design.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define HEADER "spring,branch,deformation_m,force_x_N,force_y_N\n"

// A scenario with the springs "front" and "rear", which is all that a design looks at.
static struct scenario_spring springs[2];
static struct scenario scenario;

static int set_up(void **state)
{
    (void)state;
    memset(springs, 0, sizeof springs);
    strcpy(springs[0].name, "front");
    strcpy(springs[1].name, "rear");
    for (int i = 0; i < 2; i++) {
        springs[i].point_count = 3;
        for (int point = 0; point < 3; point++) {
            springs[i].deformation[point] = 0.5 * point;
            springs[i].force_lower[SCENARIO_DIRECTION_X][point] = 10.0 * point;
            springs[i].force_upper[SCENARIO_DIRECTION_X][point] = 30.0 * point;
            springs[i].force_upper[SCENARIO_DIRECTION_Y][point] = 8.0;
        }
    }
    scenario = (struct scenario){.springs = springs, .spring_count = 2};
    return 0;
}

static void places_of_the_design_space_are_designs(void **state)
{
    (void)state;
    static const struct {
        enum design_place place;
        double x;
        double y;
    } cases[] = {{DESIGN_CENTRE, 40.0, 4.0}, {DESIGN_LOWER, 20.0, 0.0}, {DESIGN_UPPER, 60.0, 8.0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct design design;
        design_init_place(&design, &scenario, cases[i].place);
        assert_int_equal(design.spring_count, 2);
        const struct design_branch *load = &design.springs[1].load;
        assert_int_equal(load->point_count, 3);
        assert_true(load->deformation[2] == 1.0);
        assert_true(load->force[SCENARIO_DIRECTION_X][2] == cases[i].x);
        assert_true(load->force[SCENARIO_DIRECTION_Y][2] == cases[i].y);
        assert_int_equal(design.springs[1].unload.point_count, 0);
        design_fini(&design);
    }
}

// Rows of several springs and branches may be mixed: a file sorted by deformation is such a one.
static void rows_stand_in_any_order(void **state)
{
    (void)state;
    static const char text[] = HEADER "rear,load,0,1,2\n"
                                      "front,load,0.1,3,4\n"
                                      "front,unload,0.2,5,6\n"
                                      "rear,load,0.5,7,8\n"
                                      "front,load,0.4,9e3,-10\n"
                                      "front,unload,0.3,11,12\n";
    struct design design;
    struct error error;
    assert_int_equal(design_parse(&design, &scenario, "d.csv", text, strlen(text), &error),
                     STATUS_OK);
    const struct design_spring *front = &design.springs[0];
    assert_int_equal(front->load.point_count, 2);
    assert_true(front->load.deformation[1] == 0.4);
    assert_true(front->load.force[SCENARIO_DIRECTION_X][1] == 9e3);
    assert_true(front->load.force[SCENARIO_DIRECTION_Y][1] == -10.0);
    assert_int_equal(front->unload.point_count, 2);
    assert_true(front->unload.force[SCENARIO_DIRECTION_Y][0] == 6.0);
    assert_int_equal(design.springs[1].load.point_count, 2);
    assert_int_equal(design.springs[1].unload.point_count, 0);
    design_fini(&design);
}

#define REAR "rear,load,0,1,2\nrear,load,1,1,2\n"

// Whatever is wrong, the message says where and what would be right, and nothing is kept.
static void what_is_wrong_is_named_with_its_place(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *place;
        const char *says;
    } cases[] = {
        {"", "d.csv:1:1: ", "expected the header"},
        {"spring,branch,deformation,force_x_N,force_y_N\n", "d.csv:1:15: ", "deformation_m"},
        {"spring,branch,deformation_m,force_x_N\n", "d.csv:1:38: ", "force_y_N"},
        {"spring,branch,deformation_m,force_x_N,force_y_N,z\n", "d.csv:1:49: ", "header"},
        {HEADER "front,load,0,1\n", "d.csv:2:15: ", "found 4"},
        {HEADER "front,load,0,1,2,3\n", "d.csv:2:18: ", "found 6"},
        {HEADER "middle,load,0,1,2\n", "d.csv:2:1: ", "front, rear"},
        {HEADER "front,loading,0,1,2\n", "d.csv:2:7: ", "load or unload"},
        {HEADER "front,load,x,1,2\n", "d.csv:2:12: ", "finite"},
        {HEADER "front,load,0,nan,2\n", "d.csv:2:14: ", "finite"},
        {HEADER "front,load,0,1,inf\n", "d.csv:2:16: ", "finite"},
        {HEADER "front,load,0.5,1,2\nfront,load,0.5,1,2\n", "d.csv:3:12: ", "more than 0.5 m"},
        {HEADER "front,load,0.5,1,2\nfront,load,0.4,1,2\n", "d.csv:3:12: ", "more than 0.5 m"},
        {HEADER REAR, "d.csv:4:1: ", "spring front: expected at least 2 points of the branch load"},
        {HEADER REAR "front,load,0,1,2\n", "d.csv:5:1: ", "found 1"},
        {HEADER REAR "front,load,0,1,2\nfront,load,1,1,2\nfront,unload,0,1,2\n",
         "d.csv:7:1: ", "branch unload"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct design design;
        struct error error = {0};
        assert_int_equal(
            design_parse(&design, &scenario, "d.csv", cases[i].text, strlen(cases[i].text), &error),
            STATUS_INVALID);
        assert_null(design.springs);
        if (strncmp(error.text, cases[i].place, strlen(cases[i].place)) != 0 ||
            strstr(error.text, cases[i].says) == NULL) {
            fail_msg("expected %s... %s, found %s", cases[i].place, cases[i].says, error.text);
        }
    }
}

// Cutting a good file anywhere gives an error or a design, never a crash.
static void files_cut_anywhere_are_survived(void **state)
{
    (void)state;
    static const char text[] = HEADER "front,load,0,1,2\nfront,load,1,1,2\n" REAR;
    for (size_t size = 0; size <= sizeof text - 1; size++) {
        struct design design;
        struct error error;
        if (design_parse(&design, &scenario, "d.csv", text, size, &error) == STATUS_OK) {
            design_fini(&design);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(places_of_the_design_space_are_designs, set_up),
        cmocka_unit_test_setup(rows_stand_in_any_order, set_up),
        cmocka_unit_test_setup(what_is_wrong_is_named_with_its_place, set_up),
        cmocka_unit_test_setup(files_cut_anywhere_are_survived, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
