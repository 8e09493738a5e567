// Real crashes: curves of one pair of springs made from the velocity changes that IIHS measured
// must move a sedan as the measured cars moved (tests/data/README.md).
#include "tests/physics/sedan.h"
#include "worker/models/csv.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

enum { TIMES = 8, POINTS = TIMES, RESULTS = KINEMATICS_WORK + 2 };

// The thesis's table 7.1 has mean absolute errors of 10 to 85 mm in x and 3 to 40 mm in y against
// finite-element crashes.
static const double error_x_max = 0.085;
static const double error_y_max = 0.040;

// One group of tests.
struct measured {
    uint32_t count;
    double time[TIMES];     // [s]
    double delta_vx[TIMES]; // [m/s] negative: slower
    double delta_vy[TIMES];
    double travel_x[TIMES]; // [m] forwards
    double travel_y[TIMES];
};

static void read_group(const char *group, struct measured *measured)
{
    static char text[8192];
    FILE *file = fopen(SOBOX_SOURCE_DIR "/tests/data/iihs_small_overlap.csv", "r");
    assert_non_null(file);
    const size_t size = fread(text, 1, sizeof text, file);
    assert_true(size < sizeof text);
    fclose(file);
    struct csv csv;
    struct error error;
    csv_start(&csv, "iihs", text, size);
    measured->count = 0;
    do {
        assert_int_equal(csv_row(&csv, &error), STATUS_OK);
        if (csv.field_count == 0 || !csv_is(&csv.fields[0], group)) {
            continue;
        }
        double *const columns[] = {measured->time, measured->delta_vx, measured->delta_vy,
                                   measured->travel_x, measured->travel_y};
        for (uint32_t i = 0; i < 5; i++) {
            assert_int_equal(
                csv_number(&csv, 2 + i, "column", "SI", &columns[i][measured->count], &error),
                STATUS_OK);
        }
        measured->count++;
    } while (csv.field_count > 0);
    assert_int_equal(measured->count, TIMES);
}

// F = m dv/dt over each interval, at the deformation that the car's travel had in its middle.
static void make_curves(const struct measured *measured, struct sedan *sedan, double *values)
{
    const double mass = sedan->setup.mass;
    values[0] = values[POINTS] = 0.0;
    sedan->deformation[0][0] = 0.0;
    for (uint32_t i = 1; i < TIMES; i++) {
        const double dt = measured->time[i] - measured->time[i - 1];
        const double speed =
            sedan->setup.speed + 0.75 * measured->delta_vx[i - 1] + 0.25 * measured->delta_vx[i];
        sedan->deformation[0][i] = measured->travel_x[i - 1] + speed * dt / 2.0;
        values[i] = -mass * (measured->delta_vx[i] - measured->delta_vx[i - 1]) / dt;
        values[POINTS + i] = mass * (measured->delta_vy[i] - measured->delta_vy[i - 1]) / dt;
    }
    sedan->springs[0].load = (struct kinematics_curve){sedan->deformation[0], POINTS};
}

// Where the paths for the picture go (measured.gnuplot): the folder named by SOBOX_MEASURED_PATHS,
// or NULL.
static FILE *open_paths(const char *group)
{
    const char *folder = getenv("SOBOX_MEASURED_PATHS");
    if (folder == NULL) {
        return NULL;
    }
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.csv", folder, group);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    return file;
}

// Writes the simulated path beside the measured one, an empty line between them.
static void write_paths(const char *group, const struct measured *measured, const double *rows,
                        uint32_t row_count, uint32_t columns)
{
    FILE *file = open_paths(group);
    if (file == NULL) {
        return;
    }
    for (uint32_t i = 0; i < row_count; i++, rows += columns) {
        fprintf(file, "%g,%.5f,%.5f\n", rows[KINEMATICS_COLUMN_TIME], -rows[KINEMATICS_COLUMN_X],
                rows[KINEMATICS_COLUMN_Y]);
    }
    fprintf(file, "\n\n");
    for (uint32_t i = 0; i < TIMES; i++) {
        fprintf(file, "%g,%.5f,%.5f\n", measured->time[i], measured->travel_x[i],
                measured->travel_y[i]);
    }
    fclose(file);
}

// Simulates a group; returns the A-pillar's lateral travel in overlaps.
static double simulate(const char *group, double *error_x, double *error_y)
{
    struct measured measured;
    struct sedan sedan;
    double values[2 * POINTS];
    double results[RESULTS];
    read_group(group, &measured);
    sedan_init(&sedan, 1, 2);
    make_curves(&measured, &sedan, values);
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    const uint32_t columns = kinematics_column_count(problem);
    double *rows = malloc(sizeof *rows * columns * kinematics_row_count(problem));
    kinematics_record(problem, values, results, rows);
    *error_x = *error_y = 0.0;
    for (uint32_t i = 0; i < TIMES; i++) {
        const double *row = rows + columns * lround(measured.time[i] / sedan.setup.time_step);
        *error_x += fabs(-row[KINEMATICS_COLUMN_X] - measured.travel_x[i]) / TIMES;
        *error_y += fabs(row[KINEMATICS_COLUMN_Y] - measured.travel_y[i]) / TIMES;
    }
    write_paths(group, &measured, rows, kinematics_row_count(problem), columns);
    free(rows);
    kinematics_free(problem);
    const double travel = results[KINEMATICS_PILLAR_TRAVEL] / 0.455;
    print_message("%-12s mean absolute error %4.1f mm in x, %4.1f mm in y; AbWAP %.2f\n", group,
                  1e3 * *error_x, 1e3 * *error_y, travel);
    return travel;
}

static void motion_of_measured_cars_is_met(void **state)
{
    (void)state;
    static const char *const groups[] = {"all", "glancing_off", "rotating"};
    for (size_t i = 0; i < sizeof groups / sizeof *groups; i++) {
        double error_x;
        double error_y;
        simulate(groups[i], &error_x, &error_y);
        assert_true(error_x < error_x_max);
        assert_true(error_y < error_y_max);
    }
}

// The groups were told apart by their velocities; the model must tell them apart by the outcome
// that defines the response: cars that glance off bring their A-pillar past the barrier.
static void cars_that_glance_off_bring_the_pillar_past_the_barrier(void **state)
{
    (void)state;
    double error_x;
    double error_y;
    const double glancing_off = simulate("glancing_off", &error_x, &error_y);
    const double rotating = simulate("rotating", &error_x, &error_y);
    assert_true(glancing_off > 1.0);
    assert_true(rotating < 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(motion_of_measured_cars_is_met),
        cmocka_unit_test(cars_that_glance_off_bring_the_pillar_past_the_barrier),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
