// Curves from barrier forces (thesis 7.2): a known crash is simulated, its springs' forces are
// spread over nodes of the barrier, reduced to curves again, and those are simulated. The motion
// must come back, with as many springs as the thesis had: 2, 18 and 80 (pairs of one axial and one
// lateral spring: 1, 9 and 40).
#include "worker/kinematics/kinematics.h"
#include "worker/models/small_overlap.h"
#include "worker/reduction/reduction.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { POINTS = 6, NODE_STEP_MM = 5 };

// A sedan whose springs stand in columns between the wheel and the inner end of the overlap, and
// one above the other.
struct crash {
    struct scenario scenario;
    struct scenario_spring springs[SCENARIO_SPRING_MAX];
    struct kinematics_problem *problem; // of the last simulation
    double *rows;                       // of its trajectory
};

static void crash_init(struct crash *crash, uint32_t columns, uint32_t heights, double time_step)
{
    memset(crash, 0, sizeof *crash);
    crash->scenario = (struct scenario){
        .name = "sedan",
        .vehicle = {.mass = 1650.0, .yaw_inertia = 3000.0, .speed = 17.889},
        .barrier = {.face_x = -2.08, .edge_y = -0.455, .width = 1.15, .overlap = 0.455},
        .springs = crash->springs,
        .spring_count = columns * heights,
        .simulation = {.duration = 0.150, .time_step = time_step},
    };
    for (uint32_t i = 0; i < columns * heights; i++) {
        const double inwards = columns > 1 ? (double)(i % columns) / (columns - 1) : 0.0;
        crash->springs[i] = (struct scenario_spring){
            .position = {-0.83, -0.75 + 0.24 * inwards},
            .length = 1.25,
            .height = heights > 1 ? 0.3 + 0.15 * (i / columns) : NAN,
        };
        g_snprintf(crash->springs[i].name, SCENARIO_NAME_SIZE, "spring-%u", i);
    }
}

static void crash_fini(struct crash *crash)
{
    kinematics_free(crash->problem);
    g_free(crash->rows);
}

// Curves that differ from spring to spring; together they carry what a sedan's front does.
static void make_design(const struct crash *crash, struct design *design)
{
    static const double level_x[POINTS] = {30e3, 90e3, 300e3, 340e3, 280e3, 380e3};
    static const double level_y[POINTS] = {5e3, 40e3, 120e3, 150e3, 170e3, 150e3};
    const double share = 1.0 / crash->scenario.spring_count;
    design_init(design, &crash->scenario);
    for (uint32_t i = 0; i < crash->scenario.spring_count; i++) {
        const double own = 1.0 + 0.3 * sin(1.7 * i);
        for (int k = 0; k < POINTS; k++) {
            design_add(&design->springs[i].load, 0.25 * k, own * share * level_x[k],
                       share * level_y[k] * (2.0 - own));
        }
        design_add(&design->springs[i].unload, 0.2, 0.0, 0.0);
        design_add(&design->springs[i].unload, 1.0, share * 20e3, share * 5e3);
    }
}

static void simulate(struct crash *crash, const struct design *design)
{
    crash_fini(crash);
    crash->problem =
        small_overlap_problem(&crash->scenario, design, (struct kinematics_omitted){0});
    const uint32_t value_count = kinematics_value_count(crash->problem);
    g_autofree double *values = g_new(double, value_count);
    g_autofree double *results = g_new(double, kinematics_result_count(crash->problem));
    small_overlap_values(design, values);
    crash->rows = g_new(double, (size_t)kinematics_row_count(crash->problem) *
                                    kinematics_column_count(crash->problem));
    kinematics_record(crash->problem, values, results, crash->rows);
}

static const double *row_of(const struct crash *crash, uint32_t step)
{
    return crash->rows + (size_t)step * kinematics_column_count(crash->problem);
}

// Spreads the force that acts at (y, z) evenly over the nodes of a grid up to `reach` away in y.
// Each spring has a grid of its own, so that no node stands in the table twice.
static void spread(GString *text, uint32_t spring, double time, double y, double z, double reach,
                   const double force[2])
{
    const double step = 1e-3 * NODE_STEP_MM;
    const double edge = -0.455;
    const int first = (int)ceil((y - reach) / step);
    const int last = (int)floor(fmin(y + reach, edge) / step);
    for (int i = first; i <= last; i++) {
        const double part = 1.0 / (last - first + 1);
        const int node = i + 10000 + 100000 * (int)spring;
        g_string_append_printf(text, "%.17g,%d,%.17g,%g,%.17g,0,0,%.17g\n", time, node,
                               fmin(i * step, edge), z, part * force[0], part * force[1]);
    }
}

// The table of node forces of a crash at every `stride`-th step; each spring's force reaches
// `reach` to either side of its projection.
static GString *node_forces(const struct crash *crash, uint32_t stride, double reach)
{
    GString *text = g_string_new("time_s,node,y_m,z_m,normal_x_N,normal_y_N,shear_x_N,shear_y_N\n");
    for (uint32_t step = 0; step < kinematics_row_count(crash->problem); step += stride) {
        const double *row = row_of(crash, step);
        const double yaw = row[KINEMATICS_COLUMN_YAW];
        const double way = row[KINEMATICS_COLUMN_X] - crash->scenario.barrier.face_x;
        for (uint32_t i = 0; i < crash->scenario.spring_count; i++) {
            const double *spring =
                row + KINEMATICS_COLUMN_SPRING + i * KINEMATICS_SPRING_COLUMN_COUNT;
            const double x = spring[KINEMATICS_SPRING_FORCE_X];
            const double y = spring[KINEMATICS_SPRING_FORCE_Y];
            const double force[2] = {cos(yaw) * x - sin(yaw) * y, sin(yaw) * x + cos(yaw) * y};
            const double projection = row[KINEMATICS_COLUMN_Y] - way * tan(yaw) +
                                      crash->springs[i].position[1] / cos(yaw);
            const double height = crash->springs[i].height;
            if (spring[KINEMATICS_SPRING_CONTACT] > 0.0) {
                spread(text, i, row[KINEMATICS_COLUMN_TIME], projection,
                       isnan(height) ? 0.5 : height, reach, force);
            }
        }
        if (step == 0 || step + stride >= kinematics_row_count(crash->problem)) {
            // A time at which nothing acts stands in the table with a force of nothing.
            g_string_append_printf(text, "%.17g,1,-0.5,0.5,0,0,0,0\n", row[KINEMATICS_COLUMN_TIME]);
        }
    }
    return text;
}

static void take_motion(const struct crash *crash, struct motion *motion)
{
    static const enum kinematics_column columns[MOTION_QUANTITY_COUNT] = {
        [MOTION_X] = KINEMATICS_COLUMN_X,
        [MOTION_Y] = KINEMATICS_COLUMN_Y,
        [MOTION_YAW] = KINEMATICS_COLUMN_YAW,
    };
    motion->count = kinematics_row_count(crash->problem);
    motion->time = g_new(double, motion->count);
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        motion->value[k] = g_new(double, motion->count);
    }
    for (uint32_t i = 0; i < motion->count; i++) {
        motion->time[i] = row_of(crash, i)[KINEMATICS_COLUMN_TIME];
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            motion->value[k][i] = row_of(crash, i)[columns[k]];
        }
    }
}

// Mean absolute errors of a simulated motion.
static void compare(const struct crash *crash, const struct motion *motion,
                    double errors[MOTION_QUANTITY_COUNT])
{
    const uint32_t columns = kinematics_column_count(crash->problem);
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        errors[k] = motion_error(
            motion, (enum motion_quantity)k, crash->rows + KINEMATICS_COLUMN_TIME,
            crash->rows + KINEMATICS_COLUMN_X + k, kinematics_row_count(crash->problem), columns);
    }
}

// Reduces the forces of `truth` to curves of `model` and simulates those.
static void reduce_and_simulate(const struct crash *truth, struct crash *model, uint32_t stride,
                                double reach, struct reduction_summary *summary,
                                double errors[MOTION_QUANTITY_COUNT])
{
    struct error error = {0};
    struct motion motion = {0};
    struct design design;
    take_motion(truth, &motion);
    GString *table = node_forces(truth, stride, reach);
    struct reduction *reduction =
        reduction_create(&model->scenario, NULL, &motion, "table", &error);
    assert_non_null(reduction);
    if (reduction_read(reduction, table->str, table->len, &error) != STATUS_OK ||
        reduction_finish(reduction, &design, summary, &error) != STATUS_OK) {
        fail_msg("%s", error.text);
    }
    simulate(model, &design);
    compare(model, &motion, errors);
    print_message("%3u springs from %3u: mean absolute error %.2g mm in x, %.2g mm in y, %.2g "
                  "mrad in yaw\n",
                  2 * model->scenario.spring_count, 2 * truth->scenario.spring_count,
                  1e3 * errors[MOTION_X], 1e3 * errors[MOTION_Y], 1e3 * errors[MOTION_YAW]);
    reduction_free(reduction);
    design_fini(&design);
    motion_fini(&motion);
    g_string_free(table, TRUE);
}

static const struct {
    uint32_t columns;
    uint32_t heights;
} sizes[] = {{1, 1}, {3, 3}, {10, 4}};

// The forces of every step, each within the patch of its spring: nothing is lost, so the curves
// hold every force that acted and the same motion follows, but for rounding.
static void same_springs_give_the_same_motion(void **state)
{
    (void)state;
    for (size_t i = 0; i < G_N_ELEMENTS(sizes); i++) {
        struct crash crash;
        struct crash again;
        struct design design;
        struct reduction_summary summary;
        double errors[MOTION_QUANTITY_COUNT];
        crash_init(&crash, sizes[i].columns, sizes[i].heights, 1e-3);
        crash_init(&again, sizes[i].columns, sizes[i].heights, 1e-3);
        make_design(&crash, &design);
        simulate(&crash, &design);
        reduce_and_simulate(&crash, &again, 1, 0.011, &summary, errors);
        assert_true(summary.outside_share == 0.0 && summary.undeformed_share == 0.0);
        assert_true(summary.repeated_share < 1e-3 && !summary.turned);
        for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
            assert_true(errors[k] < 1e-9);
        }
        design_fini(&design);
        crash_fini(&crash);
        crash_fini(&again);
    }
}

// The way of the thesis: a crash of many components, its forces written once a millisecond and
// spread wider than a patch, seen through 2, 18 and 80 springs. One pair has the forces right and
// their place wrong; the more springs, the better the place.
static void fewer_springs_come_near(void **state)
{
    (void)state;
    struct crash crash;
    struct design design;
    double errors[G_N_ELEMENTS(sizes)][MOTION_QUANTITY_COUNT];
    crash_init(&crash, 10, 4, 1e-4);
    make_design(&crash, &design);
    simulate(&crash, &design);
    for (size_t i = 0; i < G_N_ELEMENTS(sizes); i++) {
        struct crash model;
        struct reduction_summary summary;
        crash_init(&model, sizes[i].columns, sizes[i].heights, 1e-4);
        reduce_and_simulate(&crash, &model, 10, 0.05, &summary, errors[i]);
        assert_true(errors[i][MOTION_X] < 0.020 && errors[i][MOTION_Y] < 0.020);
        crash_fini(&model);
    }
    assert_true(errors[2][MOTION_YAW] < errors[0][MOTION_YAW]);
    design_fini(&design);
    crash_fini(&crash);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_springs_give_the_same_motion),
        cmocka_unit_test(fewer_springs_come_near),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
