#include "tests/physics/measured.h"

#include "common/table/csv.h"
#include "tests/physics/sedan.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

enum { POINTS = MEASURED_TIMES, RESULTS = KINEMATICS_WORK + 2, COLUMNS = 8 };

static const double sedan_mass = 1650.0; // [kg] of tests without a weight

static void read_row(const struct csv *csv, struct measured *measured, uint32_t at)
{
    double *const columns[COLUMNS] = {
        &measured->time[at],     &measured->delta_vx[at], &measured->delta_vy[at],
        &measured->travel_x[at], &measured->travel_y[at], &measured->spread_x[at],
        &measured->spread_y[at], &measured->mass,
    };
    struct error error;
    assert_true(at < MEASURED_TIMES);
    for (uint32_t i = 0; i < COLUMNS && 2 + i < csv->field_count; i++) {
        assert_int_equal(csv_number(csv, 2 + i, "column", "SI", columns[i], &error), STATUS_OK);
    }
}

void measured_read(const char *table, const char *group, struct measured *measured)
{
    static char text[16384];
    char path[512];
    snprintf(path, sizeof path, SOBOX_SOURCE_DIR "/tests/data/%s", table);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    const size_t size = fread(text, 1, sizeof text, file);
    assert_true(size < sizeof text);
    fclose(file);
    struct csv csv;
    struct error error;
    uint32_t count = 0;
    *measured = (struct measured){.mass = sedan_mass};
    csv_start(&csv, table, text, size);
    do {
        assert_int_equal(csv_row(&csv, &error), STATUS_OK);
        if (csv.field_count > 0 && csv_is(&csv.fields[0], group)) {
            read_row(&csv, measured, count++);
        }
    } while (csv.field_count > 0);
    assert_int_equal(count, MEASURED_TIMES);
}

// F = m dv/dt over each interval, at the deformation that the car's travel had in its middle.
static void make_curves(const struct measured *measured, struct sedan *sedan, double *values)
{
    values[0] = values[POINTS] = 0.0;
    sedan->deformation[0][0] = 0.0;
    for (uint32_t i = 1; i < POINTS; i++) {
        const double dt = measured->time[i] - measured->time[i - 1];
        const double speed =
            sedan->setup.speed + 0.75 * measured->delta_vx[i - 1] + 0.25 * measured->delta_vx[i];
        sedan->deformation[0][i] = measured->travel_x[i - 1] + speed * dt / 2.0;
        values[i] = -measured->mass * (measured->delta_vx[i] - measured->delta_vx[i - 1]) / dt;
        values[POINTS + i] =
            measured->mass * (measured->delta_vy[i] - measured->delta_vy[i - 1]) / dt;
    }
    sedan->springs[0].load = (struct kinematics_curve){sedan->deformation[0], POINTS};
}

static void write_path(const char *path, const struct measured *target, const double *rows,
                       uint32_t row_count, uint32_t columns)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (uint32_t i = 0; i < row_count; i++, rows += columns) {
        fprintf(file, "%g,%.5f,%.5f\n", rows[KINEMATICS_COLUMN_TIME], -rows[KINEMATICS_COLUMN_X],
                rows[KINEMATICS_COLUMN_Y]);
    }
    fprintf(file, "\n\n");
    for (uint32_t i = 0; i < MEASURED_TIMES; i++) {
        fprintf(file, "%g,%.5f,%.5f\n", target->time[i], target->travel_x[i], target->travel_y[i]);
    }
    fclose(file);
}

void measured_simulate(const struct measured *source, const struct measured *target,
                       struct measured_change change, const char *path,
                       struct measured_outcome *outcome)
{
    struct sedan sedan;
    double values[2 * POINTS];
    double results[RESULTS];
    sedan_init(&sedan, 1, 2);
    sedan.setup.integrator = KINEMATICS_EVENT_VERLET;
    sedan.setup.reloading = KINEMATICS_RELOADING_CRUSHED;
    sedan.setup.yaw_inertia *= change.yaw_inertia * target->mass / sedan_mass;
    sedan.setup.mass = change.mass * target->mass;
    make_curves(source, &sedan, values);
    struct kinematics_problem *problem = kinematics_create(&sedan.setup);
    const uint32_t columns = kinematics_column_count(problem);
    double *rows = malloc(sizeof *rows * columns * kinematics_row_count(problem));
    kinematics_record(problem, values, results, rows);
    double x[MEASURED_TIMES];
    double y[MEASURED_TIMES];
    for (uint32_t i = 0; i < MEASURED_TIMES; i++) {
        const double *row = rows + columns * lround(target->time[i] / sedan.setup.time_step);
        x[i] = -row[KINEMATICS_COLUMN_X];
        y[i] = row[KINEMATICS_COLUMN_Y];
    }
    if (path != NULL) {
        write_path(path, target, rows, kinematics_row_count(problem), columns);
    }
    *outcome = (struct measured_outcome){
        .error_x = measured_distance(x, target->travel_x),
        .error_y = measured_distance(y, target->travel_y),
        .travel = results[KINEMATICS_PILLAR_TRAVEL],
        .length = results[KINEMATICS_LENGTH_MIN],
        .yaw = results[KINEMATICS_YAW],
    };
    free(rows);
    kinematics_free(problem);
}

double measured_distance(const double *a, const double *b)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < MEASURED_TIMES; i++) {
        sum += fabs(a[i] - b[i]) / MEASURED_TIMES;
    }
    return sum;
}
