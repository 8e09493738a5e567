#include "worker/reduction/reduction.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define HEADER "time_s,node,y_m,z_m,normal_x_N,normal_y_N,shear_x_N,shear_y_N\n"

// One spring at y = -0.5 in front of a face from -1.4 to -0.4; the car comes forwards by 0.1 m in
// each 10 ms, turned by the yaw of the test.
static struct scenario_spring spring;
static struct scenario scenario;
static double times[4] = {0.0, 0.01, 0.02, 0.03};
static double motion_x[4] = {0.0, -0.1, -0.2, -0.15};
static double motion_y[4];
static double motion_yaw[4];
static struct motion motion;

static int set_up(void **state)
{
    (void)state;
    spring = (struct scenario_spring){
        .name = "front", .position = {-0.8, -0.5}, .length = 1.2, .height = NAN};
    scenario = (struct scenario){
        .name = "car",
        .barrier = {.face_x = -2.0, .edge_y = -0.4, .width = 1.0, .overlap = 0.4},
        .springs = &spring,
        .spring_count = 1,
    };
    memset(motion_yaw, 0, sizeof motion_yaw);
    motion = (struct motion){4, times, {motion_x, motion_y, motion_yaw}};
    return 0;
}

// Reads a table, handed over in pieces of whole lines when `by_line`.
static enum status reduce(const char *text, bool by_line, struct design *design,
                          struct reduction_summary *summary, struct error *error)
{
    struct reduction *reduction = reduction_create(&scenario, NULL, &motion, "f.csv", error);
    assert_non_null(reduction);
    enum status status = STATUS_OK;
    const char *end = text + strlen(text);
    while (text < end && status == STATUS_OK) {
        const char *newline = by_line ? strchr(text, '\n') : NULL;
        const char *next = newline != NULL ? newline + 1 : end;
        // A copy of its own, so that a sanitizer sees reading beyond the piece.
        g_autofree char *piece = g_memdup2(text, (gsize)(next - text));
        status = reduction_read(reduction, piece, (size_t)(next - text), error);
        text = next;
    }
    if (status == STATUS_OK) {
        status = reduction_finish(reduction, design, summary, error);
    }
    reduction_free(reduction);
    return status;
}

static const char table[] = HEADER "0,1,-0.5,0.5,0,0,0,0\n"
                                   "# a comment\n"
                                   "0.01,1,-0.5,0.5,-100,0,-20,30\n"
                                   "0.01,2,-0.6,0.5,-80,0,0,0\n"
                                   "\n"
                                   "0.02,1,-0.5,0.5,-300,0,0,60\n"
                                   "0.02,7,-0.2,0.5,-100,0,0,0\n"
                                   "0.03,1,-0.5,0.5,-40,0,0,0\n";

// Forces on the barrier (-x) become forces on the vehicle; sums, branches and what lies outside are
// as one counts by hand. However the table is cut into pieces, it is the same table.
static void curve_is_what_one_counts_by_hand(void **state)
{
    (void)state;
    for (int by_line = 0; by_line < 2; by_line++) {
        struct design design;
        struct reduction_summary summary;
        struct error error;
        assert_int_equal(reduce(table, by_line, &design, &summary, &error), STATUS_OK);
        const struct design_branch *load = &design.springs[0].load;
        assert_int_equal(load->point_count, 3);
        assert_true(fabs(load->deformation[1] - 0.1) < 1e-12);
        assert_true(load->force[0][1] == 200.0 && load->force[1][1] == -30.0);
        assert_true(load->force[0][2] == 300.0 && load->force[1][2] == -60.0);
        const struct design_branch *unload = &design.springs[0].unload;
        assert_int_equal(unload->point_count, 2); // one measured, one beyond
        assert_true(fabs(unload->deformation[0] - 0.15) < 1e-12 && unload->force[0][0] == 40.0);
        assert_true(summary.turned);
        assert_int_equal(summary.node_forces, 6);
        assert_int_equal(summary.times, 4);
        assert_int_equal(summary.outside_count, 1);
        const double sum = hypot(120, 30) + 80 + hypot(300, 60) + 100 + 40;
        assert_true(fabs(summary.outside_share - 100 / sum) < 1e-12);
        assert_true(fabs(summary.impulse[0] - (0.01 * (200 + 400) + 0.005 * 40)) < 1e-9);
        design_fini(&design);
    }
}

// Forces along the road are turned into the axes of a car that has turned.
static void forces_are_turned_into_vehicle_axes(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        motion_yaw[i] = 0.1;
    }
    struct design design;
    struct reduction_summary summary;
    struct error error;
    assert_int_equal(reduce(table, false, &design, &summary, &error), STATUS_OK);
    const struct design_branch *load = &design.springs[0].load;
    const uint32_t last = load->point_count - 1;
    assert_true(fabs(load->force[0][last] - (300 * cos(0.1) - 60 * sin(0.1))) < 1e-9);
    assert_true(fabs(load->force[1][last] - (-60 * cos(0.1) - 300 * sin(0.1))) < 1e-9);
    design_fini(&design);
}

// Every way in which a table can be wrong is told with its place.
static void wrong_tables_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *message;
    } wrong[] = {
        {"", "f.csv:1:1: expected the header time_s"},
        {"time_s,node\n", "f.csv:1:12: expected the header time_s"},
        {"time_s,node,y,z_m\n", "f.csv:1:13: expected the header time_s"},
        {HEADER, "f.csv:2:1: expected at least 2 times, found 0"},
        {HEADER "0,1,-0.5,0.5,1,0,0,0\n", "f.csv:3:1: expected at least 2 times, found 1"},
        {HEADER "0,1,-0.5,0.5,1,0,0\n", "f.csv:2:19: expected 8 fields"},
        {HEADER "0,1,-0.5,0.5,1,0,0,0,0\n", "f.csv:2:22: expected 8 fields"},
        {HEADER "0,1,-0.5,0.5,many,0,0,0\n", "f.csv:2:14: normal_x_N: expected a finite number"},
        {HEADER "0,1,-0.5,0.5,0,nan,0,0\n", "f.csv:2:16: normal_y_N: expected a finite number"},
        {HEADER "0,1,-0.5,0.5,0,0,inf,0\n", "f.csv:2:18: shear_x_N: expected a finite number"},
        {HEADER "0,1.5,-0.5,0.5,0,0,0,0\n", "f.csv:2:3: node: expected a whole number"},
        {HEADER "0,-1,-0.5,0.5,0,0,0,0\n", "f.csv:2:3: node: expected a whole number"},
        {HEADER "0,1,-0.5,0.5,0,0,0,0\n0,1,-0.5,0.5,0,0,0,0\n",
         "f.csv:3:3: node: expected each node once a time, found 1 again"},
        {HEADER "0.02,1,-0.5,0.5,0,0,0,0\n0.01,1,-0.5,0.5,0,0,0,0\n",
         "f.csv:3:1: time_s: expected 0.02 s, the time before, or later, found 0.01"},
        {HEADER "-0.01,1,-0.5,0.5,0,0,0,0\n",
         "f.csv:2:1: time_s: expected 0 to 0.03 s, the times of the motion, found -0.01"},
        {HEADER "0,1,-0.5,0.5,0,0,0,0\n0.04,1,-0.5,0.5,0,0,0,0\n",
         "f.csv:3:1: time_s: expected 0 to 0.03 s"},
        {HEADER "0,1,0.5,0.5,9,0,0,0\n0.01,1,0.5,0.5,9,0,0,0\n",
         "f.csv:4:1: no force lies on any spring's patch"},
        {HEADER "0,1,-0.5,0.5,0,0,0,0\n0.01,1,-0.5,0.5,0,0,0,0\n",
         "f.csv:4:1: no force lies on any spring's patch"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(wrong); i++) {
        for (int by_line = 0; by_line < 2; by_line++) {
            struct design design;
            struct reduction_summary summary;
            struct error error = {0};
            assert_int_equal(reduce(wrong[i].text, by_line, &design, &summary, &error),
                             STATUS_INVALID);
            if (strstr(error.text, wrong[i].message) != error.text) {
                fail_msg("expected: %s\nfound: %s", wrong[i].message, error.text);
            }
        }
    }
}

// No byte of a table can do more than make it wrong: every one is replaced by odd ones in turn.
static void every_odd_byte_is_read_or_refused(void **state)
{
    (void)state;
    static const char odd[] = {'\0', ',', '\n', '-', 'e', '9', '\xff', '#', ' '};
    char text[sizeof table];
    for (size_t at = 0; at + 1 < sizeof table; at++) {
        for (size_t i = 0; i < sizeof odd; i++) {
            memcpy(text, table, sizeof text);
            text[at] = odd[i];
            struct reduction *reduction;
            struct design design;
            struct reduction_summary summary;
            struct error error;
            reduction = reduction_create(&scenario, NULL, &motion, "f.csv", &error);
            if (reduction_read(reduction, text, sizeof text - 1, &error) == STATUS_OK &&
                reduction_finish(reduction, &design, &summary, &error) == STATUS_OK) {
                design_fini(&design);
            }
            reduction_free(reduction);
        }
    }
}

// A hole in the times is told, with its place; forces before a spring is reached are counted.
static void gaps_and_early_forces_are_counted(void **state)
{
    (void)state;
    static const char text[] = HEADER "0,1,-0.5,0.5,30,0,0,0\n"
                                      "0.002,1,-0.5,0.5,100,0,0,0\n"
                                      "0.02,1,-0.5,0.5,70,0,0,0\n";
    spring.length = 1.15; // 50 mm short of the face: reached after 5 ms
    struct design design;
    struct reduction_summary summary;
    struct error error;
    assert_int_equal(reduce(text, false, &design, &summary, &error), STATUS_OK);
    assert_true(fabs(summary.gap - 0.018) < 1e-12 && summary.gap_start == 0.002);
    assert_true(fabs(summary.undeformed_share - 130.0 / 200.0) < 1e-12);
    assert_false(summary.turned);
    design_fini(&design);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(curve_is_what_one_counts_by_hand, set_up),
        cmocka_unit_test_setup(forces_are_turned_into_vehicle_axes, set_up),
        cmocka_unit_test_setup(wrong_tables_are_refused, set_up),
        cmocka_unit_test_setup(every_odd_byte_is_read_or_refused, set_up),
        cmocka_unit_test_setup(gaps_and_early_forces_are_counted, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
